"""How many environment steps one core does per second of its own time.

The clock is `time.process_time`: CPU seconds of this process, so that other processes on the machine do not count.
Actions are drawn before the clock starts, uniformly, once over their full range and once over a small part of it: what
a step costs can depend on what is done, as a ball's does on how often it bounces. Autoreset is on (NEXT_STEP), so that
resets are paid for; every step returns fresh arrays. Compilation happens in a warm-up that is not timed.
"""

from __future__ import annotations

import dataclasses
import statistics
import time

import gymnasium as gym
import numpy as np
from tqdm import tqdm

from vr_envs.envs.batch import BatchEnv
from vr_envs.envs.registry import limit_of, spec_of

ACTION_SETS = 64
ACTIONS = {"full range": 1.0, "small": 0.1}  # name -> largest absolute value
COUNTED = 20_000  # environment steps over which impacts are counted, at least
COUNTED_EPISODES = 2  # time limits over which they are counted, at least: a start is calmer than what follows
IMPACTS = "impacts_per_cycle"  # the metric of tasks whose steps have impacts


@dataclasses.dataclass(frozen=True)
class Speed:
    """Steps per CPU second of one id with one kind of actions at one number of rows, over the repeats.

    `impacts_per_step`: measured with the same actions; None for a task without impacts.
    """

    env_id: str
    actions: str
    rows: int
    repeats: int
    minimum: float
    median: float
    maximum: float
    impacts_per_step: float | None


def _seconds(env: BatchEnv, actions: np.ndarray, count: int) -> float:
    """CPU seconds of `count` calls of `env.step`."""
    sets = len(actions)
    begin = time.process_time()
    for k in range(count):
        env.step(actions[k % sets])
    return time.process_time() - begin


def impacts_per_step(env: BatchEnv, actions: np.ndarray, count: int, seed: int = 0) -> float | None:
    """Impacts per control interval over `count` calls of `env.step` after a reset; None if the task has none.

    Episodes that end are taken from the infos, those that still run at the end from the environment.
    """
    env.reset(seed=seed)
    env.step(actions[0])
    if IMPACTS not in env.world.metrics(np.arange(env.num_envs)):
        return None
    env.reset(seed=seed)
    impacts = steps = 0.0

    def add(rows: np.ndarray, rates: np.ndarray) -> None:
        nonlocal impacts, steps
        lengths = env.world.states["steps"][rows]
        impacts, steps = impacts + float((rates * lengths).sum()), steps + float(lengths.sum())

    ended = np.zeros(env.num_envs, np.bool_)
    for k in range(count):
        infos = env.step(actions[k % len(actions)])[-1]
        ended = infos.get(f"_{IMPACTS}", np.zeros(env.num_envs, np.bool_))
        if ended.any():
            add(ended, infos[IMPACTS][ended])
    running = np.flatnonzero(~ended)
    add(running, env.world.metrics(running)[IMPACTS])
    return impacts / steps


def draw(actions: str, rows: int, width: int, seed: int = 0) -> np.ndarray:
    """`ACTION_SETS` batches of actions of a kind of `ACTIONS`, float32, (sets, rows, width)."""
    size = ACTIONS[actions]
    return np.random.default_rng(seed).uniform(-size, size, (ACTION_SETS, rows, width)).astype(np.float32)


def measure(
    env_id: str, rows: int, actions: str = "full range", repeats: int = 5, seconds: float = 0.5, seed: int = 0
) -> Speed:
    """Time the native batch of `env_id` with `rows` rows, `repeats` times for about `seconds` each.

    Raises:
        ValueError: unknown id or actions, or rows or repeats below 1.
    """
    if rows < 1 or repeats < 1:
        raise ValueError(f"rows = {rows}, repeats = {repeats}; give at least 1")
    if actions not in ACTIONS:
        raise ValueError(f"actions = {actions!r}; choose one of {', '.join(ACTIONS)}")
    env = gym.make_vec(spec_of(env_id).id, num_envs=rows, vectorization_mode="vector_entry_point").unwrapped
    assert isinstance(env, BatchEnv)
    draws = draw(actions, rows, env.world.widths[1], seed)
    impacts = impacts_per_step(env, draws, max(COUNTED_EPISODES * limit_of(env_id), COUNTED // rows), seed)
    env.reset(seed=seed)
    _seconds(env, draws, 1)
    count = 1
    while (spent := _seconds(env, draws, count)) < seconds / 10.0:
        count *= 2
    count = max(1, round(count * seconds / spent))
    rates = [count * rows / _seconds(env, draws, count) for _ in range(repeats)]
    env.close()
    return Speed(spec_of(env_id).id, actions, rows, repeats, min(rates), statistics.median(rates), max(rates), impacts)


def compare(env_ids: list[str], rows: list[int], repeats: int = 5, progress: bool = False) -> list[Speed]:
    """`measure` for every id with every kind of actions at every number of rows."""
    cases = [(env_id, count, actions) for env_id in env_ids for actions in ACTIONS for count in rows]
    return [measure(*case, repeats) for case in tqdm(cases, disable=None if progress else True, unit="run")]
