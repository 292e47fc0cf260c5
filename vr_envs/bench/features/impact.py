"""What an impact of the ball costs on one core, what each option adds, and what an absent one costs: nothing.

A compiled loop moves one ball through episodes, without observation; the clock is `time.process_time`. All kernels are
timed in turn within each repeat, so that a ratio compares times taken side by side. Compilation is not timed.
"""

from __future__ import annotations

import dataclasses
import statistics
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from typing import Any

import numpy as np
from tqdm import tqdm

from vr_envs.bench.features.stripped import stripped
from vr_envs.envs.registry import task_of
from vr_envs.envs.scene import resolve
from vr_envs.models.ball_on_bar import State, advance
from vr_envs.models.ball_options import OPTIONS
from vr_envs.models.jit import kernel
from vr_envs.models.record import dtype_of

TASK = "BallOnBar-v0"
EPISODE = 150  # base cycles
HEIGHT = 0.002  # m, of a ball at the start

STILL = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
SINK = (0.4, 0.0, 0.5, 0.0, 0.0, 0.0)  # peak accelerations 4 m/s^2, 50 rad/s^2, 8 m/s^2; tilt phase +pi/2: Bell's sink
HIGH = (0.4, 0.0, 0.5, 0.0, 0.5, 0.0)  # z at 10 m/s^2: a ball with every loss still bounces
PLAIN: dict[str, Any] = {"scatter": None}
WIDE = {"half_length": 0.07}  # Bell's is 0.025 m: the ball stays longer, and a lens is nowhere steeper than 45 degrees

SCENES: dict[str, tuple[Mapping[str, Any], tuple[float, ...]]] = {
    "vertical, period one": (PLAIN, STILL),
    "vertical, chatter": (PLAIN | {"restitution": 0.5, "z_acceleration": 20.0}, STILL),
    "tilting, no option": (PLAIN, SINK),
    "bell": ({"base": "bell"}, SINK),
    "rolling": ({"base": "rolling"} | WIDE, SINK),
    "lens": ({"base": "lens"}, SINK),
    "everything": ({name: True for name in OPTIONS if name not in ("camera", "textbook")}, HIGH),
}
"""Name -> what the scene changes, and the constant action."""

PRICED = {name: (PLAIN | WIDE | {name: True}, SINK) for name in OPTIONS}
"""One option at a time, over the plain tilting bar."""
BASIS = (PLAIN | WIDE, SINK)
PRUNED = ("vertical, period one", "vertical, chatter", "tilting, no option")
"""Scenes without any option, compared with kernels that never had one."""


@dataclasses.dataclass(frozen=True)
class Spread:
    """Smallest, median and largest of the repeats."""

    minimum: float
    median: float
    maximum: float

    @classmethod
    def of(cls, values: list[float]) -> Spread:
        """Of a list."""
        return cls(min(values), statistics.median(values), max(values))


@dataclasses.dataclass(frozen=True)
class Cost:
    """What one kernel costs: ns of CPU time per impact, per cycle the impacts, and the time over a basis' time."""

    name: str
    nanoseconds: Spread
    impacts_per_cycle: float
    ratio: Spread | None


@dataclasses.dataclass
class Work:
    """A kernel with what it works on; `run(episodes)` returns (impacts, base cycles)."""

    name: str
    run: Callable[[int], tuple[int, int]]
    state: np.ndarray
    episodes: int = 1


def loop_of(advance: Any) -> Any:
    """A compiled loop of episodes over the kernel `advance`, with the records of its options."""

    @kernel
    def loop(state, action, params, options, episodes, length):
        impacts, cycles = 0, 0
        first = state.copy()
        for key in range(episodes):
            state[0] = first[0]
            state[0].key = key
            for _ in range(length):
                advance(state[0], action, params, *options)
                state[0].steps += 1
                cycles += 1
                if state[0].lost or state[0].fault:
                    break
            impacts += state[0].impacts
        return impacts, cycles

    return loop


def work_of(name: str, changes: Mapping[str, Any], action: tuple[float, ...], kernel_: Any = advance) -> Work:
    """The work of a scene, with the shipped kernel or, of one without the absent options, another."""
    scene = resolve(task_of(TASK), changes)
    params, options = scene.records()
    if kernel_ is not advance:
        options = tuple(option for option in options if option is not None)
    loop, act = loop_of(kernel_), np.array(action)
    state = np.zeros(1, dtype_of(State))

    def run(episodes: int) -> tuple[int, int]:
        state[:] = np.zeros(1, state.dtype)
        state["z"] = HEIGHT
        return loop(state, act, params, options, episodes, EPISODE)

    return Work(name, run, state)


def absent_of(changes: Mapping[str, Any]) -> list[str]:
    """The options that a scene lacks."""
    options = resolve(task_of(TASK), changes).options
    return [name for name, option in options.items() if option is None]


def _timed(work: Work) -> tuple[float, int, int]:
    begin = time.process_time()
    impacts, cycles = work.run(work.episodes)
    return time.process_time() - begin, impacts, cycles


def costs(works: list[Work], basis: list[Work], repeats: int, seconds: float, progress: bool) -> list[Cost]:
    """Time all `works` in turn, `repeats` times; `basis[k]` is the one that work k is compared with.

    Raises:
        ValueError: repeats below 1.
    """
    if repeats < 1:
        raise ValueError(f"repeats = {repeats}; give at least 1")
    for work in tqdm(works, desc="compiling", leave=False, disable=None if progress else True):
        work.run(1)
        while (spent := _timed(work)[0]) < 0.1 * seconds:
            work.episodes *= 2
        work.episodes = max(1, round(work.episodes * seconds / spent))
    for work, other in zip(works, basis, strict=True):
        if work.name == other.name:  # the same work by another kernel: as many episodes
            work.episodes = other.episodes
    times: list[list[float]] = [[] for _ in works]
    impacts, cycles = [0] * len(works), [0] * len(works)
    for repeat in tqdm(range(repeats), desc="repeats", leave=False, disable=None if progress else True):
        # to and fro, so that a drift of the machine's speed does not favour one
        for k in range(len(works)) if repeat % 2 == 0 else reversed(range(len(works))):
            spent, impacts[k], cycles[k] = _timed(works[k])
            times[k].append(1e9 * spent / impacts[k])
    found = []
    for k, (work, other) in enumerate(zip(works, basis, strict=True)):
        j = next(i for i, w in enumerate(works) if w is other)
        ratio = None if j == k else Spread.of([a / b for a, b in zip(times[k], times[j], strict=True)])
        found.append(Cost(work.name, Spread.of(times[k]), impacts[k] / cycles[k], ratio))
    return found


def scene_costs(repeats: int = 7, seconds: float = 0.2, progress: bool = False) -> list[Cost]:
    """Every scene of `SCENES`."""
    works = [work_of(name, *scene) for name, scene in SCENES.items()]
    return costs(works, works, repeats, seconds, progress)


def option_costs(repeats: int = 7, seconds: float = 0.2, progress: bool = False) -> list[Cost]:
    """The plain scene, and each option added to it; the ratio is to the plain scene."""
    works = [work_of("none", *BASIS), *(work_of(name, *scene) for name, scene in PRICED.items())]
    return costs(works, [works[0]] * len(works), repeats, seconds, progress)


def pruning_costs(repeats: int = 7, seconds: float = 0.2, progress: bool = False) -> list[Cost]:
    """The shipped kernel in scenes without options, its ratio to a kernel that never had them.

    Raises:
        ArithmeticError: the two kernels differ in a byte.
    """
    found = []
    with ExitStack() as stack:
        for name in PRUNED:
            changes, action = SCENES[name]
            module = stack.enter_context(stripped(("ball_on_bar", "advance"), absent_of(changes)))
            bare = work_of(name, changes, action, module.advance)
            shipped = work_of(name, changes, action)
            done = bare.run(2), shipped.run(2)
            if done[0] != done[1] or bare.state.tobytes() != shipped.state.tobytes():
                raise ArithmeticError(f"{name}: the stripped kernel gives another result")
            found += costs([bare, shipped], [bare, bare], repeats, seconds, progress)[1:]
    return found
