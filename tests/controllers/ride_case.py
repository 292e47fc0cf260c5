"""What the tests of the ride's laws share."""

import numpy as np

from vr_envs.controllers.terrain_ride_law import settings
from vr_envs.envs.terrain_ride import TASK, TerrainRideBatchEnv
from vr_envs.envs.terrain_ride_observation import channels


def observation(scene, **values):
    """One observation (1, width): zero but for the channels given, as scaled."""
    row = np.zeros((1, len(TASK.observation_channels(scene))), np.float32)
    for name, value in values.items():
        row[0, [c.name for c in channels(scene)].index(name.replace("_", " "))] = value
    return row


def asked(law, row):
    """Damping [1/s] and modulus that a law asks for in one observation."""
    law.reset(len(row))
    damping, modulus = settings(law(row).astype(float), law.scene)
    return float(damping[0]), float(modulus[0])


def run(law, n=64, scene=None, steps=1000):
    """Mean reward of whole episodes, (n,)."""
    env = TerrainRideBatchEnv(n, scene=scene, max_episode_steps=steps, autoreset_mode="SAME_STEP")
    observations, _ = env.reset(options={"scenario": list(range(n))})
    law.reset(n)
    total, live = np.zeros(n), np.ones(n, bool)
    for _ in range(steps):
        observations, rewards, terminated, truncated, _ = env.step(law(observations))
        total += rewards * live
        live &= ~(terminated | truncated)
    return total / steps
