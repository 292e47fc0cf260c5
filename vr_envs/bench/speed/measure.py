"""Steps per second of every form of an environment, side by side, and what was aimed at beside what was found.

The clock is the CPU time of this process, all threads, so that other processes on the machine do not count; only
several threads are timed by the wall clock, which they are to beat. All forms of a case with the same number of rows
are timed in turn within each repeat, after equally many steps: what a step costs depends on how an episode has gone on.
"""

from __future__ import annotations

import dataclasses
import importlib.util
import os
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

from tqdm import tqdm

from vr_envs.bench.speed.ahead import compile_ahead
from vr_envs.bench.speed.arrays.namespace import NUMPY, jax_arrays
from vr_envs.bench.speed.contestants import CARTPOLE, Case, cartpole, impacts_of, native, on_arrays, scalar, sync
from vr_envs.bench.timing import Spread, per_call
from vr_envs.envs.registry import limit_of

NATIVE, SCALAR, SYNC, JAX = "native batch", "scalar", "SyncVectorEnv", "JAX"
FAMILIES = (NATIVE, NUMPY.name, JAX, SYNC, SCALAR)
SYNC_ROWS = 64  # a loop over environments: with more rows it is as fast per step
THREADS_FROM = 1024  # rows: less is too little work to share
JAX_LEFT_OUT = "With --quick JAX is not measured: it compiles anew for every number of rows."
JAX_MISSING = "JAX was not measured: it needs `pip install '.[jax]'` in a clone of the project."
SETTLED = 24  # steps of every form before the clock starts: a ball's cost has then grown fivefold, and grows no more


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
    """All that was timed, `repeats` times for about `seconds`; `impacts`: per step, by case, of those that have any."""

    speeds: list[Speed]
    shared: list[Shared]
    impacts: dict[str, float]
    repeats: int
    seconds: float

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
            forms[JAX] = on_arrays(case, rows, jax_arrays())
    return forms


def episode_calls(case: Case, family: str) -> int:
    """Calls from the start of an episode that lasts until it is cut to the next one's: Gymnasium's resets take one."""
    return limit_of(case.env_id) + (family in (NATIVE, SYNC))


def rates(case: Case, rows: int, jax: bool, repeats: int, seconds: float) -> list[Speed]:
    """Of all forms of a case but the scalar one."""
    forms = _forms(case, rows, jax)
    wholes = [episode_calls(case, family) for family in forms]
    times = per_call(list(forms.values()), repeats, seconds, SETTLED, wholes)
    rates = [Spread.of([rows / t for t in spent]) for spent in times]
    return [Speed(case.label, family, rows, rate) for family, rate in zip(forms, rates, strict=True)]


def _singles(cases: Sequence[Case], repeats: int, seconds: float) -> list[Speed]:
    """One environment of each case, and CartPole."""
    works = [cartpole(), *(scalar(case) for case in cases)]
    times = per_call(works, repeats, seconds, SETTLED)
    labels = [CARTPOLE, *(case.label for case in cases)]
    rates = [Spread.of([1.0 / t for t in spent]) for spent in times]
    return [Speed(label, SCALAR, 1, rate) for label, rate in zip(labels, rates, strict=True)]


def _wall(works: Sequence[Callable[[], None]], calls: int, pool: ThreadPoolExecutor) -> float:
    """Seconds by the wall clock until each work, in a thread of its own, has been called so often."""

    def many(work: Callable[[], None]) -> None:
        for _ in range(calls):
            work()

    begin = time.perf_counter()
    list(pool.map(many, works))
    return time.perf_counter() - begin


def in_threads(case: Case, rows: int, threads: int, repeats: int, seconds: float) -> Shared:
    """`rows` in one batch and one thread, and in as many batches as threads, in turn, each for about `seconds`."""
    sizes = [rows // threads + (part < rows % threads) for part in range(threads)]
    alone, parts = [native(case, rows)], [native(case, size) for size in sizes]
    both = (alone, parts)
    times: tuple[list[float], list[float]] = ([], [])
    with ThreadPoolExecutor(threads) as pool:
        began = [_wall(works, SETTLED, pool) for works in both]
        calls = max(1, round(SETTLED * seconds / began[0]))
        for repeat in range(repeats):
            for k in (0, 1) if repeat % 2 == 0 else (1, 0):
                times[k].append(_wall(both[k], calls, pool))
    one, several = (Spread.of([rows * calls / t for t in spent]) for spent in times)
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
    compile_ahead(cases, progress)
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
            speeds += rates(case, count, jax, repeats, seconds)
            bar.update()
        for case in cases:
            if threads > 1 and max(rows) >= THREADS_FROM:
                shared.append(in_threads(case, max(rows), threads, repeats, seconds))
            bar.update()
    return Measured(speeds, shared, impacts, repeats, seconds)
