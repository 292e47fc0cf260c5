import math

import gymnasium as gym
import numpy as np
import pytest

from tests.toy import DT, LIMIT, Proportional
from vr_envs.controllers.policy import Constant, Random
from vr_envs.evaluation.rollout import episode, rollout
from vr_envs.evaluation.scenarios import scenario_set
from vr_envs.models.noise import uniform

NARROW = {"base": "narrow", "start": 0.6}


class Strange:
    """Random, but NaN where a row shows the same observation twice."""

    def reset(self, n):
        self.inner = Random(1, seed=5)
        self.last = np.full((n, 1), np.nan, np.float32)

    def __call__(self, observations):
        actions = self.inner(observations)
        actions[observations == self.last] = np.nan
        self.last = observations
        return actions


def test_score_of_doing_nothing_is_the_closed_form(toy):
    scenarios = scenario_set(toy, n=20)
    run = rollout(Constant(np.zeros(1)), scenarios)
    for key, score in zip(scenarios.keys, run.scores, strict=True):
        start = 2.0 * uniform(key, 0) - 1.0
        x = start * np.exp(-DT * np.arange(1, LIMIT + 1))
        assert score == pytest.approx(np.mean(1.0 / (1.0 + x * x)), rel=1e-13)
    assert (run.lengths == LIMIT).all()
    assert not run.terminated.any()


def test_an_early_end_forfeits_the_rest(toy):
    scenarios = scenario_set(toy, NARROW, n=50)
    run = rollout(Constant(np.ones(1)), scenarios)
    assert run.terminated.all()
    assert run.lengths.min() < run.lengths.max() < LIMIT
    assert (run.scores <= run.lengths / LIMIT).all()


def test_equals_the_first_episodes_of_the_registered_batch(toy):
    scenarios = scenario_set(toy, NARROW, n=64)
    run = rollout(Random(1, seed=5), scenarios)
    assert 0 < run.terminated.sum() < 64
    env = gym.make_vec(toy, num_envs=64, scene=NARROW)
    observations, _ = env.reset(options={"scenario": scenarios.keys})
    policy, live, scores = Random(1, seed=5), np.ones(64, bool), np.zeros(64)
    rms, lengths = np.zeros(64), np.zeros(64, int)
    for _ in range(LIMIT):
        observations, rewards, terminated, truncated, infos = env.step(policy(observations))
        scores += np.where(live, rewards, 0.0)
        lengths += live
        ending = live & (terminated | truncated)
        if ending.any():
            rms[ending] = infos["rms"][ending]
        live &= ~ending
    assert not live.any()
    assert (run.scores == scores / LIMIT).all()
    assert (run.lengths == lengths).all()
    assert (run.metrics["rms"] == rms).all()


def test_equals_the_scalar_environment(toy):
    scenarios = scenario_set(toy, "biased", n=5)
    run = rollout(Proportional(scenarios.scene, 2.0), scenarios)
    env = gym.make(toy, scene="biased")
    for k, key in enumerate(scenarios.keys):
        observation, _ = env.reset(options={"scenario": int(key)})
        total, done = 0.0, False
        while not done:
            observation, reward, terminated, truncated, info = env.step(
                Proportional(scenarios.scene, 2.0)(observation[None])[0]
            )
            total += reward
            done = terminated or truncated
        assert run.scores[k] == total / LIMIT
        assert run.metrics["rms"][k] == info["rms"]


def test_what_a_policy_answers_in_a_finished_row_is_not_used(toy):
    scenarios = scenario_set(toy, NARROW, n=64)
    plain, strange = rollout(Random(1, seed=5), scenarios), rollout(Strange(), scenarios)
    assert (plain.scores == strange.scores).all()


def test_an_action_that_is_not_finite_in_a_live_row_is_an_error(toy):
    with pytest.raises(ValueError, match="action of env 0 is"):
        rollout(Constant(np.array([math.nan])), scenario_set(toy, n=3))


@pytest.mark.parametrize("action", [0.0, 1.0])
def test_ticks_add_up_to_the_time_limit(toy, action):
    ticks = []
    rollout(Constant(np.array([action])), scenario_set(toy, NARROW, n=5), ticks.append)
    assert sum(ticks) == LIMIT


@pytest.mark.parametrize("scene", ["biased", NARROW])
def test_the_states_of_an_episode_lead_to_the_metrics_of_the_rollout(toy, scene):
    scenarios = scenario_set(toy, scene, n=5)
    run = rollout(Constant(np.ones(1)), scenarios)
    for k, key in enumerate(scenarios.keys):
        states = list(episode(Constant(np.ones(1)), scenarios.task, scenarios.world, int(key), LIMIT))
        assert [state["steps"] for state in states] == list(range(run.lengths[k] + 1))
        assert states[-1]["x"] == run.metrics["final"][k]
