"""What the tests of the autopilot share: batches flown under a constant action."""

import numpy as np

from vr_envs.envs.autopilot import TASK
from vr_envs.envs.world import World

LEVEL = np.zeros(3)


def started(scene=None, n=200):  # type: ignore[no-untyped-def]
    """A world of n rows at the start of the episodes with the keys 0 to n - 1, and their observations."""
    world = World(TASK, scene, n)
    observations = np.empty((n, world.widths[0]), np.float32)
    world.reset(np.arange(n), np.arange(n, dtype=np.uint64), observations)
    return world, observations


def fly(actions, scene=None, n=200, steps=480):  # type: ignore[no-untyped-def]
    """Records after every step, (steps + 1, n), of a batch under a constant action, none of them reset; rewards."""
    world, _ = started(scene, n)
    history, rewards = [world.states.copy()], []
    for _ in range(steps):
        batch = np.broadcast_to(actions, (n, 3)).copy()
        rewards.append(world.step(batch, np.ones(n, np.bool_), 10**6)[1])
        history.append(world.states.copy())
    return np.array(history), np.array(rewards)
