"""The opponents of the native batch do what it does: same starts, motion, rewards, ends and new episodes."""

import numpy as np
import pytest

from vr_envs.bench.speed.arrays.autopilot import AutopilotArrays
from vr_envs.bench.speed.arrays.autopilot_airliner import AirlinerArrays
from vr_envs.bench.speed.arrays.ball_on_bar import BallArrays
from vr_envs.bench.speed.arrays.namespace import NUMPY, jax_arrays, uniform
from vr_envs.bench.speed.arrays.terrain_ride import RideArrays
from vr_envs.envs.autopilot import AutopilotBatchEnv
from vr_envs.envs.ball_on_bar import BallOnBarBatchEnv
from vr_envs.envs.terrain_ride import TerrainRideBatchEnv
from vr_envs.models.noise import uniform as uniform_of_kernel

ROWS, STEPS, LIMIT = 48, 260, 90
# demands that change often, near the ground: episodes end in both ways
LOW = {"base": "lecture", "altitude_low": 20.0, "altitude_high": 200.0, "demands": {"hold_low": 5.0, "hold_high": 20.0}}
# from the ground to above the tropopause, near the stall
AIR = {**LOW, "base": "airliner", "altitude_high": 12500.0, "stall_speed": 74.0, "turbulence": {"sigma": 1.5}}
CASES = [
    (AutopilotArrays, AutopilotBatchEnv, LOW, 50),
    (AirlinerArrays, AutopilotBatchEnv, AIR, 5),
    (RideArrays, TerrainRideBatchEnv, "lecture", 0),
]


@pytest.mark.parametrize("library", ["NumPy", "JAX"])
@pytest.mark.parametrize(("opponent", "env", "scene", "least_lost"), CASES)
def test_an_opponent_is_the_native_batch_to_rounding(opponent, env, scene, least_lost, library):
    if library == "JAX":
        pytest.importorskip("jax")
    arrays = NUMPY if library == "NumPy" else jax_arrays()
    native = env(ROWS, scene=scene, max_episode_steps=LIMIT, autoreset_mode="DISABLED")
    other = opponent(arrays, native.world.scene, LIMIT)
    step = arrays.compiled(other.step)
    rng = np.random.default_rng(5)
    keys = rng.integers(2**64 - 1, size=ROWS, dtype=np.uint64)
    first, _ = native.reset(options={"scenario": keys})
    state = other.start(arrays.xp.asarray(keys))
    assert np.allclose(other.observe(state), first, rtol=0.0, atol=2e-7)
    lost = truncated = 0
    action = np.zeros(native.action_space.shape, np.float32)
    for k in range(STEPS):
        if k % 10 == 0:
            action = rng.uniform(-1.1, 1.1, action.shape).astype(np.float32)
        obs, rewards, ended, cut, _ = native.step(action)
        state, seen, reward, terminated, over = step(state, arrays.xp.asarray(action))
        assert np.array_equal(terminated, ended) and np.array_equal(over, cut)
        np.testing.assert_allclose(reward, rewards, rtol=0.0, atol=1e-9)
        done = ended | cut
        lost, truncated = lost + ended.sum(), truncated + cut.sum()
        if done.any():
            options = {"reset_mask": done, "scenario": np.asarray(state["key"])}
            obs = np.where(done[:, None], native.reset(options=options)[0], obs)
        # float32 of numbers that agree to 1e-9: at most one unit in the last place
        np.testing.assert_allclose(seen, obs, rtol=2e-7, atol=2e-8)
    assert truncated > 0 and lost >= least_lost
    same = native.world.states
    if env is AutopilotBatchEnv:
        np.testing.assert_allclose(state["value"], [same[k] for k in ("altitude", "speed", "heading")], rtol=1e-9)
        if "x" in state:
            np.testing.assert_allclose(state["x"], same["x"], rtol=0.0, atol=1e-7)
    else:
        np.testing.assert_allclose(state["travel"], same["travel"], rtol=0.0, atol=1e-12)


def states_of(native):
    """The records of a native batch of balls as the arrays of the opponent."""
    states = native.get_state()
    taken = {name: states[name].copy() for name in ("key", "steps", "impacts", "x", "z", "u", "w")}
    motion = states["motion"].T.reshape(3, 2, -1).copy()
    return {**taken, "resting": states["resting"] != 0, "place": states["d"].copy(), "motion": motion}


def test_balls_that_keep_bouncing_are_those_of_the_native_batch():
    """Small actions, over more than an episode; no ball comes to rest, so the error is that of the impacts."""
    native = BallOnBarBatchEnv(ROWS, max_episode_steps=30, autoreset_mode="DISABLED")
    other = BallArrays(NUMPY, native.world.scene, 30)
    rng = np.random.default_rng(5)
    keys = rng.integers(2**64 - 1, size=ROWS, dtype=np.uint64)
    first, _ = native.reset(options={"scenario": keys})
    state = other.start(keys)
    assert np.array_equal(other.observe(state), first)
    for _ in range(45):
        action = rng.uniform(-0.1, 0.1, (ROWS, 6)).astype(np.float32)
        obs, rewards, ended, cut, _ = native.step(action)
        impacts = native.get_state()["impacts"]
        state, seen, reward, terminated, over = other.step(state, action)
        assert np.array_equal(terminated, ended) and np.array_equal(over, cut)
        np.testing.assert_allclose(reward, rewards, rtol=0.0, atol=1e-12)
        if cut.any():
            obs, _ = native.reset(options={"scenario": state["key"]})
        else:
            assert np.array_equal(state["impacts"], impacts) and not state["resting"].any()
        np.testing.assert_allclose(seen, obs, rtol=2e-7, atol=2e-8)
    assert state["steps"].tolist() == [15] * ROWS


def test_balls_bounce_leave_the_bar_and_rest_on_it_as_in_the_native_batch():
    """Full range, one cycle at a time from the native records: few impacts are no chatter."""
    rows = 200
    scene = {"base": "bell", "start_max": 0.0249}  # some begin near an end
    native = BallOnBarBatchEnv(rows, scene=scene, max_episode_steps=1000)
    other = BallArrays(NUMPY, native.world.scene, 1000)
    rng = np.random.default_rng(6)
    native.reset(seed=1)
    errors = {"bounce": [], "rest": [], "leave": []}
    lost = 0
    for _ in range(40):
        action = rng.uniform(-1.0, 1.0, (rows, 6)).astype(np.float32)
        before = native.get_state()
        ours = states_of(native)
        _, _, ended, _, _ = native.step(action)
        after = native.get_state()
        ours, _, _, terminated, _ = other.step(ours, action)
        impacts, alive = after["impacts"] - before["impacts"], ~ended & ~terminated & (after["steps"] > 0)
        lost += (ended & terminated).sum()
        error = np.max([abs(ours[name] - after[name]) for name in ("x", "z", "u", "w")], axis=0)
        lay, lies = before["resting"] != 0, after["resting"] != 0
        errors["bounce"] += error[alive & ~lay & ~lies & (impacts < 8)].tolist()
        errors["rest"] += error[alive & lay & lies & (impacts == 0)].tolist()
        errors["leave"] += error[alive & lay & ~lies & (impacts == 0)].tolist()
    assert min(len(found) for found in errors.values()) > 100 and lost > 10
    assert max(errors["bounce"]) < 1e-12 and max(errors["rest"]) < 1e-15
    # a place between two samples of the force; a ball that falls for less than a sample is missed
    assert np.quantile(errors["leave"], 0.9) < 1e-6


def test_ball_on_arrays_is_for_numpy():
    with pytest.raises(ValueError, match="NumPy alone"):
        BallArrays(NUMPY._replace(name="JAX"), BallOnBarBatchEnv(1).world.scene, 10)


def test_random_numbers_are_those_of_the_kernels():
    keys = np.array([0, 1, 2**63 + 5, 2**64 - 1], np.uint64)
    for counter in (0, 7, (1 << 41) + 3):
        expected = [uniform_of_kernel(key, counter) for key in keys]
        assert uniform(np, keys, counter).tolist() == expected
        assert uniform(np, keys, np.full(4, counter)).tolist() == expected


@pytest.mark.parametrize(
    ("opponent", "env", "scene"),
    [
        (AutopilotArrays, AutopilotBatchEnv, "airliner"),
        (AirlinerArrays, AutopilotBatchEnv, "lecture"),
        (AirlinerArrays, AutopilotBatchEnv, {"base": "airliner", "stall_speed": 50.0}),
        (RideArrays, TerrainRideBatchEnv, "road"),
        (BallArrays, BallOnBarBatchEnv, "rolling"),
    ],
)
def test_another_scene_is_refused(opponent, env, scene):
    with pytest.raises(ValueError, match="give the|at least"):
        opponent(NUMPY, env(1, scene=scene).world.scene, 10)
