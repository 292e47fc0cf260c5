import itertools

import pytest

from vr_envs.bench import speed


def test_rate_is_rows_times_calls_per_second_of_the_clock(toy, monkeypatch):
    # a clock that goes on by one second each time it is read: every timing lasts 1 s, for one call of step
    monkeypatch.setattr(speed.time, "process_time", itertools.count(0.0, 1.0).__next__)
    found = speed.measure(toy, 7, repeats=3, seconds=1.0)
    assert (found.env_id, found.rows, found.repeats) == (toy, 7, 3)
    assert found.minimum == found.median == found.maximum == 7.0


def test_real_clock_gives_ordered_rates_for_every_pair(toy):
    found = speed.compare([toy], [1, 16], repeats=2)
    assert [(s.env_id, s.rows) for s in found] == [(toy, 1), (toy, 16)]
    assert all(0.0 < s.minimum <= s.median <= s.maximum for s in found)


@pytest.mark.parametrize(("rows", "repeats"), [(0, 1), (1, 0)])
def test_nothing_to_measure_is_refused(toy, rows, repeats):
    with pytest.raises(ValueError, match="at least 1"):
        speed.measure(toy, rows, repeats)
