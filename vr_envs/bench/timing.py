"""CPU time of a piece of work: this process' own seconds, so that other processes on the machine do not count."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple


class Spread(NamedTuple):
    """Smallest, median and largest of the repeats."""

    minimum: float
    median: float
    maximum: float

    @classmethod
    def of(cls, values: Sequence[float]) -> Spread:
        """Of at least one number."""
        return cls(min(values), statistics.median(values), max(values))

    def scaled(self, factor: float) -> Spread:
        """In another unit; `factor` > 0."""
        return Spread(*(factor * value for value in self))

    def text(self, digits: int = 3) -> str:
        """Median (minimum to maximum), to so many significant digits."""
        low, middle, high = (f"{value:.{digits}g}" for value in self)
        return f"{middle} ({low} to {high})"


def cpu_seconds(work: Callable[[], object]) -> float:
    """CPU seconds of this process, all threads, that one call takes."""
    begin = time.process_time()
    work()
    return time.process_time() - begin


def calls_for(work: Callable[[], object], seconds: float, most: int = 1 << 30) -> int:
    """How many calls take about `seconds` of CPU time, at least one; the first, which may compile, is not timed."""
    work()
    calls = 1
    while (spent := _many(work, calls)) < 0.1 * seconds and calls < most:
        calls *= 2
    return max(1, min(most, round(calls * seconds / max(spent, 1e-9))))


def _many(work: Callable[[], object], calls: int) -> float:
    begin = time.process_time()
    for _ in range(calls):
        work()
    return time.process_time() - begin


def per_call(works: Sequence[Callable[[], object]], repeats: int, seconds: float) -> list[list[float]]:
    """CPU seconds per call of each work, one number per repeat; all works in turn within a repeat.

    To and fro, so that a drift of the machine's speed favours none, and a ratio compares times taken side by side.

    Raises:
        ValueError: repeats below 1.
    """
    if repeats < 1:
        raise ValueError(f"repeats = {repeats}; give at least 1")
    calls = [calls_for(work, seconds) for work in works]
    times: list[list[float]] = [[] for _ in works]
    for repeat in range(repeats):
        order = range(len(works))
        for k in order if repeat % 2 == 0 else reversed(order):
            times[k].append(_many(works[k], calls[k]) / calls[k])
    return times
