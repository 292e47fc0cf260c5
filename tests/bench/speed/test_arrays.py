"""The opponents of the native batch do what it does: same starts, motion, rewards, ends and new episodes."""

import numpy as np
import pytest

from vr_envs.bench.speed.arrays.autopilot import AutopilotArrays
from vr_envs.bench.speed.arrays.namespace import NUMPY, jax_arrays, uniform
from vr_envs.bench.speed.arrays.terrain_ride import RideArrays
from vr_envs.envs.autopilot import AutopilotBatchEnv
from vr_envs.envs.terrain_ride import TerrainRideBatchEnv
from vr_envs.models.noise import uniform as uniform_of_kernel

ROWS, STEPS, LIMIT = 48, 260, 90
# demands that change often, near the ground: episodes end in both ways
LOW = {"base": "lecture", "altitude_low": 20.0, "altitude_high": 200.0, "demands": {"hold_low": 5.0, "hold_high": 20.0}}
CASES = [(AutopilotArrays, AutopilotBatchEnv, LOW, 50), (RideArrays, TerrainRideBatchEnv, "lecture", 0)]


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
        np.testing.assert_allclose(state["x"], same["x"], rtol=0.0, atol=1e-7)
    else:
        np.testing.assert_allclose(state["travel"], same["travel"], rtol=0.0, atol=1e-12)


def test_random_numbers_are_those_of_the_kernels():
    keys = np.array([0, 1, 2**63 + 5, 2**64 - 1], np.uint64)
    for counter in (0, 7, (1 << 41) + 3):
        expected = [uniform_of_kernel(key, counter) for key in keys]
        assert uniform(np, keys, counter).tolist() == expected
        assert uniform(np, keys, np.full(4, counter)).tolist() == expected


@pytest.mark.parametrize(("opponent", "env"), [(AutopilotArrays, AutopilotBatchEnv), (RideArrays, TerrainRideBatchEnv)])
def test_another_scene_is_refused(opponent, env):
    with pytest.raises(ValueError, match="'lecture'"):
        opponent(NUMPY, env(1).world.scene, 10)
