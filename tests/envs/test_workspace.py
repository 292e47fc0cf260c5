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


def _step(batch, scale):
    return batch.step(np.full(batch.action_space.shape, scale, np.float32))


def test_results_that_somebody_holds_are_not_written_again(toy):
    batch = gym.make_vec(toy, 3, vectorization_mode="vector_entry_point").unwrapped
    batch.reset(seed=0)
    kept, copies = [], []
    for k in range(12):
        results = _step(batch, 0.1 * k)[:4]
        kept += [*results, results[0][1], memoryview(results[1])]  # a part, and what another library would hold
        copies += [np.array(value) for value in kept[-6:]]
    assert all(np.array_equal(value, copy) for value, copy in zip(kept, copies, strict=True))


@pytest.mark.parametrize("held", range(4))
def test_one_array_is_enough_to_hold_results(toy, held):
    batch = gym.make_vec(toy, 3, vectorization_mode="vector_entry_point").unwrapped
    batch.reset(seed=0)
    first = _step(batch, 0.5)[held]
    address = first.ctypes.data
    others = [_step(batch, 0.5)[held].ctypes.data for _ in range(3)]
    assert address not in others
    assert len(set(others)) == 1, "what nobody holds is used again"


def test_a_changed_shape_stays_with_its_owner(toy):
    batch = gym.make_vec(toy, 4, vectorization_mode="vector_entry_point").unwrapped
    batch.reset(seed=0)
    obs = _step(batch, 0.5)[0]
    obs.shape = (2, 2)
    del obs
    assert _step(batch, 0.5)[0].shape == (4, 1)


def test_rows_that_do_not_move_have_zeros_for_results(toy):
    world = gym.make_vec(toy, 3, vectorization_mode="vector_entry_point").unwrapped.world
    world.reset(np.arange(3), np.arange(3, dtype=np.uint64), world.observe())
    actions = np.full((3, 1), 0.5)
    world.step(actions, np.ones(3, np.bool_), 2)
    _, rewards, terminated, truncated = world.step(actions, np.array([True, False, True]), 2)
    assert rewards[1] == 0.0 and rewards[0] > 0.0
    assert truncated.tolist() == [True, False, True] and not terminated.any()
    assert world.step(actions, np.ones(3, np.bool_), 2)[1].all()
