"""Rows of a scene that go through the same control intervals again and again: what a step costs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numba
import numpy as np

from vr_envs.bench.features.instructions import Instructions, instructions
from vr_envs.envs.rows import in_lockstep, row_records
from vr_envs.envs.task import Task
from vr_envs.envs.world import NO_LIMIT, World

STEPS = 32  # control intervals that are timed
AGES = 96  # control intervals since the start, at most: the rows are at different places of their episodes

CALM = 0.3  # largest action of an aircraft or a ride: nothing leaves its envelope in AGES + STEPS intervals
SINK = (0.4, 0.0, 0.5, 0.0, 0.0, 0.0)  # peak accelerations 4 m/s^2, 50 rad/s^2; tilt phase +pi/2: Bell's sink


class Batch:
    """`rows` records of a scene; a call moves them all by `steps` control intervals from where they began."""

    def __init__(
        self,
        task: Task,
        scene: Any,
        rows: int,
        steps: int = STEPS,
        ages: int = AGES,
        action: Sequence[float] | None = None,
        fields: Mapping[str, Any] | None = None,
    ) -> None:
        """Compile or load the kernels, and spread the rows over the first `ages` intervals of their episodes.

        Args:
            task, scene: of the rows.
            rows, steps, ages: numbers of them; with `ages` = 0 all rows are at their start.
            action: of every row in every interval; by default Bell's sink, or calm random ones.
            fields: values of the records' fields at the start, in place of those that a reset draws.
        """
        self.world = world = World(task, scene, rows)
        self.lockstep = in_lockstep(task, world.scene, rows)
        self.live = np.ones(rows, np.bool_)
        action = SINK if action is None and task.name == "ball_on_bar" else action
        draws = np.random.default_rng(0).uniform(-CALM, CALM, (steps, rows, world.widths[1]))
        self.actions = draws if action is None else np.broadcast_to(action, draws.shape).copy()
        keys = np.arange(rows, dtype=np.uint64)
        world.reset(np.arange(rows), keys, np.empty((rows, world.widths[0]), np.float32))
        if fields is not None:
            records = world.states.copy()
            for name, values in fields.items():
                records[name] = values
            world.load(records, np.arange(rows))
        age = np.arange(rows) * ages // rows
        for step in range(ages):
            world.step(self.actions[step % steps], age > step, NO_LIMIT)
        self.begin = world.states.copy()
        self._memory = world.storage.array.view(np.uint8)
        self._first = self._memory.copy()

    @property
    def steps(self) -> int:
        """Steps of single rows in a call."""
        return self.live.size * len(self.actions)

    def __call__(self) -> None:
        """Begin again, and move."""
        self._memory[...] = self._first
        for actions in self.actions:
            self.world.step(actions, self.live, NO_LIMIT)

    def impacts(self) -> float | None:
        """Impacts per step; None for a system without impacts."""
        if "impacts" not in (self.begin.dtype.names or ()):
            return None
        self()
        return float((self.world.states["impacts"] - self.begin["impacts"]).sum()) / self.steps

    def results(self) -> list[np.ndarray]:
        """All that the steps of a call return, and the records that they leave."""
        self._memory[...] = self._first
        found = [array for actions in self.actions for array in self.world.step(actions, self.live, NO_LIMIT)]
        return [*found, self.world.states]

    @cached_property
    def instructions(self) -> Instructions:
        """Of the compiled loop over the rows."""
        world, rows = self.world, self.live.size
        results = np.zeros((rows, world.widths[0]), np.float32), np.zeros(rows), ~self.live, ~self.live
        arguments = (
            world.storage.array, row_records(self.actions[0]), self.live, NO_LIMIT, row_records(results[0]),
            *results[1:], world.params, world.options,
        )  # fmt: skip
        return instructions(world.rows.step, tuple(numba.typeof(argument) for argument in arguments))
