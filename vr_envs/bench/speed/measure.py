"""Steps per second of every form of an environment, side by side, and what was aimed at beside what was found.

The clock is the CPU time of this process, all threads, so that other processes on the machine do not count; only
several threads are timed by the wall clock, which they are to beat. All forms of a case with the same number of rows
are timed in turn within each repeat.
"""

from __future__ import annotations

import dataclasses
import importlib.util
import os
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

from tqdm import tqdm

from vr_envs.bench.speed.arrays.namespace import NUMPY, jax_arrays
from vr_envs.bench.speed.contestants import CARTPOLE, Case, cartpole, impacts_of, native, on_arrays, scalar, sync
from vr_envs.bench.timing import Spread, per_call

NATIVE, SCALAR, SYNC = "native batch", "scalar", "SyncVectorEnv"
FAMILIES = (NATIVE, NUMPY.name, "JAX", SYNC, SCALAR)
SYNC_ROWS = 64  # a loop over environments: with more rows it is as fast per step
THREADS_FROM = 1024  # rows: less is too little work to share
JAX_LEFT_OUT = "With --quick JAX is not measured: it compiles anew for every number of rows."
JAX_MISSING = "JAX was not measured: it is not installed (`pip install 'vr_envs[jax]'`)."


def has_jax() -> bool:
    """Whether JAX is installed."""
    return importlib.util.find_spec("jax") is not None


@dataclasses.dataclass(frozen=True)
class Speed:
    """Environment steps per CPU second of one form (of `FAMILIES`) of a case, over the repeats."""

    case: str
    family: str
    rows: int
    spread: Spread


@dataclasses.dataclass(frozen=True)
class Shared:
    """Environment steps per second by the wall clock: a native batch in one thread, and in parts in several."""

    case: str
    rows: int
    threads: int
    alone: Spread
    shared: Spread


@dataclasses.dataclass(frozen=True)
class Measured:
    """All that was timed; `impacts`: per step, by case, of those that have any."""

    speeds: list[Speed]
    shared: list[Shared]
    impacts: dict[str, float]

    def of(self, case: str, family: str, rows: int) -> Spread | None:
        """What was found for one form of a case."""
        return next((s.spread for s in self.speeds if (s.case, s.family, s.rows) == (case, family, rows)), None)


def _forms(case: Case, rows: int, jax: bool) -> dict[str, Callable[[], None]]:
    forms = {NATIVE: native(case, rows)}
    if rows <= SYNC_ROWS:
        forms[SYNC] = sync(case, rows)
    if case.opponent is not None:
        forms[NUMPY.name] = on_arrays(case, rows, NUMPY)
        if jax and case.opponent.jax:
            forms["JAX"] = on_arrays(case, rows, jax_arrays())
    return forms


def _rates(label: str, forms: dict[str, Callable[[], None]], rows: int, repeats: int, seconds: float) -> list[Speed]:
    times = per_call(list(forms.values()), repeats, seconds)
    return [Speed(label, name, rows, Spread.of([rows / t for t in spent])) for name, spent in zip(forms, times)]  # noqa: B905


def _singles(cases: Sequence[Case], repeats: int, seconds: float) -> list[Speed]:
    """One environment of each case, and CartPole."""
    works = [cartpole(), *(scalar(case) for case in cases)]
    times = per_call(works, repeats, seconds)
    labels = [CARTPOLE, *(case.label for case in cases)]
    return [Speed(label, SCALAR, 1, Spread.of([1.0 / t for t in spent])) for label, spent in zip(labels, times)]  # noqa: B905


def _wall(works: Sequence[Callable[[], None]], calls: int, pool: ThreadPoolExecutor) -> float:
    """Seconds by the wall clock until each work, in a thread of its own, has been called so often."""

    def many(work: Callable[[], None]) -> None:
        for _ in range(calls):
            work()

    begin = time.perf_counter()
    list(pool.map(many, works))
    return time.perf_counter() - begin


def in_threads(case: Case, rows: int, threads: int, repeats: int, seconds: float) -> Shared:
    """`rows` in one batch and one thread, and in as many batches as threads, each for about `seconds`."""
    alone, parts = [native(case, rows)], [native(case, rows // threads) for _ in range(threads)]
    with ThreadPoolExecutor(threads) as pool:
        for works in (alone, parts):
            _wall(works, 1, pool)  # what is done once is not timed
        calls = max(1, round(10 * seconds / _wall(alone, 10, pool)))
        found = [(_wall(alone, calls, pool), _wall(parts, calls, pool)) for _ in range(repeats)]
    one, several = (Spread.of([rows * calls / t for t in spent]) for spent in zip(*found))  # noqa: B905
    return Shared(case.label, rows, threads, one, several)


def measure(
    cases: Sequence[Case], rows: Sequence[int], repeats: int, seconds: float, jax: bool = True, progress: bool = False
) -> Measured:
    """Time all forms of the cases at every number of rows, each `repeats` times for about `seconds`.

    `jax`: JAX too, which must be installed.

    Raises:
        ValueError: rows or repeats below 1.
    """
    if repeats < 1 or min(rows) < 1:
        raise ValueError(f"rows = {list(rows)}, repeats = {repeats}; give at least 1")
    threads = min(4, os.cpu_count() or 1)
    pairs = [(case, count) for case in cases for count in rows]
    with tqdm(total=len(pairs) + 2 * len(cases), disable=None if progress else True, unit="run", desc="speed") as bar:
        impacts, shared = {}, []
        for case in cases:
            if (found := impacts_of(case)) is not None:
                impacts[case.label] = found
            bar.update()
        speeds = _singles(cases, repeats, seconds)
        for case, count in pairs:
            speeds += _rates(case.label, _forms(case, count, jax), count, repeats, seconds)
            bar.update()
        for case in cases:
            if threads > 1 and max(rows) >= THREADS_FROM:
                shared.append(in_threads(case, max(rows), threads, repeats, seconds))
            bar.update()
    return Measured(speeds, shared, impacts)
