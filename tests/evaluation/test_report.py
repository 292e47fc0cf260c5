import json
import math
import sys

import numpy as np
import pytest

from tests.toy import LIMIT, Proportional
from vr_envs.controllers.policy import Constant
from vr_envs.evaluation.files import write_json
from vr_envs.evaluation.report import evaluate_ladder
from vr_envs.evaluation.statistics import Estimate
from vr_envs.evaluation.table import interval


def rows_of(report):
    return {row.policy: row for row in report.rows}


def test_every_policy_of_the_ladder_and_the_extra_ones_are_reported(toy):
    report = evaluate_ladder(toy, n=30, extra={"agent": Constant(np.array([0.1]))})
    rows = rows_of(report)
    assert list(rows) == ["do-nothing", "random", "proportional", "cancel", "agent"]
    assert rows["do-nothing"].normalised == Estimate(0.0, 0.0, 0.0)
    assert rows["proportional"].normalised == Estimate(1.0, 1.0, 1.0)
    assert rows["proportional"].difference == Estimate(0.0, 0.0, 0.0)
    assert rows["cancel"].difference.low > 0.0
    assert rows["agent"].score.value == report.rollouts["agent"].scores.mean()
    assert list(rows["agent"].metrics) == ["rms", "final"]


def test_rows_of_the_table_are_the_rows_of_the_report(toy):
    table = evaluate_ladder(toy, n=10).table().splitlines()
    assert table[0].startswith("toy/FirstOrder-v0, scene plain, level nominal: 10 held-out scenarios (seed 0)")
    scores, metrics = (block.splitlines() for block in "\n".join(table[2:]).split("\n\n")[:2])
    heads = [[cell.strip() for cell in block[0].split("|")[1:-1]] for block in (scores, metrics)]
    assert heads[0] == ["policy", "score", "IQM", "normalised", "minus baseline", "success"]
    assert heads[1] == ["policy", "rms", "final"]
    for block in (scores, metrics):
        assert len({len(line) for line in block}) == 1
        assert block[4].startswith("| proportional (baseline) |")


def test_only_the_named_policies_are_shown_on_the_same_scale(toy):
    everything = rows_of(evaluate_ladder(toy, n=30))
    assert evaluate_ladder(toy, n=30, names=["cancel"]).rows == (everything["cancel"],)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ({"names": ["best"]}, "do-nothing, random, proportional, cancel"),
        ({"names": []}, "choose among"),
        ({"extra": {"cancel": Constant(np.zeros(1))}}, "taken"),
    ],
)
def test_wrong_names_are_refused(toy, arguments, named):
    with pytest.raises(ValueError, match=named):
        evaluate_ladder(toy, n=5, **arguments)


def test_policies_are_judged_at_the_level_and_designed_for_the_scene(toy):
    nominal, severe = (rows_of(evaluate_ladder(toy, "biased", level, 30)) for level in ("nominal", "severe"))
    assert severe["do-nothing"].score.high < nominal["do-nothing"].score.low


def test_json_holds_what_the_table_shows(toy, tmp_path):
    report = evaluate_ladder(toy, {"base": "biased", "lag": 0.5}, "light", n=20, seed=3)
    path = tmp_path / "report.json"
    report.to_json(str(path))
    stored = json.loads(path.read_text())
    assert stored["env"] == toy
    assert stored["scene"] == {
        "base": "biased",
        "lag": 0.5,
        "push": 2.0,
        "start": 1.0,
        "bound": 100.0,
        "bias": {"size": 0.5, "sign": 1.0},
    }
    assert (stored["level"], stored["scenarios"], stored["seed"], stored["max_episode_steps"]) == (
        "light",
        20,
        3,
        LIMIT,
    )
    for row in report.rows:
        kept = stored["policies"][row.policy]
        assert kept["score"] == row.score._asdict()
        assert kept["metrics"]["rms"] == row.metrics["rms"]._asdict()


def test_without_a_scale_the_table_has_a_dash_and_the_json_a_null(toy, monkeypatch):
    class Idle(Proportional):
        def __init__(self, scene):
            super().__init__(scene, 0.0)

    monkeypatch.setitem(sys.modules["vr_envs.controllers.toy"].LAWS, "proportional", Idle)
    report = evaluate_ladder(toy, n=10)
    assert math.isnan(rows_of(report)["cancel"].normalised.value)
    assert report.as_dict()["policies"]["cancel"]["normalised"]["value"] is None
    assert " - |" in report.table()


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    path = tmp_path / "report.json"
    write_json(path, {"old": np.float64(1.5), "rows": np.arange(2)})
    assert json.loads(path.read_text()) == {"old": 1.5, "rows": [0, 1]}

    def refuse(*_):
        raise OSError("disk full")

    monkeypatch.setattr("os.replace", refuse)
    with pytest.raises(OSError, match="disk full"):
        write_json(path, {"new": 2})
    assert json.loads(path.read_text())["old"] == 1.5
    assert [p.name for p in tmp_path.iterdir()] == ["report.json"]


@pytest.mark.parametrize(
    ("estimate", "text"),
    [
        ((0.93912, 0.93211, 0.94522), "0.939 [0.932, 0.945]"),
        ((0.93912, 0.93881, 0.93951), "0.9391 [0.9388, 0.9395]"),
        ((0.0173, 0.01612, 0.01849), "0.0173 [0.0161, 0.0185]"),
        ((158.24, 150.11, 166.32), "158 [150, 166]"),
        ((0.0, 0.0, 0.0), "0.000 [0.000, 0.000]"),
        ((-1e-9, -0.0101, 0.0102), "0.0000 [-0.0101, 0.0102]"),
        ((math.nan, math.nan, math.nan), "-"),
    ],
)
def test_numbers_in_tables(estimate, text):
    assert interval(Estimate(*estimate)) == text


def test_differences_carry_a_sign_and_values_may_stand_alone():
    assert interval(Estimate(0.5, -0.25, 1.0), sign=True) == "+0.50 [-0.25, +1.00]"
    assert interval(Estimate(0.5, -0.25, 0.75), bounds=False) == "0.500"
