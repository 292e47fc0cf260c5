"""What the tests of the autopilot's laws share."""

import numpy as np

from vr_envs.envs.autopilot import TASK
from vr_envs.envs.world import World
from vr_envs.models.atmosphere import airspeed

STILL = {"turbulence": None}


def world_at(errors, scene="lecture", altitude=5000.0, speed=150.0):  # type: ignore[no-untyped-def]
    """Rows in level flight (true airspeed) whose demands are `errors` (n, 3) away, for ever."""
    errors = np.atleast_2d(errors)
    n = len(errors)
    world = World(TASK, scene, n)
    observations = np.empty((n, 23), np.float32)
    world.reset(np.arange(n), np.arange(n, dtype=np.uint64), observations)
    atmosphere = None if world.scene.options["atmosphere"] is None else True
    world.states["altitude"], world.states["speed"], world.states["heading"] = altitude, speed, 0.0
    world.states["demand"] = np.array([altitude, airspeed(altitude, speed, atmosphere), 0.0]) + errors
    world.states["demand_rate"], world.states["next_change"] = 0.0, 1e9
    return world


def flown(world, law, steps):  # type: ignore[no-untyped-def]
    """Records (steps + 1, n) of a world under a law, and its actions (steps, n, 3)."""
    n = len(world.states)
    law.reset(n)
    history, actions = [world.states.copy()], []
    for _ in range(steps):
        actions.append(law(world.observe()))
        world.step(actions[-1].astype(np.float64), np.ones(n, np.bool_), 10**6)
        history.append(world.states.copy())
    return np.array(history), np.array(actions)
