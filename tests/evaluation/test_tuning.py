import json
import sys

import numpy as np
import pytest

from tests.toy import TASK
from vr_envs.controllers.ladder import ladder, tuned_file
from vr_envs.controllers.policy import Constant
from vr_envs.envs.scene import resolve
from vr_envs.evaluation import tuning
from vr_envs.evaluation.rollout import rollout
from vr_envs.evaluation.scenarios import scenario_keys, scenario_set
from vr_envs.evaluation.tuning import Candidate, tune


def test_unit_coordinates_are_linear_or_logarithmic():
    candidate = Candidate(
        {"offset": (-1.0, 3.0, 0.0), "rate": (0.1, 10.0, 1.0), "near": (1.0, 5.0, 2.0)}, lambda gains: Constant([])
    )
    assert candidate.default() == pytest.approx([0.25, 0.5, 0.25])
    assert candidate.gains(candidate.default()) == pytest.approx({"offset": 0.0, "rate": 1.0, "near": 2.0})
    assert candidate.gains(np.array([1.0, 0.75, 0.0])) == pytest.approx({"offset": 3.0, "rate": 10**0.5, "near": 1.0})
    assert candidate.gains(np.array([1.1, -0.1, 0.5])) == pytest.approx({"offset": 3.0, "rate": 0.1, "near": 3.0})


def test_finds_the_optimum_that_is_known(toy):
    found = tune(toy, "biased", evaluations=120, scenarios=32)
    # a bias of half the push is cancelled by minus half the push, but for the start
    grid = np.linspace(-0.7, -0.3, 81)
    check = scenario_set(toy, "biased", n=128, seed=1, side="training")
    scores = [rollout(Constant(np.array([a])), check).scores.mean() for a in grid]
    assert found["best-constant"]["gains"]["push"] == pytest.approx(grid[int(np.argmax(scores))], abs=0.03)
    assert found["best-constant"]["check_score"] >= max(scores) - 1e-4
    # a proportional law needs the same offset; its gain is as high as allowed, where the push is at its limit anyway
    assert found["proportional"]["gains"]["offset"] == pytest.approx(-0.5, abs=0.05)
    assert found["proportional"]["gains"]["gain"] > 6.0


def test_same_command_same_gains(toy):
    first = tune(toy, "biased", ["proportional"], 40, 8, seed=3)
    assert tune(toy, "biased", ["proportional"], 40, 8, seed=3) == first
    assert (
        tune(toy, "biased", ["proportional"], 40, 8, seed=4)["proportional"]["gains"] != first["proportional"]["gains"]
    )


def test_never_worse_than_the_defaults_on_the_check(toy):
    for entry in tune(toy, "plain", evaluations=30, scenarios=4).values():
        assert entry["check_score"] >= entry["default_check_score"]


def test_held_out_scenarios_are_never_seen(toy, monkeypatch):
    seen = set()

    def spy(policy, scenarios):
        seen.update(map(int, scenarios.keys))
        return rollout(policy, scenarios)

    monkeypatch.setattr(tuning, "rollout", spy)
    tune(toy, evaluations=30, scenarios=8)
    assert len(seen) == 8 + 32
    assert not seen & {int(k) for seed in range(10) for k in scenario_keys(1000, seed)}


def test_the_ladder_uses_what_was_stored_and_other_entries_stay(toy):
    tune(toy, "biased", ["best-constant"], 30, 4)
    tune(toy, "plain", ["proportional"], 30, 4)
    found = tune(toy, "biased", ["proportional"], 40, 4, seed=7)["proportional"]
    stored = json.loads(tuned_file(TASK).read_text())
    assert set(stored) == {"biased", "plain"}
    assert set(stored["biased"]) == {"best-constant", "proportional"}
    assert stored["biased"]["proportional"] == found
    assert found["command"] == (
        "vr-envs tune toy/FirstOrder-v0 --scene biased --policy proportional --evaluations 40 --scenarios 4 --seed 7"
    )
    law = ladder(TASK, resolve(TASK, {"base": "biased", "lag": 2.0}))["proportional"]
    assert {"gain": law.gain, "offset": law.offset} == found["gains"]


def test_what_has_nothing_to_tune_is_refused(toy):
    with pytest.raises(ValueError, match="proportional, best-constant"):
        tune(toy, policies=["cancel"])
    assert not tuned_file(TASK).exists()


def test_the_best_constant_is_no_worse_than_a_law_that_is_constant(toy, monkeypatch):
    class Half(Constant):
        TUNABLE = {}

        def __init__(self, scene):
            super().__init__(np.array([-0.5]))

    monkeypatch.setitem(sys.modules["vr_envs.controllers.toy"].LAWS, "half", Half)
    # so few rollouts do not come this close by themselves
    found = tune(toy, "biased", ["best-constant"], 30, 8)["best-constant"]
    check = scenario_set(toy, "biased", n=32, seed=1, side="training")
    assert found["check_score"] >= rollout(Constant(np.array([-0.5])), check).scores.mean()


def test_a_short_search_does_not_make_stored_gains_worse(toy):
    good = tune(toy, "biased", ["proportional"], evaluations=120, scenarios=32)["proportional"]
    again = tune(toy, "biased", ["proportional"], evaluations=30, scenarios=32)["proportional"]
    assert again["check_score"] >= good["check_score"]
