"""Where the records of a world are kept: one after another, or eight side by side for kernels on lanes."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from vr_envs.models.lane_records import empty_blocks, read_records, write_records


class Storage(Protocol):
    """Records of one dtype. `array` is what kernels take: `vr_envs.models.lane_records.record_at` finds one in it."""

    array: np.ndarray
    dtype: np.dtype[Any]

    def read(self, rows: np.ndarray) -> np.ndarray:
        """A copy of the records of some rows."""
        ...

    def write(self, rows: np.ndarray, records: np.ndarray) -> None:
        """Put one record, or one each, into some rows."""
        ...

    @property
    def records(self) -> np.ndarray:
        """All records; changing them changes the world if `array` holds records, and is refused if it does not."""
        ...


class Plain:
    """Records one after another."""

    def __init__(self, dtype: np.dtype[Any], count: int) -> None:
        """`count` zeroed records."""
        self.dtype = dtype
        self.array = np.zeros(count, dtype)
        # without its fields, one by one of which NumPy would copy a record, fifty times as slowly
        self._opaque = np.dtype((np.void, dtype.itemsize))

    def read(self, rows: np.ndarray) -> np.ndarray:
        """A copy of the records of some rows."""
        return self.array.view(self._opaque)[rows].view(self.dtype)

    def write(self, rows: np.ndarray, records: np.ndarray) -> None:
        """Put one record, or one each, into some rows."""
        self.array.view(self._opaque)[rows] = np.ascontiguousarray(records).view(self._opaque)

    @property
    def records(self) -> np.ndarray:
        """The records themselves."""
        return self.array


class Blocks:
    """Records eight side by side."""

    def __init__(self, dtype: np.dtype[Any], count: int) -> None:
        """`count` zeroed records; what the last block has beyond them is never read."""
        self.dtype, self._count = dtype, count
        self.array = empty_blocks(dtype, count)

    def read(self, rows: np.ndarray) -> np.ndarray:
        """A copy of the records of some rows."""
        return read_records(self.array, rows)

    def write(self, rows: np.ndarray, records: np.ndarray) -> None:
        """Put one record, or one each, into some rows."""
        write_records(self.array, rows, records)

    @property
    def records(self) -> np.ndarray:
        """A copy of the records, not to be written to."""
        copy = self.read(np.arange(self._count))
        copy.flags.writeable = False
        return copy
