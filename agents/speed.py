"""Where the time of a training goes: PPO at equal settings on a DummyVecEnv of scalar environments and on a batch."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable
from typing import Any

import gymnasium as gym
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv, VecEnv

from agents.adapter import BatchVecEnv
from agents.learn import make_batch
from vr_envs.envs.registry import spec_of

ROWS, SAMPLES = 64, 4096  # environments, and samples per update
SETTINGS: dict[str, Any] = {"batch_size": 1024, "n_epochs": 4, "gamma": 0.98, "seed": 0, "device": "cpu"}


@dataclasses.dataclass(frozen=True)
class Training:
    """CPU seconds of a training of `steps`: in the environments, in the rest of the rollouts, and in the updates."""

    env_id: str
    vec_env: str
    rows: int
    steps: int
    environments: float
    policy: float
    update: float


class _Clock:
    """CPU seconds spent within a method, nested ones included."""

    def __init__(self, owner: Any, name: str) -> None:
        self.seconds = 0.0
        method: Callable[..., Any] = getattr(owner, name)

        def timed(*args: Any, **kwargs: Any) -> Any:
            begin = time.process_time()
            try:
                return method(*args, **kwargs)
            finally:
                self.seconds += time.process_time() - begin

        setattr(owner, name, timed)


def _train(env_id: str, name: str, vec: VecEnv, steps: int) -> Training:
    torch.set_num_threads(1)
    model = PPO("MlpPolicy", vec, n_steps=SAMPLES // vec.num_envs, **SETTINGS)
    model.learn(SAMPLES)  # what is done once is not timed
    inside, rollout, update = (
        _Clock(vec, "step_wait"), _Clock(model, "collect_rollouts"), _Clock(model, "train")
    )  # fmt: skip
    begin = model.num_timesteps
    model.learn(steps, reset_num_timesteps=False)
    done = model.num_timesteps - begin
    vec.close()
    return Training(env_id, name, vec.num_envs, done, inside.seconds, rollout.seconds - inside.seconds, update.seconds)


def compare(env_id: str, steps: int) -> list[Training]:
    """Train in the default scene for at least `steps`: scalar environments, a batch of as many, and a larger one.

    Raises:
        ValueError: unknown id.
    """
    name = spec_of(env_id).id
    scalar = DummyVecEnv([lambda: Monitor(gym.make(name))] * ROWS)
    batches = [BatchVecEnv(make_batch(name, None, rows)) for rows in (ROWS, SAMPLES // 4)]
    return [
        _train(name, "DummyVecEnv of scalar environments", scalar, steps),
        *(_train(name, "native batch", batch, steps) for batch in batches),
    ]
