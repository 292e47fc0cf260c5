import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv

from agents.adapter import BatchVecEnv
from tests import toy
from vr_envs.envs.registry import ids, limit_of

ROWS = 5
ENDS = {"lag": 0.3, "bound": 1.0, "start": 0.5}  # random actions leave this bound in some episodes


@pytest.fixture(scope="module", autouse=True)
def _toy():
    toy.install()


def batch(env_id, scene=None):
    return gym.make_vec(env_id, ROWS, scene=scene, autoreset_mode=AutoresetMode.SAME_STEP)


def check_identity(env_id, scene=None):
    adapted = BatchVecEnv(batch(env_id, scene))
    plain = DummyVecEnv([lambda: Monitor(gym.make(env_id, scene=scene))] * ROWS)
    for env in (adapted, plain):
        env.seed(3)
    np.testing.assert_array_equal(adapted.reset(), plain.reset())
    generator = np.random.default_rng(0)
    ends = {True: 0, False: 0}
    for _ in range(2 * limit_of(env_id) + 1):
        actions = generator.uniform(-1, 1, (ROWS, *adapted.action_space.shape)).astype(np.float32)
        ours, theirs = adapted.step(actions), plain.step(actions)
        for a, b in zip(ours[:3], theirs[:3], strict=True):
            assert a.dtype == b.dtype
            np.testing.assert_array_equal(a, b)
        for i in np.flatnonzero(ours[2]):
            a, b = ours[3][i], theirs[3][i]
            assert a.keys() == b.keys()
            np.testing.assert_array_equal(a.pop("terminal_observation"), b.pop("terminal_observation"))
            a["episode"].pop("t"), b["episode"].pop("t")
            assert a == b
            ends[a["TimeLimit.truncated"]] += 1
    return ends


@pytest.mark.parametrize("env_id", ids())
def test_registered_ids_equal_the_dummy_vec_env(env_id):
    assert sum(check_identity(env_id).values()) >= ROWS


def test_both_kinds_of_ending_equal_the_dummy_vec_env():
    assert min(check_identity(toy.ID, ENDS).values()) > 0


def test_reward_scale_leaves_the_episode_return_alone():
    plain, scaled = BatchVecEnv(batch(toy.ID)), BatchVecEnv(batch(toy.ID), reward_scale=0.25)
    for env in (plain, scaled):
        env.seed(0)
        env.reset()
    returns = []
    for _ in range(45):
        actions = np.zeros((ROWS, 1), np.float32)
        (_, rewards, done, infos), (_, scaled_rewards, _, scaled_infos) = plain.step(actions), scaled.step(actions)
        np.testing.assert_allclose(scaled_rewards, 0.25 * rewards, rtol=1e-6)
        for i in np.flatnonzero(done):
            assert infos[i]["episode"]["r"] == scaled_infos[i]["episode"]["r"]
            returns.append(infos[i]["episode"]["r"])
    assert returns


def test_another_autoreset_mode_is_refused():
    with pytest.raises(ValueError, match="SAME_STEP"):
        BatchVecEnv(gym.make_vec(toy.ID, 2))


def test_staggered_rows_end_one_after_the_other_and_their_first_fragments_are_not_reported():
    rows = gym.make_vec(toy.ID, 4, autoreset_mode=AutoresetMode.SAME_STEP)
    adapted = BatchVecEnv(rows, stagger=toy.LIMIT)
    adapted.seed(0)
    adapted.reset()
    ends, reported = [[] for _ in range(4)], []
    for step in range(2 * toy.LIMIT):
        _, _, dones, infos = adapted.step(np.zeros((4, 1), np.float32))
        for row in np.flatnonzero(dones):
            ends[row].append(step)
            if "episode" in infos[row]:
                reported.append(infos[row]["episode"]["l"])
    assert len({row[0] for row in ends}) == 4
    assert reported and set(reported) == {toy.LIMIT}
