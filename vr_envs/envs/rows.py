"""The loops over rows, written once for every task: a plain serial loop over the functions for one record."""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from vr_envs.envs.scene import Scene
from vr_envs.envs.task import Task
from vr_envs.models.jit import kernel
from vr_envs.models.lane_records import block_at, lane, record_at
from vr_envs.models.lane_rows import blank_rows, gathered, load_lanes, scatter, store_lanes
from vr_envs.models.lanes import WIDTH, all_lanes, any_lane, where

LOCKSTEP_FROM = 4 * WIDTH
STAYS, RUNS, BEGINS = range(3)
"""What a row does in a step: its record stays as it is; it moves; it is to be started afresh, whatever becomes of it.

False and True, as they are numbers, are the first two.
"""


class Rows(NamedTuple):
    """Compiled row loops of a task.

    `states` are records one after another, or blocks of them (`vr_envs.models.lane_records`).
    `reset(states, rows, keys, obs, params, options)`: start afresh the given rows from the given keys.
    `step(states, actions, live, limit, obs, rewards, terminated, truncated, params, options) -> int`: move the rows
    whose entry in `live` is `RUNS` by one control interval; 1 if an episode has ended, else 0. What is written to `obs`
    of the others is arbitrary. With a non-finite action, -1 - i if row i is the first running one that has one, and
    then no record has changed. Actions are clipped to [-1, 1] in place; `actions` and `obs` are given as
    `row_records`.
    `observe(states, obs, params, options)`: observations of all rows.
    """

    reset: Any
    step: Any
    observe: Any


@cache
def _row_dtype(dtype: np.dtype[Any], width: int) -> np.dtype[Any]:
    return np.dtype([("row", dtype, (width,))])


def row_records(array: np.ndarray) -> np.ndarray:
    """The rows of a C-contiguous (n, width) array as n records with the one field `row`; shares its memory.

    A kernel takes row i of a plain array as a new array whose owner is reference-counted, by atomic operations
    that cost more than a short step; the field of a record is not counted.
    """
    return array.view(_row_dtype(array.dtype, array.shape[1]))[:, 0]


@kernel
def admit(actions: np.ndarray, live: np.ndarray) -> int:
    """Clip the actions of rows that run to [-1, 1] in place; return the first with a non-finite entry, or -1.

    The other rows' actions, whatever they are, become 0: they may be calculated with, in a block.
    """
    for i in range(actions.shape[0]):
        row = actions[i].row
        for j in range(row.shape[0]):
            if live[i] != RUNS:
                row[j] = 0.0
            elif not np.isfinite(row[j]):
                return i
        for j in range(row.shape[0]):
            row[j] = min(1.0, max(-1.0, row[j]))
    return -1


def _build(start: Any, advance: Any, outcome: Any, observe: Any, ready: Any, advance_block: Any) -> Rows:
    @kernel
    def reset_rows(states, rows, keys, obs, params, options):  # type: ignore[no-untyped-def]
        for k in range(rows.shape[0]):
            i = rows[k]
            state = record_at(states, i)
            state.key = keys[k]
            state.steps = 0
            start(state, params, *options)
            observe(state, obs[i], params, *options)

    @kernel
    def step_row(state, action, row, params, options):  # type: ignore[no-untyped-def]
        advance(state, action, params, *options)
        state.steps += 1
        judged = outcome(state, action, params, *options)
        observe(state, row, params, *options)
        return judged

    @kernel
    def step_rows(states, actions, live, limit, obs, rewards, terminated, truncated, params, options):  # type: ignore[no-untyped-def]
        bad, ended = admit(actions, live), False
        if bad >= 0:
            return -1 - bad
        for i in range(rewards.shape[0]):
            if live[i] == RUNS:
                state = record_at(states, i)
                rewards[i], terminated[i] = step_row(state, actions[i].row, obs[i].row, params, options)
                truncated[i] = state.steps >= limit
                ended = ended or terminated[i] or truncated[i]
        return int(ended)

    @kernel
    def step_blocks(states, actions, live, limit, obs, rewards, terminated, truncated, params, options):  # type: ignore[no-untyped-def]
        bad, ended = admit(actions, live), False
        if bad >= 0:
            return -1 - bad
        n = rewards.shape[0]
        for b in range(states.shape[0]):
            block, first, last = block_at(states, b), b * WIDTH, min(n, (b + 1) * WIDTH)
            together = last - first == WIDTH
            for i in range(first, last):
                together = together and live[i] != STAYS
            if together and all_lanes(ready(block, params, *options)):
                runs = load_lanes(live, first)
                action, row = gathered(actions, first), blank_rows(obs)
                advance_block(block, action, params, *options)
                block.steps += 1
                reward, failed = outcome(block, action, params, *options)
                failed, late = failed & runs, (block.steps >= limit) & runs
                store_lanes(rewards, first, where(runs, reward, 0.0))
                store_lanes(terminated, first, failed)
                store_lanes(truncated, first, late)
                ended = ended or any_lane(failed | late)
                observe(block, row, params, *options)
                scatter(row, obs, first)
            else:
                for i in range(first, last):
                    if live[i] == RUNS:
                        state = lane(block, i - first)
                        rewards[i], terminated[i] = step_row(state, actions[i].row, obs[i].row, params, options)
                        truncated[i] = state.steps >= limit
                        ended = ended or terminated[i] or truncated[i]
        return int(ended)

    @kernel
    def observe_rows(states, obs, params, options):  # type: ignore[no-untyped-def]
        for i in range(obs.shape[0]):
            observe(record_at(states, i), obs[i], params, *options)

    return Rows(reset_rows, step_rows if ready is None else step_blocks, observe_rows)


@cache
def _build_once(start: Any, advance: Any, outcome: Any, observe: Any, ready: Any, advance_block: Any) -> Rows:
    return _build(start, advance, outcome, observe, ready, advance_block)


@kernel
def _stay(state, action, params, *options):
    """In place of `advance` where a simulator has moved the state already."""


def in_lockstep(task: Task, scene: Scene, count: int) -> bool:
    """Whether `count` records of a scene are kept in blocks and moved side by side.

    Below `LOCKSTEP_FROM` the second set of kernels would not be worth its compilation.
    """
    return task.lockstep is not None and count >= LOCKSTEP_FROM and task.lockstep.possible(scene)


def rows_of(task: Task, simulated: bool = False, lockstep: bool = False) -> Rows:
    """The compiled row loops of `task`; with `simulated` their `step` judges states that have been moved already.

    With `lockstep` their `step` takes records in blocks, and moves a block at once where all its records are ready.
    """
    advance = _stay if simulated else task.advance
    ready, advance_block = (task.lockstep.ready, task.lockstep.advance) if lockstep and task.lockstep else (None, None)
    return _build_once(task.start, advance, task.outcome, task.observe, ready, advance_block)
