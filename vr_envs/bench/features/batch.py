"""Rows of a scene that go through the same few control intervals again and again: what a step costs."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np

from vr_envs.bench.features.instructions import Instructions, instructions
from vr_envs.envs.task import Task
from vr_envs.envs.world import NO_LIMIT, World

STEPS = 8  # control intervals that are timed
AGES = 96  # control intervals since the start, at most: the rows are at different places of their episodes

CALM = 0.3  # largest action of an aircraft or a ride: nothing leaves its envelope in AGES + STEPS intervals
SINK = (0.4, 0.0, 0.5, 0.0, 0.0, 0.0)  # peak accelerations 4 m/s^2, 50 rad/s^2; tilt phase +pi/2: Bell's sink


class Batch:
    """`rows` records of a scene; a call moves them all by `STEPS` control intervals from where they began."""

    def __init__(self, task: Task, scene: Any, rows: int, steps: int = STEPS, ages: int = AGES) -> None:
        """Compile or load the kernels, and spread the rows over the first `ages` intervals of their episodes."""
        self.world = world = World(task, scene, rows)
        self.live, width = np.ones(rows, np.bool_), world.widths[1]
        draws = np.random.default_rng(0).uniform(-CALM, CALM, (steps, rows, width))
        self.actions = np.broadcast_to(SINK, draws.shape).copy() if task.name == "ball_on_bar" else draws
        obs = np.empty((rows, world.widths[0]), np.float32)
        world.reset(np.arange(rows), np.arange(rows, dtype=np.uint64), obs)
        age = np.arange(rows) * ages // max(1, rows)
        self.ended = np.zeros(rows, np.bool_)
        for step in range(ages):
            self.ended |= world.step(self.actions[step % steps], age > step, NO_LIMIT)[2]
        self.begin = world.states.copy()

    @property
    def steps(self) -> int:
        """Steps of one row in a call."""
        return len(self.world.states) * len(self.actions)

    def __call__(self) -> None:
        """Begin again, and move."""
        self.world.states[:] = self.begin
        for actions in self.actions:
            self.world.step(actions, self.live, NO_LIMIT)

    def impacts(self) -> float | None:
        """Impacts per step; None for a system without impacts."""
        if "impacts" not in (self.begin.dtype.names or ()):
            return None
        self()
        return float((self.world.states["impacts"] - self.begin["impacts"]).sum()) / self.steps

    def outcome(self) -> tuple[bytes, ...]:
        """All that a call leaves and returns last, as bytes."""
        self.world.states[:] = self.begin
        returned = [self.world.step(actions, self.live, NO_LIMIT) for actions in self.actions]
        return self.world.states.tobytes(), *(array.tobytes() for arrays in returned for array in arrays)

    def instructions(self) -> Instructions:
        """Of the compiled loop over the rows."""
        rows, called = self.world.rows, []

        def step(*arguments: Any) -> Any:
            called.append(tuple(numba.typeof(argument) for argument in arguments))
            return rows.step(*arguments)

        self.world.rows = rows._replace(step=step)
        self.world.step(self.actions[0], self.live, NO_LIMIT)
        self.world.rows = rows
        return instructions(rows.step, called[0])
