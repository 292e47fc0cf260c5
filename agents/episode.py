"""An animated picture of a trained agent's episode."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import gymnasium as gym
import numpy as np

from agents.config import Config
from vr_envs.controllers.policy import Policy
from vr_envs.envs.registry import limit_of, spec_of
from vr_envs.evaluation.scenarios import scenario_keys

FRAMES = 150
FPS = 15


def frames(config: Config, policy: Policy, stride: int) -> Iterator[np.ndarray]:
    """Pictures (height, width, 3) uint8 of the first held-out scenario, one every `stride` control intervals."""
    env = gym.make(spec_of(config.env), scene=config.scene, render_mode="rgb_array")
    try:
        obs, _ = env.reset(options={"scenario": int(scenario_keys(1)[0])})
        policy.reset(1)
        ended, step = False, 0
        while not ended:
            if step % stride == 0:
                yield np.asarray(env.render())
            obs, _, terminated, truncated, _ = env.step(policy(obs[None])[0])
            ended, step = terminated or truncated, step + 1
        yield np.asarray(env.render())
    finally:
        env.close()


def film(config: Config, policy: Policy, folder: Path) -> Path:
    """Write `episode.gif` to the run's folder: about ten seconds, however long the episode."""
    from vr_envs.render import write_animation

    path = folder / "episode.gif"
    stride = math.ceil(limit_of(config.env) / FRAMES)
    write_animation(path, frames(config, policy, stride), FPS)
    return path
