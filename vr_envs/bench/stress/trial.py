"""A trial: what is tried, how often, and what happened, case by case; the seed of a case is all it takes to repeat it.

A trial is a number of cases, numbered from 0, and a case follows from its number alone. So a failure is a number and a
reason, and a trial may be run in parts.
"""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from tqdm import tqdm

from vr_envs.models.jit import kernel

PER_DECADE = 50  # bins of the times per step, 5 % wide
FASTEST = 1e-8  # s, where the bins begin
BINS = 10 * PER_DECADE  # up to 100 s

CASE = np.dtype(
    [
        ("count", "i8"), ("code", "i8"), ("at", "i8"), ("worst", "f8"), ("timed", "i8"), ("slowest", "f8"),
        ("told", "i8"), ("judged", "i8"), ("met", "i8"),
    ],
    align=True,
)  # fmt: skip
"""What a compiled loop writes of one case: how many were tried, 0 or the number of a failure, when it happened, the
worst figure, how many steps were timed and the slowest of them (s), how often the model said that it could not go on,
how many of those tried were judged in full, and how often what the trial is after was met."""

_AGAIN = 3  # of the slowest cases are run again
_RUNS = 3  # times each
_TRACED = 1 << 20  # steps of such a case
UNTRACED = np.zeros(0)
_CHUNK = 0.4  # s, between two steps of the progress


@kernel
def note_time(case, times, trace, nanoseconds):
    """Count a step that took so long; its number in the trace is lowered to that."""
    seconds = 1e-9 * nanoseconds
    if case.timed < trace.shape[0]:
        trace[case.timed] = min(trace[case.timed], seconds)
    case.timed += 1
    case.slowest = max(case.slowest, seconds)
    times[min(times.shape[0] - 1, int(math.log10(max(seconds, FASTEST) / FASTEST) * PER_DECADE))] += 1


@dataclasses.dataclass(frozen=True)
class Failure:
    """One case that went wrong."""

    seed: int
    reason: str


@dataclasses.dataclass
class Outcome:
    """What happened in some cases of a trial; `times` counts the steps by their duration, in bins."""

    count: int = 0
    failures: list[Failure] = dataclasses.field(default_factory=list)
    worst: float = 0.0
    worst_seed: int = -1
    slowest: list[tuple[float, int]] = dataclasses.field(default_factory=list)
    times: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros(BINS, np.int64))
    told: int = 0
    judged: int = 0
    met: int = 0

    def add(self, other: Outcome) -> None:
        """Take in what happened in other cases."""
        self.count += other.count
        self.failures += other.failures
        if other.worst > self.worst or (self.worst_seed < 0 and other.worst_seed >= 0):
            self.worst, self.worst_seed = other.worst, other.worst_seed
        self.slowest = sorted([*self.slowest, *other.slowest], reverse=True)[:_AGAIN]
        self.times += other.times
        self.told += other.told
        self.judged += other.judged
        self.met += other.met

    def take(self, seed: int, case: np.void, reasons: Sequence[str]) -> None:
        """Take in the record `CASE` of one case; `reasons` are the failures from code 1 on."""
        found = [] if case["code"] == 0 else [Failure(seed, f"{reasons[case['code'] - 1]}, at step {case['at']}")]
        slowest = [(float(case["slowest"]), seed)] if case["slowest"] > 0.0 else []
        count, told, judged, met = (int(case[name]) for name in ("count", "told", "judged", "met"))
        self.add(Outcome(count, found, float(case["worst"]), seed, slowest, told=told, judged=judged, met=met))


@dataclasses.dataclass(frozen=True)
class Trial:
    """What is tried.

    `run(first, number, trace)` runs the cases `first` to `first + number - 1`. Of each timed step the time is written
    to `trace` (s) if it is less than what stands there, as far as the array goes.
    `unit` says what is counted, and `figure` of what the worst is told; `told` what the model says where it cannot go
    on, which is no failure; `met` what of the judged is counted, to see that the trial meets what it is after. They are
    empty where there is no such thing.
    """

    name: str
    system: str
    tried: str
    unit: str
    figure: str
    cases: int
    run: Callable[[int, int, np.ndarray], Outcome]
    told: str = ""
    met: str = ""


def log_uniform(draw: np.random.Generator, low: float, high: float) -> float:
    """A number between two positive ones, each factor as likely as another."""
    return float(np.exp(draw.uniform(np.log(low), np.log(high))))


def share_below(times: np.ndarray, share: float) -> float:
    """Duration (s) below which the given share of the steps is, to the width of a bin; 0 without any step."""
    total = int(times.sum())
    if total == 0:
        return 0.0
    k = int(np.searchsorted(np.cumsum(times), share * total))
    return FASTEST * 10.0 ** ((min(k, BINS - 1) + 0.5) / PER_DECADE)


def slowest_step(trial: Trial, outcome: Outcome) -> tuple[float, int]:
    """The slowest step (s) of the slowest cases, run several times, and its case: of each step the least time counts.

    What else the machine did meanwhile, which is in the time of one run, is hardly in all of them.
    """
    found = []
    for _, seed in outcome.slowest:
        trace = np.full(_TRACED, np.inf)
        for _ in range(_RUNS):
            trial.run(seed, 1, trace)
        found.append((float(trace[np.isfinite(trace)].max()), seed))
    return max(found, default=(0.0, -1))


def run_cases(trial: Trial, first: int, number: int) -> Outcome:
    """Run some cases; of a case that raises, the error is a failure like others."""
    try:
        return trial.run(first, number, UNTRACED)
    except Exception as error:  # whatever it is, the table is to tell it with its seed
        if number == 1:
            return Outcome(failures=[Failure(first, f"{type(error).__name__}: {error}")])
    outcome, half = run_cases(trial, first, number // 2), number // 2
    outcome.add(run_cases(trial, first + half, number - half))
    return outcome


def attempt(trial: Trial, first: int, cases: int, progress: bool = False) -> tuple[Outcome, float]:
    """Run a trial's cases from number `first` on, after a case that compiles; returns also its CPU seconds."""
    run_cases(trial, first, 1)
    outcome, done, chunk, begun = Outcome(), 0, 1, time.process_time()
    with tqdm(total=cases, desc=trial.name, unit="case", leave=False, disable=None if progress else True) as bar:
        while done < cases:
            chunk = min(chunk, cases - done)
            begin = time.perf_counter()
            outcome.add(run_cases(trial, first + done, chunk))
            done += chunk
            bar.update(chunk)
            chunk = max(1, round(chunk * min(4.0, _CHUNK / max(time.perf_counter() - begin, 1e-6))))
    return outcome, time.process_time() - begun


def named(trials: Mapping[str, Trial], name: str) -> Trial:
    """The trial of that name.

    Raises:
        ValueError: there is none; it lists them.
    """
    if name not in trials:
        raise ValueError(f"there is no trial {name!r}; choose one of {', '.join(trials)}")
    return trials[name]
