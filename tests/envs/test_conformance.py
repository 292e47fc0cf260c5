"""What every registered id owes to Gymnasium and to its own batch. Runs over the registry, not over a list."""

import warnings

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env as gymnasium_check
from gymnasium.vector import AutoresetMode
from stable_baselines3.common.env_checker import check_env as sb3_check

from tests.envs.sameness import IDS, same
from vr_envs.envs.scene import resolve

ROWS, STEPS = 64, 1000
LIMIT = 70  # steps: short episodes, so that 1000 steps see many ends of both kinds in every row


def scenes_of(id):
    return list(gym.make(id).unwrapped.task.scenes)


CASES = [(id, scene) for id in IDS for scene in scenes_of(id)]

# one scene of every id in which random actions end episodes long before the time limit, and not always
PERILOUS = {
    "vr_envs/Autopilot-v1": {"altitude_low": 20.0, "altitude_high": 100.0, "speed_low": 62.0, "speed_high": 80.0},
    "vr_envs/BallOnBar-v0": {"restitution": 0.8},
    "vr_envs/TerrainRide-v0": {"road": {"iso_class": "E"}},
}


@pytest.mark.parametrize("id", IDS)
def test_three_ids_are_registered_with_a_batch(id):
    assert gym.spec(id).vector_entry_point is not None
    assert gym.spec(id).max_episode_steps is not None


@pytest.mark.parametrize(("id", "scene"), CASES)
def test_checkers_pass_without_a_warning(id, scene):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        gymnasium_check(gym.make(id, scene=scene).unwrapped)
        gymnasium_check(gym.make(id, scene=scene, render_mode="rgb_array").unwrapped)
        sb3_check(gym.make(id, scene=scene))


@pytest.mark.parametrize("mode", ["NEXT_STEP", "SAME_STEP"])
@pytest.mark.parametrize(("id", "scene"), [*CASES, *((id, None) for id in IDS)])
def test_batch_is_the_sync_vector_env_byte_for_byte(id, scene, mode, limited):
    """In every preset, and, where `scene` is None, where episodes end in both ways."""
    limited(id, LIMIT)
    both_ways = scene is None
    scene = PERILOUS[id] if both_ways else scene
    rng = np.random.default_rng(11)
    batch = gym.make_vec(id, ROWS, scene=scene, autoreset_mode=mode)
    plain = gym.vector.SyncVectorEnv([lambda: gym.make(id, scene=scene)] * ROWS, autoreset_mode=AutoresetMode[mode])
    assert batch.single_observation_space == plain.single_observation_space
    assert batch.observation_space == plain.observation_space
    assert batch.action_space == plain.action_space
    assert batch.metadata["autoreset_mode"] is plain.metadata["autoreset_mode"]
    same(batch.reset(seed=5), plain.reset(seed=5))
    assert batch.np_random_seed == plain.np_random_seed
    ended = np.zeros(2, int)
    for _ in range(STEPS):
        actions = rng.uniform(-1.2, 1.2, (ROWS, *batch.single_action_space.shape)).astype(np.float32)
        mine, theirs = batch.step(actions), plain.step(actions)
        same(mine, theirs)
        ended += mine[2].sum(), mine[3].sum()
    assert ended[1] > 0, "no episode was truncated"
    assert not both_ways or ended[0] > 0, "no episode terminated"


@pytest.mark.parametrize("id", IDS)
def test_disabled_mode_is_the_sync_vector_env_whatever_ended_rows_are_reset_together(id, limited):
    """The rows that ended are reset in two parts, at random, some of them terminated and some truncated."""
    limited(id, LIMIT)
    rng = np.random.default_rng(12)
    batch = gym.make_vec(id, ROWS, scene=PERILOUS[id], autoreset_mode="DISABLED")
    plain = gym.vector.SyncVectorEnv(
        [lambda: gym.make(id, scene=PERILOUS[id])] * ROWS, autoreset_mode=AutoresetMode.DISABLED
    )
    same(batch.reset(seed=6), plain.reset(seed=6))
    ended, parted = np.zeros(2, int), 0
    for _ in range(300):
        actions = rng.uniform(-1.2, 1.2, (ROWS, *batch.single_action_space.shape)).astype(np.float32)
        mine, theirs = batch.step(actions), plain.step(actions)
        same(mine, theirs)
        done = mine[2] | mine[3]
        ended += mine[2].sum(), mine[3].sum()
        first = done & (rng.random(ROWS) < 0.5)
        parts = [part for part in (first, done & ~first) if part.any()]
        parted += len(parts) == 2
        for k, part in enumerate(parts):
            same(batch.reset(options={"reset_mask": part}), plain.reset(options={"reset_mask": part.copy()}))
            if k + 1 < len(parts):
                with pytest.raises(gym.error.ResetNeeded, match="has ended"):
                    batch.step(actions)
    assert (ended > 0).all() and parted > 0


@pytest.mark.parametrize("id", IDS)
def test_levels_differ_from_the_default_scene_in_what_they_say(id):
    task = gym.make(id).unwrapped.task
    usual = resolve(task).as_dict()
    assert "nominal" in task.levels
    for level, changes in task.levels.items():
        env = gym.make(id, scene=changes).unwrapped
        scene = env.world.scene.as_dict()
        told = {}
        for key, change in changes.items():
            told[key] = {**usual[key], **change} if isinstance(change, dict) else change
            assert told[key] != usual[key], (level, key)
        assert scene == {**usual, **told}
        assert (env.world.scene.label == resolve(task).label) == (level == "nominal")


@pytest.mark.parametrize("id", IDS)
def test_disabled_mode_resets_only_the_masked_rows(id, limited):
    limited(id, 3)
    batch = gym.make_vec(id, 4, autoreset_mode="Disabled")
    plain = gym.vector.SyncVectorEnv([lambda: gym.make(id)] * 4, autoreset_mode=AutoresetMode.DISABLED)
    same(batch.reset(seed=1), plain.reset(seed=1))
    actions = np.zeros(batch.action_space.shape, np.float32)
    for _ in range(3):
        same(batch.step(actions), plain.step(actions))
    with pytest.raises(gym.error.ResetNeeded, match="env 0 has ended"):
        batch.step(actions)
    mask = np.array([True, False, True, True])
    same(batch.reset(options={"reset_mask": mask}), plain.reset(options={"reset_mask": mask.copy()}))
    with pytest.raises(gym.error.ResetNeeded, match="env 1 has ended"):
        batch.step(actions)
    mask = np.array([False, True, False, False])
    same(batch.reset(options={"reset_mask": mask}), plain.reset(options={"reset_mask": mask.copy()}))
    same(batch.step(actions), plain.step(actions))


@pytest.mark.parametrize(("id", "scene"), CASES)
def test_a_saved_state_replays_to_the_same_bytes(id, scene):
    rng = np.random.default_rng(2)
    env = gym.make(id, scene=scene).unwrapped
    env.reset(seed=3)
    actions = rng.uniform(-0.6, 0.6, (40, *env.action_space.shape)).astype(np.float32)
    for action in actions[:15]:
        env.step(action)
    saved = env.get_state()

    def replay(target):
        return [target.step(action) for action in actions[15:]]

    first = replay(env)
    env.set_state(saved)
    same(first, replay(env))
    other = gym.make(id, scene=scene).unwrapped
    observation, _ = other.reset(options={"state": saved})
    same(first, replay(other))
    batch = gym.make_vec(id, 3, scene=scene)
    observations, _ = batch.reset(options={"state": np.array([saved] * 3)})
    assert all(row.tobytes() == observation.tobytes() for row in observations)
    for step, action in zip(first, actions[15:], strict=True):
        rows, rewards, *_ = batch.step(np.tile(action, (3, 1)))
        assert all(row.tobytes() == step[0].tobytes() for row in rows)
        assert (rewards == step[1]).all()
    assert batch.get_state()[2].tobytes() == env.get_state().tobytes()


@pytest.mark.parametrize("id", IDS)
def test_a_scenario_fixes_start_and_disturbances(id):
    env = gym.make(id)
    rng = np.random.default_rng(0)
    actions = rng.uniform(-0.5, 0.5, (30, *env.action_space.shape)).astype(np.float32)

    def episode(seed, scenario):
        first, _ = env.reset(seed=seed, options={"scenario": scenario})
        return first.tobytes(), *(env.step(a)[0].tobytes() for a in actions)

    assert episode(1, 2**63 + 5) == episode(2, 2**63 + 5)
    assert episode(1, 2**63 + 5) != episode(1, 6)
    batch = gym.make_vec(id, 2)
    rows, _ = batch.reset(options={"scenario": np.array([6, 2**63 + 5], np.uint64)})
    assert rows[1].tobytes() == episode(3, 2**63 + 5)[0]


@pytest.mark.parametrize("id", IDS)
def test_returned_types_are_the_contract(id):
    env = gym.make(id)
    observation, info = env.reset(seed=0)
    assert observation.dtype == np.float32
    assert info == {}
    step = env.step(np.zeros(env.action_space.shape, np.float32))
    assert [type(v) for v in step] == [np.ndarray, float, bool, bool, dict]
    assert 0.0 <= step[1] <= 1.0


@pytest.mark.parametrize("id", IDS)
def test_the_last_info_has_success_and_metrics(id, limited):
    limited(id, 2)
    env = gym.make(id)
    env.reset(seed=0)
    action = np.zeros(env.action_space.shape, np.float32)
    assert env.step(action)[4] == {}
    *_, truncated, info = env.step(action)
    assert truncated
    assert type(info["is_success"]) is bool
    assert len(info) >= 3
    assert env.unwrapped.metrics() == info


@pytest.mark.parametrize("id", IDS)
def test_metrics_can_be_asked_for_under_another_time_limit(id):
    env = gym.make(id, max_episode_steps=2)
    env.reset(seed=0)
    action = np.zeros(env.action_space.shape, np.float32)
    env.step(action)
    assert env.step(action)[3]
    assert "is_success" in env.unwrapped.metrics()


@pytest.mark.parametrize("id", IDS)
def test_bad_actions_are_refused_and_change_nothing(id):
    batch = gym.make_vec(id, 5)
    batch.reset(seed=0)
    good = np.zeros(batch.action_space.shape, np.float32)
    before = batch.get_state()
    bad = good.copy()
    bad[3, 0] = np.nan
    with pytest.raises(ValueError, match="env 3"):
        batch.step(bad)
    bad[3, 0] = np.inf
    with pytest.raises(ValueError, match="env 3"):
        batch.step(bad)
    with pytest.raises(ValueError, match="shape"):
        batch.step(good[:4])
    with pytest.raises(ValueError, match="not an array"):
        batch.step("left")
    same(before, batch.get_state())
    env = gym.make(id).unwrapped
    env.reset(seed=0)
    before = env.get_state()
    with pytest.raises(ValueError, match="shape"):
        env.step(np.zeros(99))
    with pytest.raises(ValueError, match="finite"):
        env.step(np.full(env.action_space.shape, np.nan))
    same(before, env.get_state())


@pytest.mark.parametrize("id", IDS)
def test_bad_arguments_say_what_was_given_and_what_is_allowed(id):
    for arguments, message in [
        ({"scene": "nowhere"}, "nowhere.*choose one of"),
        ({"scene": {"no_such_key": 1}}, "no_such_key.*Allowed"),
        ({"scene": 3}, "scene = 3"),
        ({"render_mode": "ansi"}, "ansi"),
    ]:
        with pytest.raises(ValueError, match=message):
            gym.make(id, **arguments)
    for steps in (0, 2.5, True):
        with pytest.raises(ValueError, match="max_episode_steps.*whole number"):
            gym.make_vec(id, 2, vectorization_mode="vector_entry_point", max_episode_steps=steps)
    gym.make_vec(id, 2, vectorization_mode="vector_entry_point", max_episode_steps=2**64)
    with pytest.raises(ValueError, match="num_envs"):
        gym.make_vec(id, 0)
    with pytest.raises(ValueError, match="autoreset_mode = 'sometimes'.*NEXT_STEP"):
        gym.make_vec(id, 2, autoreset_mode="sometimes")
    with pytest.raises(gym.error.ResetNeeded):
        gym.make(id).unwrapped.step(np.zeros(2))
    env = gym.make(id).unwrapped
    for options, message in [
        ({"scenario": -1}, "scenario"),
        ({"scenario": 0.5}, "scenario"),
        ({"weather": 1}, "weather.*allowed"),
        ({"state": np.zeros(1)}, "not a record of"),
    ]:
        with pytest.raises(ValueError, match=message):
            env.reset(options=options)
    with pytest.raises(gym.error.NameNotFound):
        gym.make("vr_envs/Nothing-v0")


@pytest.mark.parametrize("id", IDS)
def test_a_spec_survives_json(id):
    env = gym.make(id, scene={"base": scenes_of(id)[0]})
    again = gym.make(gym.envs.registration.EnvSpec.from_json(env.spec.to_json()))
    same(env.reset(seed=4)[0], again.reset(seed=4)[0])
