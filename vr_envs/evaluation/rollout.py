"""Roll a policy out: one episode per scenario, all of them in one native batch."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator

import numpy as np

from vr_envs.controllers.policy import Policy
from vr_envs.envs.scene import Scene
from vr_envs.envs.task import Task
from vr_envs.envs.world import World
from vr_envs.evaluation.scenarios import ScenarioSet


@dataclasses.dataclass(frozen=True)
class Rollout:
    """What happened, one entry per scenario.

    `scores`: sum of rewards / time limit, in [0, 1]: an episode that ends early forfeits the rest.
    `lengths`: control intervals until the end. `terminated`: ended before the time limit by failure or a true end.
    `metrics`: the task's own, by name.
    """

    scores: np.ndarray
    lengths: np.ndarray
    terminated: np.ndarray
    metrics: dict[str, np.ndarray]


def rollout(policy: Policy, scenarios: ScenarioSet, tick: Callable[[int], object] | None = None) -> Rollout:
    """The first episode of every scenario under `policy`; a finished row is not stepped again.

    A finished row shows the policy its last observation, and what the policy answers there is not used. `tick` is
    called with the number of control intervals done since its last call; they add up to `scenarios.limit`.

    Raises:
        ValueError: the policy's actions have the wrong shape, or are not finite in a row that still runs.
    """
    n = len(scenarios)
    world = World(scenarios.task, scenarios.world.as_dict(), n)
    observations = np.empty((n, world.widths[0]), np.float32)
    world.reset(np.arange(n), scenarios.keys, observations)
    policy.reset(n)
    live = np.ones(n, np.bool_)
    scores, lengths, ended = np.zeros(n), np.zeros(n, np.int64), np.zeros(n, np.bool_)
    done = 0
    while live.any() and done < scenarios.limit:
        actions = world.actions(policy(observations), (n, world.widths[1]))
        latest, rewards, terminated, truncated = world.step(actions, live, scenarios.limit)
        latest[~live] = observations[~live]
        observations = latest
        scores += rewards
        lengths += live
        ended |= terminated
        live &= ~(terminated | truncated)
        done += 1
        if tick is not None:
            tick(1)
    if tick is not None:
        tick(scenarios.limit - done)
    return Rollout(scores / scenarios.limit, lengths, ended, world.metrics(np.arange(n)))


def episode(policy: Policy, task: Task, scene: Scene, key: int, limit: int) -> Iterator[np.void]:
    """Copies of the state record of one episode: at the start and after each control interval, at most `limit`."""
    world = World(task, scene.as_dict(), 1)
    observations = np.empty((1, world.widths[0]), np.float32)
    live = np.ones(1, np.bool_)
    world.reset(np.zeros(1, np.intp), np.array([key], np.uint64), observations)
    policy.reset(1)
    yield world.states[0].copy()
    while live[0]:
        actions = world.actions(policy(observations), (1, world.widths[1]))
        observations, _, terminated, truncated = world.step(actions, live, limit)
        live = ~(terminated | truncated)
        yield world.states[0].copy()
