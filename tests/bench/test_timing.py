import itertools

import pytest

from vr_envs.bench import timing
from vr_envs.bench.timing import calls_for, per_call


class Clock:
    """CPU time that only works make pass."""

    def __init__(self, monkeypatch):
        self.now = 0.0
        monkeypatch.setattr(timing.time, "process_time", lambda: self.now)

    def work(self, seconds, log=None):
        """One that takes the next of `seconds` at each call."""
        costs = iter(seconds)

        def call():
            self.now += next(costs)
            if log is not None:
                log.append(call)

        return call


def test_what_comes_first_does_not_count(monkeypatch):
    """A compilation, then a cost that grows: the later half of the calls tells."""
    clock = Clock(monkeypatch)
    work = clock.work([50.0, 0.1, 0.1, 0.5, 0.5, 0.5])
    assert calls_for(work, 3.0, warm_up=6) == 6
    with pytest.raises(StopIteration):  # it was called six times
        work()


@pytest.mark.parametrize(("whole", "expected"), [(1, 10), (4, 8), (7, 7), (11, 11), (20, 20), (21, 10), (1000, 10)])
def test_a_timing_is_whole_where_that_takes_at_most_twice_as_long(monkeypatch, whole, expected):
    clock = Clock(monkeypatch)
    assert calls_for(clock.work(itertools.repeat(0.125)), 1.25, whole=whole) == expected


def test_there_is_a_call_and_an_end_of_calls(monkeypatch):
    clock = Clock(monkeypatch)
    assert calls_for(clock.work(itertools.repeat(9.0)), 0.1) == 1
    assert calls_for(clock.work(itertools.repeat(0.0)), 0.1) == 100_000  # a clock that does not tick


def test_works_are_timed_in_turn_to_and_fro(monkeypatch):
    clock, log = Clock(monkeypatch), []
    one, other = (clock.work(itertools.repeat(cost), log) for cost in (0.5, 0.25))
    assert per_call([one, other], 3, 1.0, 2) == [[0.5] * 3, [0.25] * 3]
    assert [work is one for work, _ in itertools.groupby(log)] == [True, False, True, False, True, False]
    assert (log.count(one), log.count(other)) == (2 + 3 * 2, 2 + 3 * 4)
    with pytest.raises(ValueError, match="at least 1"):
        per_call([one], 0, 1.0)
