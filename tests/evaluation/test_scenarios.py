import numpy as np
import pytest
from gymnasium.utils import seeding

from tests.toy import TASK
from vr_envs.envs.scene import resolve
from vr_envs.envs.world import episode_key
from vr_envs.evaluation.scenarios import at_level, scenario_keys, scenario_set


def test_a_smaller_set_is_the_head_of_a_larger_one():
    assert (scenario_keys(200)[:50] == scenario_keys(50)).all()
    assert scenario_keys(3).dtype == np.uint64


def test_held_out_training_and_environment_keys_are_disjoint():
    held_out = {int(k) for seed in range(20) for k in scenario_keys(500, seed)}
    training = {int(k) for seed in range(20) for k in scenario_keys(500, seed, "training")}
    assert len(held_out) == len(training) == 10_000
    environment = set()
    for seed in range(500):
        generator, _ = seeding.np_random(seed)
        environment |= {int(episode_key(generator)) for _ in range(20)}
    assert not held_out & training
    assert not environment & (held_out | training)


def test_keys_use_all_64_bits():
    keys = scenario_keys(4000)
    shares = [((keys >> np.uint64(bit)) & np.uint64(1)).mean() for bit in range(64)]
    assert np.abs(np.array(shares) - 0.5).max() < 4.5 * 0.5 / np.sqrt(4000)


def test_a_level_is_laid_over_the_users_overrides():
    scene = resolve(TASK, {"base": "biased", "push": 3.0, "bias": {"sign": -1.0}})
    severe = at_level(TASK, scene, "severe")
    assert severe.options["bias"].size == 0.9
    assert severe.options["bias"].sign == -1.0
    assert severe.params.push == 3.0
    assert at_level(TASK, scene, "nominal") == scene


def test_a_level_brings_no_option_that_the_scene_leaves_out():
    light = at_level(TASK, resolve(TASK, "plain"), "light")
    assert light.options["bias"] is None
    assert light.params.start == 0.1


def test_levels_are_paired_and_policies_are_made_for_the_users_scene(toy):
    light, severe = (scenario_set(toy, "biased", level, 10) for level in ("light", "severe"))
    assert (light.keys == severe.keys).all()
    assert light.scene == severe.scene == resolve(TASK, "biased")
    assert light.world.options["bias"].size == 0.1


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ({"level": "hard"}, "nominal, light, severe"),
        ({"scene": "moon"}, "plain, biased"),
        ({"scene": {"pusch": 1}}, "push"),
        ({"n": 1}, "at least 2"),
        ({"seed": -1}, "at least 0"),
    ],
)
def test_a_wrong_set_is_refused_with_what_is_allowed(toy, arguments, named):
    with pytest.raises(ValueError, match=named):
        scenario_set(toy, **arguments)


def test_a_scene_without_metrics_cannot_be_judged():
    with pytest.raises(ValueError, match="give metrics = true"):
        scenario_set("Autopilot-v1", {"base": "lecture", "metrics": None})
