"""Proximal policy optimisation on the native batch: a configuration becomes a trained network."""

from __future__ import annotations

import dataclasses
import time
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import torch
from gymnasium.vector import AutoresetMode
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import configure
from tqdm import tqdm

from agents.adapter import BatchVecEnv
from agents.config import Config
from agents.policy import policy_kwargs
from vr_envs.envs.batch import BatchEnv
from vr_envs.envs.registry import limit_of, spec_of, task_of


def make_batch(env: str, scene: Any, num_envs: int) -> BatchEnv:
    """The native batch of an environment of this suite, in SAME_STEP mode.

    Raises:
        ValueError: unknown id or scene, or an id that is not one of this suite's.
    """
    task_of(env)
    batch = gym.make_vec(spec_of(env), num_envs, scene=scene, autoreset_mode=AutoresetMode.SAME_STEP)
    assert isinstance(batch, BatchEnv)
    return batch


class Clock:
    """Wall time of the training, as a fraction of its limit."""

    def __init__(self, limit_s: float | None) -> None:
        """Start now; without a limit the time never runs out."""
        self.limit_s = limit_s
        self._start = time.perf_counter()

    def elapsed_s(self) -> float:
        """Seconds since the start."""
        return time.perf_counter() - self._start

    def remaining(self) -> float:
        """1 at the start, 0 at the limit."""
        return 1.0 if self.limit_s is None else max(0.0, 1.0 - self.elapsed_s() / self.limit_s)


class _Watch(BaseCallback):
    """Shows progress, score per step and speed; stops the training when the clock has run out."""

    def __init__(self, clock: Clock, total: int, show: bool) -> None:
        super().__init__()
        self.clock = clock
        self.bar = tqdm(total=total, unit="step", unit_scale=True, desc="training", disable=not show, mininterval=0.5)

    def _on_step(self) -> bool:
        return self.clock.remaining() > 0.0

    def _on_rollout_end(self) -> None:
        episodes = list(self.model.ep_info_buffer or ())
        self.bar.update(min(self.num_timesteps, self.bar.total) - self.bar.n)
        if episodes:
            steps = np.mean([e["l"] for e in episodes])
            self.bar.set_postfix_str(f"return {np.mean([e['r'] for e in episodes]):.1f} in {steps:.0f} steps")


@dataclasses.dataclass(frozen=True)
class Learned:
    """A trained network and how it came about."""

    model: PPO
    timesteps: int
    elapsed_s: float
    interrupted: bool


def build(config: Config, batch: BatchEnv, clock: Clock, initial_action: np.ndarray | None) -> PPO:
    """The untrained model: seeded, on one thread, its mean at `initial_action` if one is given.

    Rewards are scaled by 1 - gamma, so that the values to be learnt lie in [0, 1] as the rewards do and the
    value loss does not drown the policy's gradient in their common norm. Episodes are staggered.
    """
    torch.set_num_threads(1)
    model = PPO(
        "MlpPolicy",
        BatchVecEnv(batch, 1.0 - config.gamma, limit_of(config.env)),
        # The rate falls to 0 with the steps, or steeper in the second half of the time where that will not suffice.
        # A run that keeps within its time never feels the clock: the same seed gives the same weights.
        learning_rate=lambda remaining: config.learning_rate * min(remaining, 2.0 * clock.remaining()),
        n_steps=config.n_steps,
        batch_size=config.batch_size,
        n_epochs=config.n_epochs,
        gamma=config.gamma,
        gae_lambda=config.gae_lambda,
        ent_coef=config.ent_coef,
        clip_range=config.clip_range,
        target_kl=config.target_kl,
        stats_window_size=config.num_envs,
        policy_kwargs={**policy_kwargs(config.hidden, config.activation), "log_std_init": config.log_std_init},
        seed=config.seed,
        device="cpu",
    )
    if initial_action is not None:
        last = model.policy.action_net
        assert isinstance(last, torch.nn.Linear)
        with torch.no_grad():
            last.bias.copy_(torch.as_tensor(initial_action, dtype=torch.float32))
    return model


def learn(
    config: Config, batch: BatchEnv, initial_action: np.ndarray | None, folder: Path, show: bool = True
) -> Learned:
    """Train, logging to `progress.csv` in `folder`; Ctrl-C ends the training early and keeps what was learnt.

    Args:
        config: all settings.
        batch: the environments, `config.num_envs` of them.
        initial_action: where the policy's mean starts, or None.
        folder: an existing folder for the log.
        show: whether to show a progress bar.
    """
    # the first calls compile the kernels, which is no part of the training time
    batch.reset(seed=0)
    batch.step(np.zeros(batch.action_space.shape or (), np.float32))
    clock = Clock(config.time_limit_s)
    model = build(config, batch, clock, initial_action)
    logger = configure(str(folder), ["csv"])
    model.set_logger(logger)
    watch = _Watch(clock, config.timesteps, show)
    interrupted = False
    try:
        model.learn(config.timesteps, watch)
    except KeyboardInterrupt:
        interrupted = True
    finally:
        watch.bar.close()
        logger.close()
    return Learned(model, model.num_timesteps, clock.elapsed_s(), interrupted)
