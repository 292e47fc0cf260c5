import math

import numpy as np
import pytest

from vr_envs.controllers.terrain_ride import BASELINE, LAWS, LecturePassive, Skyhook
from vr_envs.envs.scene import resolve
from vr_envs.envs.terrain_ride import TASK, TerrainRideBatchEnv
from vr_envs.envs.terrain_ride_observation import read
from vr_envs.models.terrain_ride import suspension


def observation(scene, **channels):
    row = np.zeros((1, len(TASK.observation_channels(scene))), np.float32)
    for name, value in channels.items():
        row[0, [c.name for c in TASK.observation_channels(scene)].index(name.replace("_", " "))] = value
    return row


def run(law, n=64, scene=None):
    """Mean reward of whole episodes."""
    env = TerrainRideBatchEnv(n, scene=scene, max_episode_steps=1000, autoreset_mode="SAME_STEP")
    observations, _ = env.reset(options={"scenario": list(range(n))})
    law.reset(n)
    total, live = np.zeros(n), np.ones(n, bool)
    for _ in range(1000):
        observations, rewards, terminated, truncated, _ = env.step(law(observations))
        total += rewards * live
        live &= ~(terminated | truncated)
    return total / 1000


def test_restitution_becomes_damping():
    """k_d = 0.95 at 60 Hz is 3.08 1/s, at the nominal modulus."""
    scene = resolve(TASK, {"lag": None})
    action = LecturePassive(scene, restitution=0.95)(observation(scene))
    env = TerrainRideBatchEnv(1, scene={"lag": None})
    env.reset(seed=0)
    env.step(action)
    gamma, w2, _ = suspension(env.world.states[0], env.world.params)
    assert gamma == pytest.approx(-60 * math.log(0.95), rel=1e-6)
    assert w2 == pytest.approx(16812 / 290, rel=1e-6)


@pytest.mark.parametrize("law", LAWS.values())
def test_modulus_is_a_factor_on_the_springs_nominal_one(law):
    scene = resolve(TASK, {"lag": None})
    for modulus in (0.5, 0.8, 2.0):
        env = TerrainRideBatchEnv(1, scene={"lag": None})
        env.reset(seed=0)
        env.step(law(scene, modulus=modulus)(observation(scene)))
        w2 = suspension(env.world.states[0], env.world.params)[1]
        assert w2 == pytest.approx(modulus * 16812 / 290, rel=1e-6)


def test_every_restitution_in_the_range_is_a_damping_that_the_damper_has():
    low, high, default = LecturePassive.TUNABLE["restitution"]
    assert -60 * math.log(low) == pytest.approx(10.0, rel=1e-14)
    assert -60 * math.log(high) == pytest.approx(0.3, rel=1e-12)
    assert low < default < high
    scene = resolve(TASK)
    actions = [LecturePassive(scene, restitution=k)(observation(scene))[0, 0] for k in (low, default, high)]
    assert actions == pytest.approx([1.0, (math.log(-60 * math.log(0.95)) - math.log(3) / 2) / math.log(10 / 0.3) * 2,
                                     -1.0], abs=1e-6)  # fmt: skip


def test_modulus_stays_nominal_where_its_range_is_lopsided():
    scene = resolve(TASK, {"lag": None, "modulus_low": 0.9, "modulus_high": 4.0})
    env = TerrainRideBatchEnv(1, scene={"lag": None, "modulus_low": 0.9, "modulus_high": 4.0})
    env.reset(seed=0)
    env.step(LecturePassive(scene)(observation(scene)))
    assert suspension(env.world.states[0], env.world.params)[1] == pytest.approx(16812 / 290, rel=1e-6)


@pytest.mark.parametrize("law", LAWS.values())
@pytest.mark.parametrize("scene", [None, "lecture", {"actuation": "active"}])
def test_actions_are_bounded_over_the_whole_box_and_every_gain(law, scene):
    resolved = resolve(TASK, scene)
    width = len(TASK.action_channels(resolved))
    rows = np.random.default_rng(0).uniform(-5, 5, (500, len(TASK.observation_channels(resolved)))).astype(np.float32)
    rows[0] = 0
    for end in (0, 1, 2):
        policy = law(resolved, **{name: limits[end] for name, limits in law.TUNABLE.items()})
        policy.reset(500)
        actions = policy(rows)
        assert actions.shape == (500, width) and actions.dtype == np.float32
        assert (np.abs(actions) <= 1).all()


@pytest.mark.parametrize("modulus", [0.6, 1.0, 1.4])
def test_active_baseline_is_the_same_damper_and_spring(modulus):
    """A force that imitates damper and spring scores as they do, but for its being held over the interval."""
    scene = {"lag": None, "noise": None, "force": 1e5}
    passive = run(LecturePassive(resolve(TASK, scene), modulus=modulus), scene=scene)
    active_scene = {**scene, "actuation": "active"}
    active = run(LecturePassive(resolve(TASK, active_scene), modulus=modulus), scene=active_scene)
    assert np.mean(active) == pytest.approx(np.mean(passive), abs=0.03)


def test_skyhook_switches_with_the_sign_of_its_power():
    scene = resolve(TASK)
    law = Skyhook(scene, sky=10.0, least=0.6)
    least, hard = (law(observation(scene, velocity=v, travel_rate=0.5))[0, 0] for v in (-0.5, 0.25))
    p = scene.params
    assert math.exp(p.damping_centre + p.damping_half * least) == pytest.approx(0.6, rel=1e-5)
    assert math.exp(p.damping_centre + p.damping_half * hard) == pytest.approx(5.0, rel=1e-5)


def test_skyhook_beats_the_tuned_baseline():
    """A stronger law exists, so the task leaves something to win."""
    scene = resolve(TASK)
    gain = run(Skyhook(scene)) - run(LAWS[BASELINE](scene, restitution=0.95))
    assert gain.mean() > 3 * gain.std() / math.sqrt(len(gain)) and gain.mean() > 0.03


def test_reading_inverts_the_observation():
    env = TerrainRideBatchEnv(8, scene={"noise": None})
    observations, _ = env.reset(seed=1)
    for _ in range(50):
        observations, *_ = env.step(np.full((8, 2), 0.3))
    reading, states = read(observations, env.world.scene), env.get_state()
    for name in ("travel", "travel_rate", "velocity", "acceleration", "weighted"):
        assert getattr(reading, name) == pytest.approx(states[name], rel=1e-6, abs=1e-9)
    assert reading.position == pytest.approx(states["position"], rel=1e-6)
    assert reading.ahead.shape == (8, 10)
