"""Run trials and report: what was tried, how often, what happened, the worst, and the seed of every failure."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any, NamedTuple

from vr_envs.bench.ahead import side_by_side
from vr_envs.bench.report import Report, Table
from vr_envs.bench.stress.picture import passages, step_times
from vr_envs.bench.stress.trial import Outcome, Trial, attempt, share_below, slowest_step
from vr_envs.bench.stress.trials import TRIALS

QUICK = 0.1  # part of the cases
SHARES = (0.5, 0.99, 0.9999)
LISTED = 20  # failures of a trial in the report; all are in the JSON
LONG = ("ball-impacts", "ball-motions")  # trials that take longest, and begin first


@dataclasses.dataclass(frozen=True)
class Finding:
    """A trial, what happened, and what it took."""

    name: str
    cases: int
    outcome: Outcome
    again: float  # s, the slowest step of the slowest cases in several runs; 0 without timed steps
    again_seed: int
    seconds: float  # CPU time

    @property
    def trial(self) -> Trial:
        """What was tried."""
        return TRIALS[self.name]

    @property
    def seen(self) -> float:
        """The slowest step (s) of all, in the one run: what else the machine did is in it, so a bound from above."""
        return max((seconds for seconds, _ in self.outcome.slowest), default=0.0)

    @property
    def quantiles(self) -> list[float]:
        """Time per step (s) below which `SHARES` of the steps are."""
        return [share_below(self.outcome.times, share) for share in SHARES]


class Work(NamedTuple):
    """Some cases of a trial, by name."""

    name: str
    first: int
    cases: int


def tried(work: Work, progress: bool = False) -> Finding:
    """Try them."""
    trial = TRIALS[work.name]
    outcome, seconds = attempt(trial, work.first, work.cases, progress)
    slowest, seed = slowest_step(trial, outcome)
    return Finding(work.name, work.cases, outcome, slowest, seed, seconds)


def all_tried(names: Sequence[str], part: float, seed: int | None, progress: bool) -> list[Finding]:
    """Try the trials of these names, or of one the case `seed` alone; `part` is that of the usual number of cases."""
    works = [Work(name, 0, max(1, round(part * TRIALS[name].cases))) for name in names]
    if seed is not None:
        works = [work._replace(first=seed, cases=1) for work in works]
    if len(works) == 1:
        return [tried(works[0], progress)]
    longest_first = sorted(works, key=lambda work: work.name not in LONG)
    found = {f.name: f for f in side_by_side(tried, longest_first, progress, "trials")}
    return [found[name] for name in dict.fromkeys(names)]


def repeat(trial: Trial, seed: int) -> str:
    """The command that repeats one case."""
    return f"vr-envs bench stress --trial {trial.name} --seed {seed}"


def number(value: int) -> str:
    """A number of things: whole, or as a power of ten where it is large."""
    return f"{value}" if value < 100_000 else f"{value:.2e}".replace("e+0", "e").replace("e+", "e")


def counted(value: int, noun: str) -> str:
    """So many things."""
    return f"{number(value)} {noun}{'' if value == 1 else 's'}"


def _time(seconds: float) -> str:
    return f"{1e6 * seconds:.3g}" if seconds > 0.0 else ""


def _happened(finding: Finding) -> str:
    outcome = finding.outcome
    failures = f"**{counted(len(outcome.failures), 'failure')}**" if outcome.failures else "no failure"
    told = f"; {number(outcome.told)} {finding.trial.told}" if outcome.told else ""
    return failures + told


def _often(finding: Finding) -> str:
    outcome, trial = finding.outcome, finding.trial
    parts = [f"{number(outcome.count)} {trial.unit} in {counted(finding.cases, 'case')}"]
    if 0 < outcome.judged < outcome.count:
        parts.append(f"{number(outcome.judged)} of them judged")
    if trial.met:
        parts.append(f"{number(outcome.met)} {trial.met}")
    return "; ".join(parts)


def _trials_table(findings: list[Finding]) -> Table:
    rows = [
        [
            f.trial.name,
            f.trial.tried,
            _often(f),
            _happened(f),
            f"{f.outcome.worst:.1e} ({f.trial.figure})" if f.trial.figure else "",
        ]
        for f in findings
    ]
    return Table("Trials", ["trial", "what was tried", "how often", "what happened", "worst"], rows, (0, 1, 2, 3, 4))


def _times_table(findings: list[Finding]) -> Table:
    timed = [f for f in findings if f.outcome.times.any()]
    rows = [
        [
            f.trial.name,
            number(int(f.outcome.times.sum())),
            *(_time(seconds) for seconds in f.quantiles),
            _time(f.seen),
            _time(f.again),
            str(f.again_seed),
        ]
        for f in timed
    ]
    note = (
        "CPU time of the thread, the reading of its clock included; as many trials run at a time as there are cores. A "
        "step is a control interval, in ball-grazing one flight and in ball-lens one cycle. The slowest of all, and "
        "p99.99, have the machine's interruptions in them. The three slowest cases were run again, three times: each "
        "of their steps counts with its least time, and the slowest of these is told with its case."
    )
    head = ["trial", "steps timed", "p50, us", "p99, us", "p99.99, us", "slowest, us", "again, us", "case"]
    return Table("Time per step", head, rows, (0,), note)


def _failures_table(findings: list[Finding]) -> Table:
    rows = [
        [f.trial.name, str(failure.seed), failure.reason, repeat(f.trial, failure.seed)]
        for f in findings
        for failure in f.outcome.failures[:LISTED]
    ]
    left = sum(max(0, len(f.outcome.failures) - LISTED) for f in findings)
    note = f"{left} more in the JSON." if left else ""
    return Table("Failures", ["trial", "seed", "reason", "repeat with"], rows, (0, 2, 3), note)


def _sentences(findings: list[Finding]) -> list[str]:
    failures = sum(len(f.outcome.failures) for f in findings)
    failed = sum(bool(f.outcome.failures) for f in findings)
    cases = sum(f.cases for f in findings)
    verdict = f"{counted(failures, 'failure')} in {counted(failed, 'trial')}" if failures else "no failure"
    lines = [f"{counted(len(findings), 'trial')} of {counted(cases, 'case')}: {verdict}."]
    deep = [f for f in findings if f.trial.figure.startswith("deepest")]
    if deep:
        worst = max(deep, key=lambda f: f.outcome.worst)
        units = dict.fromkeys(f.trial.unit for f in deep)
        counts = {unit: sum(f.outcome.judged for f in deep if f.trial.unit == unit) for unit in units}
        searched = ", ".join(f"{number(count)} {unit}" for unit, count in counts.items())
        lines.append(
            f"The deepest passage of a ball through its bar or lens is {worst.outcome.worst:.1e} m "
            f"({worst.trial.name}): the flights around {searched} were searched for one, and behind the other impacts "
            "the ball's place at the end of the interval was looked at."
        )
    timed = [f for f in findings if f.seen > 0.0]
    if timed:
        slow = max(timed, key=lambda f: f.again)
        seen = max(timed, key=lambda f: f.seen)
        lines.append(
            f"The slowest step of all took {_time(seen.seen)} us ({seen.trial.name}), interruptions included; the "
            f"slowest that repeats {_time(slow.again)} us ({slow.trial.name}, case {slow.again_seed}; "
            f"the trial's median is {_time(slow.quantiles[0])} us)."
        )
    if len(findings) == len(TRIALS):
        lines.append("The lecture's pendulum, thread and fabric are not in this suite: nothing of them was tried.")
    return lines


def _numbers(finding: Finding) -> dict[str, Any]:
    outcome = finding.outcome
    return {
        "system": finding.trial.system,
        "tried": finding.trial.tried,
        "cases": finding.cases,
        "count": outcome.count,
        "judged": outcome.judged,
        "met": outcome.met,
        "met_what": finding.trial.met,
        "unit": finding.trial.unit,
        "failures": [
            {**dataclasses.asdict(failure), "repeat": repeat(finding.trial, failure.seed)}
            for failure in outcome.failures
        ],
        "told": outcome.told,
        "worst": outcome.worst,
        "worst_of": finding.trial.figure,
        "worst_seed": outcome.worst_seed,
        "steps_timed": int(outcome.times.sum()),
        "us_p50_p99_p9999": [1e6 * seconds for seconds in finding.quantiles],
        "slowest_us": 1e6 * finding.seen,
        "slowest_again_us": 1e6 * finding.again,
        "slowest_again_seed": finding.again_seed,
        "cpu_seconds": finding.seconds,
    }


def report(findings: list[Finding]) -> Report:
    """Everything that was found."""
    tables = [_trials_table(findings)]
    if any(f.outcome.times.any() for f in findings):
        tables.append(_times_table(findings))
    failed = any(f.outcome.failures for f in findings)
    if failed:
        tables.append(_failures_table(findings))
    figures = {"time": step_times(findings), "passage": passages(findings)}
    return Report(
        "stress",
        "Stress",
        _sentences(findings),
        tables,
        {f.trial.name: _numbers(f) for f in findings},
        {name: figure for name, figure in figures.items() if figure is not None},
        failed=failed,
    )
