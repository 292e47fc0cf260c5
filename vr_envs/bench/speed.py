"""How many environment steps one core does per second of its own time.

The clock is `time.process_time`: CPU seconds of this process, so that other processes on the machine do not count.
Actions are drawn before the clock starts, uniformly; autoreset is on (NEXT_STEP), so that resets are paid for; every
step returns fresh arrays. Compilation happens in a warm-up that is not timed.
"""

from __future__ import annotations

import dataclasses
import statistics
import time

import gymnasium as gym
import numpy as np
from tqdm import tqdm

from vr_envs.envs.registry import spec_of

ACTION_SETS = 64


@dataclasses.dataclass(frozen=True)
class Speed:
    """Steps per CPU second of one id at one number of rows, over the repeats."""

    env_id: str
    rows: int
    repeats: int
    minimum: float
    median: float
    maximum: float


def _seconds(env: gym.vector.VectorEnv, actions: np.ndarray, count: int) -> float:
    """CPU seconds of `count` calls of `env.step`."""
    sets = len(actions)
    begin = time.process_time()
    for k in range(count):
        env.step(actions[k % sets])
    return time.process_time() - begin


def measure(env_id: str, rows: int, repeats: int = 5, seconds: float = 0.5, seed: int = 0) -> Speed:
    """Time the native batch of `env_id` with `rows` rows, `repeats` times for about `seconds` each.

    Raises:
        ValueError: unknown id, or rows or repeats below 1.
    """
    if rows < 1 or repeats < 1:
        raise ValueError(f"rows = {rows}, repeats = {repeats}; give at least 1")
    env = gym.make_vec(spec_of(env_id).id, num_envs=rows, vectorization_mode="vector_entry_point")
    width = env.single_action_space.shape[0]  # type: ignore[index]
    draws = np.random.default_rng(seed).uniform(-1.0, 1.0, (ACTION_SETS, rows, width))
    actions = draws.astype(np.float32)
    env.reset(seed=seed)
    _seconds(env, actions, 1)
    count = 1
    while (spent := _seconds(env, actions, count)) < seconds / 10.0:
        count *= 2
    count = max(1, round(count * seconds / spent))
    rates = [count * rows / _seconds(env, actions, count) for _ in range(repeats)]
    env.close()
    return Speed(spec_of(env_id).id, rows, repeats, min(rates), statistics.median(rates), max(rates))


def compare(env_ids: list[str], rows: list[int], repeats: int = 5, progress: bool = False) -> list[Speed]:
    """`measure` for every id at every number of rows."""
    pairs = [(env_id, count) for env_id in env_ids for count in rows]
    return [
        measure(env_id, count, repeats) for env_id, count in tqdm(pairs, disable=None if progress else True, unit="run")
    ]
