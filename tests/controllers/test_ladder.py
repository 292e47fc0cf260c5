import json

import numpy as np
import pytest

from tests.toy import TASK
from vr_envs.controllers.ladder import baseline_of, constant, ladder, laws_of, tuned_file, tuned_of
from vr_envs.controllers.policy import Constant
from vr_envs.envs.registry import ids, limit_of, spec_of, task_of
from vr_envs.envs.scene import resolve
from vr_envs.envs.world import World


@pytest.mark.parametrize(
    "text",
    ["vr_envs/BallOnBar-v0", "vr_envs:vr_envs/BallOnBar-v0", "BallOnBar-v0", "BallOnBar", "vr_envs/BallOnBar"],
)
def test_an_id_may_be_shortened(text):
    assert spec_of(text).id == "vr_envs/BallOnBar-v0"
    assert limit_of(text) == 150


def test_an_unknown_id_is_refused_with_the_ids():
    with pytest.raises(ValueError, match=r"did you mean BallOnBar\? Ids: vr_envs/BallOnBar-v0, .*Autopilot"):
        task_of("vr_envs/BallOnBall-v0")


def test_an_environment_of_somebody_else_is_refused():
    with pytest.raises(ValueError, match="not an environment of this suite"):
        task_of("CartPole-v1")


def test_untuned_laws_have_their_defaults_and_no_constant_is_called_best(toy):
    policies = ladder(TASK, resolve(TASK))
    assert list(policies) == ["do-nothing", "random", "proportional", "cancel"]
    assert policies["proportional"].gain == 1.0


def test_a_tuned_preset_serves_the_scenes_based_on_it(toy):
    tuned = {"biased": {"best-constant": {"gains": {"push": -0.5}}, "proportional": {"gains": {"gain": 3.0}}}}
    tuned_file(TASK).write_text(json.dumps(tuned))
    policies = ladder(TASK, resolve(TASK, {"base": "biased", "push": 1.0}))
    assert policies["proportional"].gain == 3.0
    assert policies["proportional-untuned"].gain == 1.0
    assert policies["best-constant"].action == pytest.approx([-0.5])
    assert "best-constant" not in ladder(TASK, resolve(TASK, "plain"))


def test_a_constant_for_other_channels_is_left_out(toy):
    tuned_file(TASK).write_text(json.dumps({"plain": {"best-constant": {"gains": {"pull": 1.0}}}}))
    assert "best-constant" not in ladder(TASK, resolve(TASK))


@pytest.mark.parametrize("env_id", ids())
def test_every_policy_answers_in_every_scene(env_id):
    task = task_of(env_id)
    assert baseline_of(task) in laws_of(task)
    for name in task.scenes:
        world = World(task, name, 3)
        observations = np.empty((3, world.widths[0]), np.float32)
        world.reset(np.arange(3), np.arange(3, dtype=np.uint64), observations)
        for policy in ladder(task, world.scene).values():
            for n in (3, 1):
                policy.reset(n)
                actions = np.asarray(policy(observations[:n]))
                assert actions.shape == (n, world.widths[1])
                assert (np.abs(actions) <= 1.0).all()


@pytest.mark.parametrize("env_id", ids())
def test_defaults_lie_in_their_ranges(env_id):
    for law in laws_of(task_of(env_id)).values():
        for low, high, default in law.TUNABLE.values():
            assert low <= default <= high
            assert low < high


@pytest.mark.parametrize("env_id", ids())
def test_tuned_gains_belong_to_their_scene_and_law(env_id):
    task = task_of(env_id)
    stored = tuned_of(task)
    assert task.default_scene in stored
    for scene_name, entries in stored.items():
        scene = resolve(task, scene_name)
        for name, entry in entries.items():
            assert entry["check_score"] >= entry["default_check_score"]
            if name == "best-constant":
                assert isinstance(constant(task, scene, entry["gains"]), Constant)
                continue
            ranges = laws_of(task)[name].TUNABLE
            assert list(entry["gains"]) == list(ranges)
            assert all(ranges[gain][0] <= value <= ranges[gain][1] for gain, value in entry["gains"].items())
