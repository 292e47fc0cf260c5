"""Timing, goals and report, with a clock that is told what to say."""

import itertools

import pytest

from vr_envs.bench import timing
from vr_envs.bench.speed import ahead, training
from vr_envs.bench.speed import measure as speed
from vr_envs.bench.speed.account import account
from vr_envs.bench.speed.contestants import CARTPOLE, Case
from vr_envs.bench.speed.goals import Goal, goals
from vr_envs.bench.speed.measure import JAX, NATIVE, SCALAR, SYNC, Measured, Shared, Speed
from vr_envs.bench.speed.picture import picture
from vr_envs.bench.timing import Spread


def spread(value):
    return Spread(0.9 * value, value, 1.1 * value)


def test_rate_is_rows_over_the_seconds_of_a_call(toy, monkeypatch):
    # a clock that goes on by one second each time it is read: 12 calls last 1 s, and so does the one of a timing
    monkeypatch.setattr(timing.time, "process_time", itertools.count(0.0, 1.0).__next__)
    found = speed.measure([Case(toy, None)], [7], 3, 1.0 / 12)
    assert found.of(Case(toy, None).label, NATIVE, 7) == Spread(7.0, 7.0, 7.0)
    assert found.of(Case(toy, None).label, SCALAR, 1) == found.of(CARTPOLE, SCALAR, 1) == Spread(1.0, 1.0, 1.0)
    assert (found.impacts, found.repeats, found.seconds) == ({}, 3, 1.0 / 12)


def test_threads_share_the_rows_and_are_timed_by_the_wall(toy, monkeypatch):
    clock = itertools.count(0.0, 2.0)
    monkeypatch.setattr(speed.time, "perf_counter", lambda: next(clock))
    calls = []
    original = speed.native

    def counted(case, rows):
        work = original(case, rows)
        return lambda: calls.append(rows) or work()

    monkeypatch.setattr(speed, "native", counted)
    found = speed.in_threads(Case(toy, None), 11, 3, 3, 2.0)
    assert (found.rows, found.threads) == (11, 3)
    # 2 s, whatever is done: as many calls as before the clock starts
    rate = 11 * speed.SETTLED / 2.0
    assert found.alone == found.shared == Spread(rate, rate, rate)
    # all rows are in some part; one batch and its parts are timed in turn, and first by turns
    assert {size: calls.count(size) for size in set(calls)} == {
        11: 4 * speed.SETTLED, 4: 8 * speed.SETTLED, 3: 4 * speed.SETTLED
    }  # fmt: skip
    order = [alone for alone, _ in itertools.groupby(size == 11 for size in calls)]
    assert order == [True, False, True, False, True, False]


def test_all_forms_have_made_equally_many_steps_when_the_clock_starts(toy, monkeypatch):
    """And a timing of a native batch is a whole number of episodes."""
    seen = {}

    def timed(works, repeats, seconds, warm_up, wholes):
        seen.update(warm_up=warm_up, wholes=wholes)
        return [[1.0] * repeats for _ in works]

    monkeypatch.setattr(speed, "per_call", timed)
    speed.rates(Case(toy, None), 2, False, 3, 0.1)
    steps = speed.limit_of(toy)
    assert seen == {"warm_up": speed.SETTLED, "wholes": [steps + 1, steps + 1]}
    assert speed.episode_calls(Case(toy, None), "NumPy") == steps


def test_what_is_compiled_ahead_are_the_kernels_of_both_kinds():
    works = ahead.works_of([CASE, CASE, Case("vr_envs/BallOnBar-v0", None)])
    assert [(work.env_id, work.scene, work.lockstep) for work in works] == [
        ("vr_envs/TerrainRide-v0", {"base": "lecture"}, False),
        ("vr_envs/TerrainRide-v0", {"base": "lecture"}, True),
        ("vr_envs/BallOnBar-v0", {"base": "bell"}, False),
    ]


@pytest.mark.parametrize(("rows", "repeats"), [([0], 1), ([1], 0)])
def test_nothing_to_measure_is_refused(toy, rows, repeats):
    with pytest.raises(ValueError, match="at least 1"):
        speed.measure([Case(toy, None)], rows, repeats, 0.01)


CASE = Case("vr_envs/TerrainRide-v0", "lecture", "full range", 30e6)
LABEL = CASE.label


def measured(native=31e6, scalar=3e5):
    speeds = [Speed(CARTPOLE, SCALAR, 1, spread(2e5)), Speed(LABEL, SCALAR, 1, spread(scalar))]
    speeds += [Speed(LABEL, NATIVE, rows, spread(native)) for rows in (64, 1024, 4096)]
    speeds += [Speed(LABEL, "NumPy", 64, spread(2e6)), Speed(LABEL, "NumPy", 4096, spread(12e6))]
    speeds += [Speed(LABEL, SYNC, 64, spread(2e5)), Speed(LABEL, JAX, 64, spread(25e3))]
    return Measured(speeds, [Shared(LABEL, 4096, 2, spread(1e7), spread(1.5e7))], {}, 5, 0.06)


def test_goals_compare_medians_with_what_was_aimed_at():
    found = goals([CASE], measured())
    assert [(g.unit, g.wanted, pytest.approx(g.found), g.met) for g in found] == [
        ("million steps/s", 30.0, 31.0, True),
        (f"times {CARTPOLE}", 1.0, 1.5, True),
        ("times NumPy", 10.0, 15.5, True),
        ("times NumPy", 3.0, 31.0 / 12.0, False),
    ]
    assert goals([CASE], Measured([], [], {}, 5, 0.06)) == []
    assert Goal("", "", 1.0, 1.0).met


def test_the_report_says_what_the_numbers_say(tmp_path):
    timings = measured()
    aims = goals([CASE], timings)
    trained = [
        {"env_id": "a", "vec_env": name, "rows": 8, "steps": 4000, "environments": times, "policy": [0.2] * 3,
         "update": [0.2] * 3} for name, times in (("x", [0.6, 0.6, 0.4]), ("y", [0.1, 0.1, 0.1]))
    ]  # fmt: skip
    report = account([CASE], [64, 1024, 4096], timings, aims, trained, ["Nothing else."])
    assert report.sentences == [
        "3 of 4 goals are met on this machine.",
        f"Not met: {LABEL}, native batch of 4096: 2.58 times NumPy for 3.",
        f"{LABEL}: the native batch makes 15.5 times the steps of NumPy at 64 rows, 2.58 times at 4096.",
        f"{LABEL}: the native batch makes 1240 times the steps of JAX at 64 rows.",
        "a: in training, 8 environments take 17 (17 to 25) % of the CPU time in a native batch that they take one by "
        "one.",
        "Nothing else.",
    ]
    text = report.text()
    for line in (
        "31 (27.9 to 34.1)", "3.33 (3.03 to 3.7) |                   1.50", "|  1.50 |", "4 (4 to 5)",
        "60 (50 to 60)", "5 timings", "one in 1001 ", "lax.scan", "at least 3 times NumPy", "not met",
    ):  # fmt: skip
        assert line in text, line
    report.figures["rows"] = picture([CASE], timings)
    written = {path.name for path in report.write(tmp_path)}
    assert written == {"speed.json", "speed.md", "speed-rows.png"}


def test_training_is_left_out_with_a_sentence_where_something_is_missing(monkeypatch, tmp_path):
    monkeypatch.setattr(training, "CLONE", tmp_path)
    assert "in a clone" in training.missing()
    (tmp_path / "agents").mkdir()
    (tmp_path / "agents" / "speed.py").touch()
    monkeypatch.setattr(training.importlib.util, "find_spec", lambda name: None if name == "torch" else name)
    assert "pip install '.[agents]'" in training.missing()
    monkeypatch.setattr(training.importlib.util, "find_spec", lambda name: name)
    assert training.missing() is None
