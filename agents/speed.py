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
from tqdm import tqdm

from agents.adapter import BatchVecEnv
from agents.learn import make_batch
from vr_envs.envs.registry import spec_of

ROWS, SAMPLES = 64, 4096  # environments, and samples per update
REPEATS = 3
SETTLED = 24  # steps of every environment before the clock starts: a ball's cost grows at first
SETTINGS: dict[str, Any] = {"batch_size": 1024, "n_epochs": 4, "gamma": 0.98, "seed": 0, "device": "cpu"}


@dataclasses.dataclass
class Training:
    """CPU seconds in the environments, in the rest of the rollouts, and in the updates; lists, by repeat of `steps`."""

    env_id: str
    vec_env: str
    rows: int
    steps: int
    environments: list[float]
    policy: list[float]
    update: list[float]


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


class _Learner:
    """PPO on a vector environment, timed whenever it goes on learning."""

    def __init__(self, env_id: str, name: str, vec: VecEnv) -> None:
        self.vec, self.model = vec, PPO("MlpPolicy", vec, n_steps=SAMPLES // vec.num_envs, **SETTINGS)
        self.model.learn(max(SAMPLES, SETTLED * vec.num_envs))  # what is done once is not timed
        self.clocks = (
            _Clock(vec, "step_wait"), _Clock(self.model, "collect_rollouts"), _Clock(self.model, "train")
        )  # fmt: skip
        self.found = Training(env_id, name, vec.num_envs, 0, [], [], [])

    def go_on(self, steps: int) -> None:
        """Learn for at least `steps`, and note the times."""
        for clock in self.clocks:
            clock.seconds = 0.0
        begin = self.model.num_timesteps
        self.model.learn(steps, reset_num_timesteps=False)
        inside, rollout, update = (clock.seconds for clock in self.clocks)
        found = self.found
        found.steps = self.model.num_timesteps - begin
        found.environments.append(inside)
        found.policy.append(rollout - inside)
        found.update.append(update)


def compare(env_id: str, steps: int) -> list[Training]:
    """Train in the default scene for `REPEATS` times at least `steps`, all to and fro within a repeat.

    On scalar environments, on a batch of as many, and on a larger one.

    Raises:
        ValueError: unknown id.
    """
    name = spec_of(env_id).id
    torch.set_num_threads(1)
    batch = "native batch"
    learners = [
        _Learner(name, form, vec)
        for form, vec in (
            ("DummyVecEnv of scalar environments", DummyVecEnv([lambda: Monitor(gym.make(name))] * ROWS)),
            (batch, BatchVecEnv(make_batch(name, None, ROWS))),
            (batch, BatchVecEnv(make_batch(name, None, SAMPLES // 4))),
        )
    ]
    order = [learner for repeat in range(REPEATS) for learner in learners[:: 1 if repeat % 2 == 0 else -1]]
    for learner in tqdm(order, f"training, {spec_of(env_id).name}", leave=False, disable=None, unit="run"):
        learner.go_on(steps)
    for learner in learners:
        learner.vec.close()
    return [learner.found for learner in learners]
