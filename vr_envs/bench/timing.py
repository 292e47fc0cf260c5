"""CPU time of a piece of work: this process' own seconds, so that other processes on the machine do not count."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

WARM_UP = 4  # calls, of which the second half is timed
_LEAST = 1e-6  # s: no call is shorter; a clock that ticks seldom may say so


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
    return _many(work, 1)


def calls_for(work: Callable[[], object], seconds: float, warm_up: int = WARM_UP, whole: int = 1) -> int:
    """How many calls take about `seconds` of CPU time, at least one, by the later half of `warm_up` calls, two or more.

    A multiple of `whole`, where so many take no longer than twice `seconds`.
    """
    timed = warm_up // 2
    _many(work, warm_up - timed)
    calls = seconds / max(_many(work, timed) / timed, _LEAST)
    whole = whole if 2.0 * calls >= whole else 1
    return whole * max(1, round(calls / whole))


def _many(work: Callable[[], object], calls: int) -> float:
    begin = time.process_time()
    for _ in range(calls):
        work()
    return time.process_time() - begin


def per_call(
    works: Sequence[Callable[[], object]],
    repeats: int,
    seconds: float,
    warm_up: int = WARM_UP,
    wholes: Sequence[int] | None = None,
) -> list[list[float]]:
    """CPU seconds per call of each work, one number per repeat; all works in turn within a repeat.

    To and fro, so that a drift of the machine's speed favours none, and a ratio compares times taken side by side.

    Args:
        works: what is called.
        repeats: timings of each.
        seconds: about how long each timing lasts.
        warm_up: calls of each work before the clock starts, at least two: what is done once is not timed, and works
            that become slower as they go on have come equally far.
        wholes: of each work, calls that belong together, such as an episode; see `calls_for`.

    Raises:
        ValueError: repeats below 1.
    """
    if repeats < 1:
        raise ValueError(f"repeats = {repeats}; give at least 1")
    together = wholes or [1] * len(works)
    calls = [calls_for(work, seconds, warm_up, whole) for work, whole in zip(works, together, strict=True)]
    times: list[list[float]] = [[] for _ in works]
    for repeat in range(repeats):
        order = range(len(works))
        for k in order if repeat % 2 == 0 else reversed(order):
            times[k].append(_many(works[k], calls[k]) / calls[k])
    return times
