"""What every engine of every registered id owes to Gymnasium: the same task, spaces and contract, whatever moves it."""

import warnings

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env as gymnasium_check
from stable_baselines3.common.env_checker import check_env as sb3_check

import vr_envs  # noqa: F401
from vr_envs.controllers.ladder import ladder
from vr_envs.envs.registry import ids, task_of
from vr_envs.envs.scene import resolve
from vr_envs.evaluation.rollout import rollout
from vr_envs.evaluation.scenarios import scenario_set


def knows(id, scene, engine):
    """Whether the engine knows all that is in the scene."""
    try:
        return resolve(task_of(id), scene, engine).engine == engine
    except ValueError:
        return False


ALL = [(id, scene, engine) for id in ids() for engine in task_of(id).engines for scene in task_of(id).scenes]
CASES = [case for case in ALL if knows(*case)]
SCENE = {(id, engine): scene for id, scene, engine in reversed(CASES)}  # the first that the engine knows
IDS_AND_ENGINES = sorted((id, engine) for id in ids() for engine in task_of(id).engines)
SIMULATED = [(id, engine) for id, engine in IDS_AND_ENGINES if engine in task_of(id).simulators]
KERNEL = [(id, engine) for id, engine in IDS_AND_ENGINES if engine not in task_of(id).simulators]


def record(step):
    """The bytes of what `step` returned."""
    observation, reward, terminated, truncated, info = step
    return observation.tobytes(), reward, terminated, truncated, info


@pytest.mark.parametrize(("id", "scene", "engine"), CASES)
def test_spaces_and_start_are_those_of_the_exact_engine(id, scene, engine):
    other, exact = gym.make(id, scene=scene, engine=engine), gym.make(id, scene=scene)
    assert (other.unwrapped.engine, exact.unwrapped.engine) == (engine, "exact")
    assert other.observation_space == exact.observation_space
    assert other.action_space == exact.action_space
    assert other.reset(seed=4)[0].tobytes() == exact.reset(seed=4)[0].tobytes()


@pytest.mark.parametrize(("id", "scene", "engine"), CASES)
def test_checkers_pass_without_a_warning(id, scene, engine):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        gymnasium_check(gym.make(id, scene=scene, engine=engine).unwrapped, skip_render_check=True)
        sb3_check(gym.make(id, scene=scene, engine=engine))


@pytest.mark.parametrize(("id", "scene", "engine"), CASES)
def test_a_saved_state_replays_to_the_same_bytes(id, scene, engine):
    rng = np.random.default_rng(2)
    env = gym.make(id, scene=scene, engine=engine).unwrapped
    env.reset(seed=3)
    actions = rng.uniform(-0.6, 0.6, (24, *env.action_space.shape)).astype(np.float32)
    for action in actions[:8]:
        env.step(action)
    saved = env.get_state()
    first = [record(env.step(action)) for action in actions[8:]]
    env.set_state(saved)
    assert [record(env.step(action)) for action in actions[8:]] == first
    other = gym.make(id, scene=scene, engine=engine).unwrapped
    other.reset(options={"state": saved})
    assert [record(other.step(action)) for action in actions[8:]] == first
    assert other.get_state().tobytes() == env.get_state().tobytes()


@pytest.mark.parametrize(("id", "engine"), IDS_AND_ENGINES)
def test_an_episode_follows_from_its_seed_and_ends_with_its_metrics(id, engine):
    def episode(seed):
        env = gym.make(id, scene=SCENE[id, engine], engine=engine)
        env.reset(seed=seed)
        env.action_space.seed(seed)
        steps = []
        while not steps or not (steps[-1][2] or steps[-1][3]):
            steps.append(record(env.step(env.action_space.sample())))
        return steps

    first = episode(8)
    assert first == episode(8)
    assert first != episode(9)
    assert (
        "is_success" in first[-1][4]
        and first[-1][4].keys() == gym.make(id, scene=SCENE[id, engine]).unwrapped.metrics().keys()
    )
    assert all(step[4] == {} and 0.0 <= step[1] <= 1.0 for step in first[:-1])


@pytest.mark.parametrize(("id", "engine"), IDS_AND_ENGINES)
def test_the_scene_says_which_engine_it_has(id, engine):
    task, scene = task_of(id), SCENE[id, engine]
    named = resolve(task, scene, engine)
    assert named.engine == engine
    assert named == resolve(task, {"base": scene, engine: True}) == resolve(task, named.as_dict())
    assert engine in named.label
    assert resolve(task, named.as_dict(), "exact") == resolve(task, {"base": scene})
    assert resolve(task, named.as_dict(), engine) == named
    assert gym.make(id, scene=named.as_dict()).unwrapped.engine == engine


@pytest.mark.parametrize(("id", "scene", "engine"), [case for case in ALL if case not in CASES])
def test_a_scene_that_an_engine_does_not_know_is_refused_with_the_reason(id, scene, engine):
    for make in (lambda: gym.make(id, scene=scene, engine=engine), lambda: resolve(task_of(id), scene, engine)):
        with pytest.raises(ValueError, match=f"engine '{engine}'"):
            make()


@pytest.mark.parametrize(("id", "engine"), SIMULATED)
def test_a_native_batch_refuses_a_simulator_and_a_sync_one_has_it(id, engine):
    scene = SCENE[id, engine]
    for arguments in ({"scene": scene, "engine": engine}, {"scene": {"base": scene, engine: True}}):
        with pytest.raises(ValueError, match=f"engine '{engine}' moves one environment at a time.*vectorization_mode"):
            gym.make_vec(id, 2, **arguments)
    batch = gym.make_vec(id, 2, scene=scene, engine=engine, vectorization_mode="sync")
    batch.reset(seed=0)
    single = gym.make(id, scene=scene, engine=engine)
    single.reset(seed=1)
    actions = np.zeros(batch.action_space.shape, np.float32)
    assert batch.step(actions)[0][1].tobytes() == single.step(actions[1])[0].tobytes()


@pytest.mark.parametrize(("id", "engine"), KERNEL)
def test_a_native_batch_of_a_kernel_engine_is_the_scalar_env(id, engine):
    made = {"scene": SCENE[id, engine], "engine": engine}
    batch, single = gym.make_vec(id, 3, **made), gym.make(id, **made)
    assert batch.engine == engine
    batch.reset(seed=0)
    single.reset(seed=2)
    rng = np.random.default_rng(1)
    for action in rng.uniform(-0.5, 0.5, (20, *single.action_space.shape)).astype(np.float32):
        rows = batch.step(np.tile(action, (3, 1)))
        assert rows[0][2].tobytes() == single.step(action)[0].tobytes()


@pytest.mark.parametrize(("id", "engine"), SIMULATED)
def test_bad_actions_are_refused_and_change_nothing(id, engine):
    made = {"scene": SCENE[id, engine], "engine": engine}
    env = gym.make(id, **made).unwrapped
    env.reset(seed=0)
    before = env.get_state()
    with pytest.raises(ValueError, match="finite"):
        env.step(np.full(env.action_space.shape, np.nan))
    assert before.tobytes() == env.get_state().tobytes()
    beyond, edge = (gym.make(id, **made).unwrapped for _ in range(2))
    for twin in (beyond, edge):
        twin.reset(seed=0)
    shape = env.action_space.shape
    assert record(beyond.step(np.full(shape, 3.0))) == record(edge.step(np.ones(shape)))


@pytest.mark.parametrize(("id", "engine"), SIMULATED)
def test_a_rollout_is_the_episodes_of_the_env(id, engine):
    scene = resolve(task_of(id), SCENE[id, engine], engine).as_dict()
    scenarios = scenario_set(id, scene, n=2)
    policy = next(iter(ladder(scenarios.task, scenarios.scene).values()))
    ticks = []
    found = rollout(policy, scenarios, ticks.append)
    assert sum(ticks) == scenarios.limit and len(ticks) > scenarios.limit // 2
    for key, score in zip(scenarios.keys, found.scores, strict=True):
        env = gym.make(id, scene=SCENE[id, engine], engine=engine)
        observation, _ = env.reset(options={"scenario": int(key)})
        total, ended = 0.0, False
        while not ended:
            observation, reward, terminated, truncated, _ = env.step(policy(observation[None])[0])
            total, ended = total + reward, terminated or truncated
        assert score == pytest.approx(total / scenarios.limit, abs=1e-12)


@pytest.mark.parametrize("id", ids())
def test_an_unknown_engine_is_refused_with_those_that_there_are(id):
    listed = ", ".join(task_of(id).engine_names)
    for make in (lambda **a: gym.make(id, **a), lambda **a: gym.make_vec(id, 2, **a)):
        with pytest.raises(ValueError, match=f"has no engine 'bullet'; choose one of {listed}"):
            make(engine="bullet")
    assert gym.make(id, engine="exact").unwrapped.engine == "exact"
