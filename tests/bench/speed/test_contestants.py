import gymnasium as gym
import numpy as np
import pytest

from vr_envs.bench.speed import contestants
from vr_envs.bench.speed.arrays.namespace import NUMPY
from vr_envs.bench.speed.arrays.terrain_ride import RideArrays
from vr_envs.bench.speed.contestants import CASES, Case, cases_of
from vr_envs.envs.ball_on_bar import BallOnBarBatchEnv


def test_cases_are_scenes_of_every_id_and_both_kinds_of_actions_of_the_ball():
    assert {case.env_id for case in CASES} == {id for id in gym.registry if id.startswith("vr_envs/")}
    assert {case.actions for case in CASES if case.env_id == "vr_envs/BallOnBar-v0"} == {"full range", "small"}
    assert len({case.label for case in CASES}) == len(CASES)
    assert cases_of(None) == list(CASES)
    assert cases_of(["TerrainRide", "TerrainRide-v0"]) == [c for c in CASES if c.env_id == "vr_envs/TerrainRide-v0"]


def test_an_id_without_cases_is_measured_in_its_default_scene(toy):
    assert cases_of([toy]) == [Case(toy, None, "full range"), Case(toy, None, "small")]
    with pytest.raises(ValueError, match="no environment 'Nothing'"):
        cases_of(["Nothing"])


@pytest.mark.parametrize("form", [contestants.native, contestants.sync])
def test_a_call_moves_every_row_by_one_step_and_resets_what_has_ended(toy, form, monkeypatch):
    monkeypatch.setattr(gym.registry[toy], "max_episode_steps", 4)
    seen = []
    original = contestants._stepping
    monkeypatch.setattr(contestants, "_stepping", lambda env, actions: seen.append(env) or original(env, actions))
    work = form(Case(toy, None), 3)
    env = seen[0]
    for steps in (1, 2, 3, 4, 0, 1):
        work()
        batch = env.unwrapped if form is contestants.native else None
        counts = (
            batch.world.states["steps"].tolist()
            if batch is not None
            else [e.unwrapped.world.states["steps"].item() for e in env.envs]
        )
        assert counts == [steps] * 3


def test_one_environment_is_made_with_its_wrappers_and_reset_when_an_episode_ends(toy, monkeypatch):
    monkeypatch.setattr(gym.registry[toy], "max_episode_steps", 3)
    seen = []
    original = contestants._episodes
    monkeypatch.setattr(contestants, "_episodes", lambda env, actions: seen.append(env) or original(env, actions))
    work = contestants.scalar(Case(toy, None))
    assert isinstance(seen[0], gym.wrappers.TimeLimit)
    counts = []
    for _ in range(4):
        work()
        counts.append(seen[0].unwrapped.world.states["steps"].item())
    assert counts == [1, 2, 0, 1]


def test_unknown_actions_are_refused():
    with pytest.raises(ValueError, match="full range, small"):
        contestants.draw("none", 1, 1)


@pytest.mark.parametrize(("actions", "size"), [("full range", 1.0), ("small", 0.1)])
def test_actions_fill_their_range(actions, size):
    drawn = contestants.draw(actions, 100, 6)
    assert drawn.shape == (contestants.ACTION_SETS, 100, 6) and drawn.dtype == np.float32
    assert 0.99 * size < drawn.max() <= np.float32(size) and 0.99 * size < -drawn.min() <= np.float32(size)
    assert np.abs(drawn).mean() == pytest.approx(0.5 * size, rel=0.02)


@pytest.mark.parametrize("rows", [1, 8])
def test_impacts_are_counted_over_all_episodes(rows):
    """Against the growth of the counter in the records, step by step; the limit makes episodes end in between."""
    actions = contestants.draw("small", rows, 6)
    env, twin = (BallOnBarBatchEnv(rows, max_episode_steps=30) for _ in range(2))
    found = contestants.impacts_per_step(env, actions, 75)
    twin.reset(seed=0)
    impacts = steps = 0
    for k in range(75):
        before = twin.get_state()
        twin.step(actions[k % len(actions)])
        after = twin.get_state()
        moved = after["steps"] > before["steps"]
        impacts += (after["impacts"] - before["impacts"])[moved].sum()
        steps += moved.sum()
    assert steps < 75 * rows
    assert found == pytest.approx(impacts / steps, rel=1e-13)


def test_an_opponent_is_compiled_once_for_all_kinds_of_actions():
    compiled = []
    arrays = NUMPY._replace(compiled=lambda function: compiled.append(function) or function)
    for actions in contestants.ACTIONS:
        work = contestants.on_arrays(Case("vr_envs/TerrainRide-v0", "lecture", actions, None, RideArrays), 3, arrays)
        work()
        work()
    assert len(compiled) == 1
