"""Timing, goals and report, with a clock that is told what to say."""

import itertools

import pytest

from vr_envs.bench import timing
from vr_envs.bench.speed import measure as speed
from vr_envs.bench.speed import training
from vr_envs.bench.speed.account import account
from vr_envs.bench.speed.contestants import CARTPOLE, Case
from vr_envs.bench.speed.goals import Goal, goals
from vr_envs.bench.speed.measure import NATIVE, SCALAR, SYNC, Measured, Shared, Speed
from vr_envs.bench.speed.picture import picture
from vr_envs.bench.timing import Spread


def spread(value):
    return Spread(0.9 * value, value, 1.1 * value)


def test_rate_is_rows_over_the_seconds_of_a_call(toy, monkeypatch):
    # a clock that goes on by one second each time it is read: every timing lasts 1 s, for one call
    monkeypatch.setattr(timing.time, "process_time", itertools.count(0.0, 1.0).__next__)
    found = speed.measure([Case(toy, None)], [7], 3, 1.0)
    assert found.of(Case(toy, None).label, NATIVE, 7) == Spread(7.0, 7.0, 7.0)
    assert found.of(Case(toy, None).label, SCALAR, 1) == found.of(CARTPOLE, SCALAR, 1) == Spread(1.0, 1.0, 1.0)
    assert found.impacts == {}


def test_threads_share_the_rows_and_are_timed_by_the_wall(toy, monkeypatch):
    clock = itertools.count(0.0, 2.0)
    monkeypatch.setattr(speed.time, "perf_counter", lambda: next(clock))
    found = speed.in_threads(Case(toy, None), 8, 2, 3, 2.0)
    assert (found.rows, found.threads) == (8, 2)
    # 2 s, whatever is done: ten calls were asked for in 2 s
    assert found.alone == found.shared == Spread(40.0, 40.0, 40.0)


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
    speeds += [Speed(LABEL, SYNC, 64, spread(2e5))]
    return Measured(speeds, [Shared(LABEL, 4096, 2, spread(1e7), spread(1.5e7))], {})


def test_goals_compare_medians_with_what_was_aimed_at():
    found = goals([CASE], measured())
    assert [(g.unit, g.wanted, pytest.approx(g.found), g.met) for g in found] == [
        ("million steps/s", 30.0, 31.0, True),
        (f"times {CARTPOLE}", 1.0, 1.5, True),
        ("times NumPy", 10.0, 15.5, True),
        ("times NumPy", 3.0, 31.0 / 12.0, False),
    ]
    assert goals([CASE], Measured([], [], {})) == []
    assert Goal("", "", 1.0, 1.0).met


def test_the_report_says_what_the_numbers_say(tmp_path):
    timings = measured()
    aims = goals([CASE], timings)
    trained = [
        {"env_id": "a", "vec_env": "x", "rows": 8, "steps": 4000, "environments": 0.6, "policy": 0.2, "update": 0.2},
        {"env_id": "a", "vec_env": "y", "rows": 8, "steps": 4000, "environments": 0.1, "policy": 0.2, "update": 0.2},
    ]
    report = account([CASE], [64, 1024, 4096], timings, aims, trained, ["Nothing else."])
    assert report.sentences == [
        "3 of 4 goals are met on this machine.",
        f"Not met: {LABEL}, native batch of 4096: 2.58 times NumPy for 3.",
        f"{LABEL}: the native batch makes 15.5 at 64, 2.6 at 4096 rows times the steps of NumPy.",
        "a: in training, 8 environments take 17 % of the CPU time in a native batch that they take one by one.",
        "Nothing else.",
    ]
    text = report.text()
    for line in (
        "31 (27.9 to 34.1)", "3.33 (3.03 to 3.7) |                   1.50", "|  1.50 |", "4.0 |         60 %",
        "at least 3 times NumPy", "not met",
    ):  # fmt: skip
        assert line in text, line
    report.figures["rows"] = picture([CASE], timings)
    written = {path.name for path in report.write(tmp_path)}
    assert written == {"speed.json", "speed.md", "speed-rows.png"}


def test_training_is_left_out_with_a_sentence_where_there_is_no_clone(monkeypatch, tmp_path):
    assert training.missing() is None
    monkeypatch.setattr(training, "CLONE", tmp_path)
    assert "clone" in training.missing()
