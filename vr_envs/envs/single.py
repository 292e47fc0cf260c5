"""A world of one record, with the arrays that its kernels read and write: a step costs little more than the kernel."""

from __future__ import annotations

from typing import Any

import numpy as np

from vr_envs.envs.rows import row_records
from vr_envs.envs.world import NO_LIMIT, World, refused
from vr_envs.models.jit import bound


class Single:
    """Steps and resets the one record of `world`; `limit` is the number of control intervals of an episode.

    After `step`: `reward`, `terminated` and `truncated`, arrays of one number.
    """

    def __init__(self, world: World) -> None:
        """For a world of one record."""
        self.world = world
        self.limit = NO_LIMIT
        self._allot()

    def __getstate__(self) -> dict[str, Any]:
        """What a copy is made from: what is bound cannot be copied."""
        return {"world": self.world, "limit": self.limit}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Bind anew."""
        self.__dict__.update(state)
        self._allot()

    def _allot(self) -> None:
        world, self._bound_limit = self.world, self.limit
        self.action = np.zeros((1, world.widths[1]))
        self.reward, self.terminated, self.truncated = np.zeros(1), np.zeros(1, np.bool_), np.zeros(1, np.bool_)
        self._key, self._row, self._live = np.zeros(1, np.uint64), np.zeros(1, np.intp), np.ones(1, np.bool_)
        self._obs = np.zeros((1, world.widths[0]), np.float32)
        self._seen, self._acts = self._obs[0], row_records(self.action)
        self._record = world.storage.array.view(np.uint8)
        self._step: Any = None
        self._reset: Any = None

    def reset(self, key: np.uint64) -> np.ndarray:
        """Start afresh from an episode key; returns the fresh observation."""
        if self._reset is None:
            world = self.world
            world.compile()
            self._reset = bound(
                world.rows.reset, world.storage.array, self._row, self._key, self._obs, world.params, world.options
            )
        self._record.fill(0)
        self._key[0] = key
        self._reset()
        return self._seen.copy()

    def step(self) -> np.ndarray:
        """Move by one control interval under `action`, which is clipped in place; returns the fresh observation.

        Raises:
            ValueError: the action is not finite; the record is unchanged.
        """
        world = self.world
        if self._step is None or self._bound_limit != self.limit:
            self._bound_limit = self.limit
            self._step = bound(
                world.rows.step, world.storage.array, self._acts, self._live, self.limit, row_records(self._obs),
                self.reward, self.terminated, self.truncated, world.params, world.options,
            )  # fmt: skip
        if world.simulator is not None:
            world.simulate(self._acts, self._live)
        if self._step() >= 0:
            raise refused(0, self.action)
        return self._seen.copy()
