"""A compiled walk of one environment through the loop over rows that every environment steps, with checks in between.

After each step and each reset: no number of the state, the observation or the reward is infinite or undefined, the
observation is in its space, the reward in [0, 1], no fault is reported; after a step also what the system's own check
says. Now and then an action is not a number, which has to be refused and to change nothing. An episode that ends is
followed by another.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from vr_envs.bench.stress.clock import thread_time
from vr_envs.bench.stress.trial import CASE, Outcome, note_time
from vr_envs.envs.rows import row_records, rows_of
from vr_envs.envs.task import Task
from vr_envs.envs.world import World
from vr_envs.models.jit import kernel
from vr_envs.models.noise import uniform

ZERO, UNIFORM, CORNERS, HELD, BEYOND = range(5)
"""Kinds of actions: none; drawn for every step; from {-1, 1}; for every 20 steps; from +-1e300, which are clipped."""
_SPOILT = 16  # one of so many checked steps is first tried with an action that is not a number
_DRAWS = 1 << 42  # counters of the actions, apart from those of the episodes

REASONS = (
    "a number of the state is not finite",
    "a number of the observation is not finite or out of its space",
    "a reward is not in [0, 1]",
    "the model gave up (fault)",
    "an action that is not a number was taken",
)
_STATE, _OBSERVATION, _REWARD, _FAULT, _TAKEN = range(1, len(REASONS) + 1)
OWN = len(REASONS) + 1  # the number of the first failure of a system's own check


class Settings(NamedTuple):
    """How an environment is walked; `facts` is what the system's own check needs to know of the scene."""

    key: int
    steps: int
    actions: int  # one of the kinds above
    every: int  # the system's own check is made after one step in so many
    facts: tuple[float, ...]


@kernel
def _act(action, settings, step):
    for j in range(action.shape[0]):
        draw = _DRAWS + action.shape[0] * (step // 20 if settings.actions == HELD else step) + j
        if settings.actions != ZERO:
            action[j] = 2.0 * uniform(settings.key, draw) - 1.0
        if settings.actions == CORNERS:
            action[j] = math.copysign(1.0, action[j])
        if settings.actions == BEYOND:
            action[j] *= 1e300


@kernel
def _infinite(bits, floats):
    """Whether a number among the words of a record is infinite or undefined; `floats` are the numbers' places."""
    exponent = np.uint64(0x7FF0000000000000)
    for j in floats:  # noqa: SIM110 (a kernel)
        if bits[j] & exponent == exponent:
            return True
    return False


@kernel
def _fails(bits, floats, fault, obs, low, high, reward):
    for j in range(obs.shape[0]):
        if not low[j] <= obs[j] <= high[j]:
            return _OBSERVATION
    if not 0.0 <= reward <= 1.0:
        return _REWARD
    if _infinite(bits, floats):
        return _STATE
    if fault >= 0 and bits[fault] != 0:
        return _FAULT
    return 0


@cache
def _walker(step_rows: Any, reset_rows: Any, prepare: Any, check: Any) -> Any:
    """The compiled walk of a task's loops over rows, with a system's own `prepare` and `check`."""

    @kernel
    def walk(  # type: ignore[no-untyped-def]
        case, times, trace, states, before, bits, bits_before, floats, fault, acts, obs, seen, low, high, ends, params,
        options, settings, scratch,
    ):  # fmt: skip
        live, rewards, terminated, truncated, zeroth, keys = ends
        keys[0] = settings.key << 20
        reset_rows(states, zeroth, keys, obs, params, options)
        case.code = _fails(bits[0], floats, fault, obs[0], low, high, 0.0)
        for step in range(settings.steps):
            if case.code != 0:
                return
            action = acts[0].row
            prepare(states[0], settings, step)
            checked = step % settings.every == 0
            if checked:
                before[0] = states[0]
            if checked and step % _SPOILT == 0:
                for j in range(action.shape[0]):
                    action[j] = math.nan
                code = step_rows(states, acts, live, 1 << 62, seen, rewards, terminated, truncated, params, options)
                if code != -1 or not (bits[0] == bits_before[0]).all():
                    case.code = _TAKEN
                for j in range(action.shape[0]):
                    action[j] = 0.0
            _act(action, settings, step)
            begin = thread_time(scratch)
            step_rows(states, acts, live, 1 << 62, seen, rewards, terminated, truncated, params, options)
            note_time(case, times, trace, thread_time(scratch) - begin)
            case.at = step
            case.count += 1
            if case.code == 0:
                case.code = _fails(bits[0], floats, fault, obs[0], low, high, rewards[0])
            if checked and case.code == 0:
                code, figure, met = check(before[0], states[0], action, params, settings.facts)
                case.judged += 1
                case.met += met
                case.worst = max(case.worst, figure)
                case.code = OWN - 1 + code if code > 0 else 0
            if terminated[0] and case.code == 0:
                keys[0] += np.uint64(1)
                states[0] = before[1]
                reset_rows(states, zeroth, keys, obs, params, options)
                case.code = _fails(bits[0], floats, fault, obs[0], low, high, 0.0)

    return walk


@kernel
def nothing(state, settings, step):
    """In place of `prepare` where nothing is done to the state before a step."""


@kernel
def no_check(before, state, action, params, facts):
    """In place of `check` where a system has none of its own."""
    return 0, 0.0, False


def judge(
    task: Task,
    scene: Mapping[str, Any],
    settings: Settings,
    outcome: Outcome,
    trace: np.ndarray,
    prepare: Any,
    check: Any,
    reasons: tuple[str, ...],
) -> None:
    """Walk one case, whose seed is the key of the settings; `check` returns (0 or a number of `reasons`,
    figure, whether what the trial is after was met).
    """
    world = World(task, scene, 1)
    dtype: Any = world.states.dtype
    words = [k for name in dtype.names if dtype[name].base.kind == "f" for k in _words(dtype, name)]
    fault = dtype.fields["fault"][1] // 8 if "fault" in dtype.names else -1
    box = world.observation_space
    case, before = np.zeros(1, CASE), np.zeros(2, dtype)
    acts, obs = np.zeros((1, world.widths[1])), np.zeros((1, world.widths[0]), np.float32)
    ends = (
        np.ones(1, np.bool_), np.zeros(1), np.zeros(1, np.bool_), np.zeros(1, np.bool_), np.zeros(1, np.intp),
        np.zeros(1, np.uint64),
    )  # fmt: skip
    rows = rows_of(task)
    _walker(rows.step, rows.reset, prepare, check)(
        case[0], outcome.times, trace, world.states, before, world.states.view(np.uint64).reshape(1, -1),
        before[:1].view(np.uint64).reshape(1, -1),
        np.array(words, np.int64), fault, row_records(acts), obs, row_records(obs), box.low, box.high, ends,
        world.params, world.options, settings, _SCRATCH,
    )  # fmt: skip
    outcome.take(settings.key, case[0], REASONS + reasons)


def _words(dtype: Any, name: str) -> range:
    """Which 64-bit words of a record hold a field."""
    first = dtype.fields[name][1] // 8
    return range(first, first + dtype.fields[name][0].itemsize // 8)


_SCRATCH = np.zeros(2, np.int64)
