"""How episodes begin: from a saved record, from keys, and not at all where something is wrong."""

import gymnasium as gym
import numpy as np
import pytest

from tests.envs.sameness import IDS, same


@pytest.mark.parametrize("id", IDS)
def test_a_restored_episode_ends_where_the_record_says(id, limited):
    limited(id, 12)
    env = gym.make(id)
    env.reset(seed=0)
    action = np.zeros(env.action_space.shape, np.float32)
    for _ in range(8):
        env.step(action)
    saved = env.unwrapped.get_state()
    on = [env.step(action) for _ in range(4)]
    assert on[-1][3] and on[-1][4]["is_success"] in (True, False)
    other = gym.make(id)
    other.reset(options={"state": saved})
    same([other.step(action) for _ in range(4)], on)
    batch, plain = gym.make_vec(id, 2), gym.vector.SyncVectorEnv([lambda: gym.make(id)] * 2)
    for vector in (batch, plain):
        vector.reset(seed=1, options={"state": saved})
    for _ in range(4):
        actions = np.tile(action, (2, 1))
        same(batch.step(actions), plain.step(actions))
    assert batch._done.all()
    alone = gym.make(id).unwrapped
    alone.set_state(saved)
    assert [alone.step(action)[3] for _ in range(4)] == [False, False, False, True]
    for target in (env.unwrapped, batch):  # metrics are told beyond the limit too
        target.set_state(batch.get_state()[0] if target is env.unwrapped else batch.get_state())
        *_, truncated, info = target.step(action if target is env.unwrapped else np.tile(action, (2, 1)))
        assert np.all(truncated) and "is_success" in info


@pytest.mark.parametrize("id", IDS)
def test_a_batch_takes_one_state_or_one_each(id):
    batch = gym.make_vec(id, 3)
    batch.reset(seed=0)
    states = batch.get_state()
    batch.reset(options={"state": states[1]})
    assert [row.tobytes() for row in batch.get_state()] == [states[1].tobytes()] * 3
    with pytest.raises(ValueError, match="2 records; give one, or one for each of 3"):
        batch.reset(options={"state": states[:2]})


@pytest.mark.parametrize("id", IDS)
def test_a_refused_reset_changes_nothing(id):
    env, batch = gym.make(id).unwrapped, gym.make_vec(id, 2)
    for target in (env, batch):
        target.reset(seed=1)
        before = target.get_state().tobytes()
        with pytest.raises(ValueError, match="not a record of"):
            target.reset(seed=5, options={"state": np.zeros(1)})
        assert target.get_state().tobytes() == before
        state = gym.make(id).unwrapped
        state.reset(seed=3)
        with pytest.raises(gym.error.Error, match="Seed must be"):
            target.reset(seed=-1 if target is env else [7, -1], options={"state": state.get_state()})
        assert target.get_state().tobytes() == before
    twin = gym.make_vec(id, 2)
    twin.reset(seed=1)
    same(batch.reset()[0], twin.reset()[0])
    twin = gym.make(id).unwrapped
    twin.reset(seed=1)
    same(env.reset()[0], twin.reset()[0])


@pytest.mark.parametrize("id", IDS)
def test_keys_of_a_batch_replay_from_a_list(id):
    batch = gym.make_vec(id, 4)
    first, _ = batch.reset(seed=3)
    again, _ = batch.reset(options={"scenario": batch.get_state()["key"].tolist()})
    same(again, first)


@pytest.mark.parametrize("id", IDS)
def test_the_action_of_a_row_that_begins_anew_does_not_matter(id, limited):
    limited(id, 3)
    batch, plain = gym.make_vec(id, 40), gym.vector.SyncVectorEnv([lambda: gym.make(id)] * 40)
    for vector in (batch, plain):
        vector.reset(seed=1)
    actions = np.zeros(batch.action_space.shape, np.float32)
    for _ in range(3):
        same(batch.step(actions), plain.step(actions))
    same(batch.step(np.full_like(actions, np.nan)), plain.step(np.full_like(actions, np.nan)))
    with pytest.raises(ValueError, match=r"env 0 is \[ *5[^-0]*nan\]"):  # as it was given
        batch.step(np.where(np.arange(actions.shape[1]) == actions.shape[1] - 1, np.nan, 5.0 * np.ones_like(actions)))
