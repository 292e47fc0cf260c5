"""The arrays that a world's step reads and writes, and the step with all its arguments converted once.

What is returned is fresh: nothing else refers to it. As an allocator does, this gives out again what nobody holds any
longer; unlike one it knows the compiled call that belongs to it, which to prepare costs more than a short step.
"""

from __future__ import annotations

from sys import getrefcount
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vr_envs.envs.rows import RUNS, row_records
from vr_envs.models.jit import bound

if TYPE_CHECKING:
    from vr_envs.envs.world import World

_MOST = 4  # sets of results kept for another use


class Results(NamedTuple):
    """What a step returns, one row each."""

    obs: np.ndarray
    rewards: np.ndarray
    terminated: np.ndarray
    truncated: np.ndarray


class _Slot:
    """Results and the step that writes them."""

    def __init__(self, results: Results, step: Any) -> None:
        self.results, self.step = results, step
        self._unheld = self._references()

    def _references(self) -> tuple[int, ...]:
        obs, rewards, terminated, truncated = self.results
        return getrefcount(obs), getrefcount(rewards), getrefcount(terminated), getrefcount(truncated)

    def free(self) -> bool:
        """Whether nobody else holds one of the arrays, or a part of one."""
        return self._references() == self._unheld


class Workspace:
    """Steps the rows of `world`, which are truncated after `limit` control intervals.

    Not for two threads at once.
    """

    def __init__(self, world: World, limit: int) -> None:
        """For the records that the world has now."""
        n, width = world.count, world.widths[1]
        self.world = world
        self.limit = limit
        self.actions = np.zeros((n, width))
        self._acts = row_records(self.actions)
        self._live = np.full(n, RUNS, np.uint8)
        self._all_live = True
        self.ended = False  # whether the last step ended an episode
        self._slots: list[_Slot] = []
        self._own: _Slot | None = None

    def take(self, given: Any, shape: tuple[int, ...]) -> None:
        """Copy actions of this shape into `actions`.

        Raises:
            ValueError: not an array of numbers, or of another shape.
        """
        if type(given) is np.ndarray and given.shape == shape and given.dtype.kind == "f":
            self.actions[...] = given
        else:
            self.actions[...] = self.world.actions(given, shape)

    def step(self, live: np.ndarray | None = None) -> Results:
        """Move the rows that are `live`, or all, under `actions`, which are clipped.

        `live` says what each row does, as in `vr_envs.envs.rows`. Rows that do not run have zeros for rewards and ends;
        their observations are arbitrary.

        Raises:
            ValueError: an action is not finite; no record has changed.
        """
        slot = next((slot for slot in self._slots if slot.free()), None)
        if slot is None:
            slot = self._slot()
            self._slots = [*self._slots[1 - _MOST :], slot]
        if live is not None:
            np.copyto(self._live, live)
            self._all_live = False
            for array in slot.results[1:]:
                array.fill(0)
        self._move(slot)
        obs, rewards, terminated, truncated = slot.results
        # views: whoever changes the shape of his array does not change the shape of ours
        return Results(obs.view(), rewards.view(), terminated.view(), truncated.view())

    def move(self) -> Results:
        """As `step`, but the next call overwrites the results: cheaper than a step for one row, to be copied."""
        if self._own is None:
            self._own = self._slot()
        self._move(self._own)
        return self._own.results

    def _move(self, slot: _Slot) -> None:
        try:
            if self.world.simulator is not None:
                self.world.simulate(self._acts, self._live)
            code = slot.step()
        finally:
            if not self._all_live:
                self._live.fill(RUNS)
                self._all_live = True
        if code < 0:
            row = -1 - code
            raise ValueError(
                f"action of env {row} is {self.actions[row]}; every entry must be finite. Nothing was stepped"
            )
        self.ended = code > 0

    def _slot(self) -> _Slot:
        """New arrays for results, and the step that writes them."""
        world, n = self.world, self.world.count
        obs = np.zeros((n, world.widths[0]), np.float32)
        results = Results(obs, np.zeros(n), np.zeros(n, np.bool_), np.zeros(n, np.bool_))
        step = bound(
            world.rows.step, world.storage.array, self._acts, self._live, self.limit, row_records(obs), *results[1:],
            world.params, world.options,
        )  # fmt: skip
        del obs
        return _Slot(results, step)
