"""The one bound record of a scalar environment."""

import copy
import dataclasses
import pickle

import gymnasium as gym
import numpy as np
import pytest

from vr_envs.envs.scalar import ScalarEnv
from vr_envs.models.jit import bound, kernel


@kernel
def _add(total, record):
    total[0] += record.step
    return total[0]


def test_a_bound_call_shares_arrays_and_keeps_records_as_they_were():
    total, records = np.zeros(2), np.ones(1, [("step", "f8")])
    record = records[0]
    call = bound(_add, total, record)
    assert (call(), call()) == (1.0, 2.0)
    total[0] = 10.0
    record["step"] = 5.0
    del record, records
    assert call() == 11.0 and total.tolist() == [11.0, 0.0]


@pytest.mark.parametrize("clone", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_a_copy_goes_on_by_itself_to_the_same_bytes(clone):
    env = gym.make("vr_envs/TerrainRide-v0", scene="lecture").unwrapped
    env.reset(seed=3)
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (6, *env.action_space.shape)).astype(np.float32)
    env.step(actions[0])
    twin = clone(env)
    before = env.get_state()
    there = [twin.step(action)[0].tobytes() for action in actions[1:]]
    assert env.get_state().tobytes() == before.tobytes()
    assert there == [env.step(action)[0].tobytes() for action in actions[1:]]
    assert env.get_state().tobytes() == twin.get_state().tobytes()


def test_observations_are_fresh_and_actions_of_any_kind_are_the_same(toy):
    env = gym.make(toy).unwrapped
    width = env.action_space.shape[0]
    first, _ = env.reset(seed=1)
    kept = first.copy()
    start = env.get_state()
    found = []
    for action in (
        np.full(width, 0.5, np.float32), np.full(width, 0.5), [0.5] * width, np.full((width, 2), 0.5, np.float32)[:, 0],
    ):  # fmt: skip
        env.set_state(start)
        obs, reward, *_ = env.step(action)
        found.append((obs.tobytes(), reward))
    assert len(set(found)) == 1
    assert first.tobytes() == kept.tobytes()


def test_a_new_limit_holds_from_the_next_reset(toy, monkeypatch):
    env = gym.make(toy).unwrapped
    action = np.zeros(env.action_space.shape, np.float32)
    for limit in (5, 2, 3):
        monkeypatch.setattr(gym.registry[toy], "max_episode_steps", limit)
        env.reset(seed=0)
        assert [bool(env.step(action)[4]) for _ in range(limit)] == [False] * (limit - 1) + [True]


def test_without_the_option_metrics_an_episode_ends_without_any(toy, monkeypatch):
    """The toy has no such option: the scene is changed where the environment looks for it."""
    monkeypatch.setattr(gym.registry[toy], "max_episode_steps", 1)
    env = gym.make(toy).unwrapped
    assert isinstance(env, ScalarEnv)
    scene = env.world.scene
    for options, judged in ({"metrics": None}, False), ({"metrics": object()}, True):
        changed = dataclasses.replace(scene, options={**scene.options, **options})
        assert changed.judged is judged
    assert scene.judged
    batch = gym.make_vec(toy, 3, vectorization_mode="vector_entry_point", autoreset_mode="SAME_STEP").unwrapped
    for target in (env, batch):
        target.world.scene = dataclasses.replace(scene, options={**scene.options, "metrics": None})
        target.reset(seed=0)
    action = np.zeros(batch.action_space.shape, np.float32)
    assert env.step(action[0])[4] == {} and env.metrics() == {}
    infos = batch.step(action)[4]
    assert infos["final_info"] == {} and infos["_final_info"].all()
