"""The tables and sentences of the speed benchmark, all from the numbers."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

from vr_envs.bench.report import Report, Table
from vr_envs.bench.speed.arrays.namespace import NUMPY
from vr_envs.bench.speed.contestants import CARTPOLE, IMPACTS, Case
from vr_envs.bench.speed.goals import Goal
from vr_envs.bench.speed.measure import FAMILIES, NATIVE, SCALAR, SYNC, SYNC_ROWS, Measured
from vr_envs.bench.timing import Spread


def _millions(spread: Spread | None) -> str:
    return "-" if spread is None else spread.scaled(1e-6).text()


def _speeds(cases: Sequence[Case], measured: Measured, rows: Sequence[int]) -> Table:
    lines = []
    for case in cases:
        impacts = measured.impacts.get(case.label)
        for family in (name for name in FAMILIES if name != SCALAR):
            cells = [_millions(measured.of(case.label, family, count)) for count in rows]
            if set(cells) != {"-"}:
                lines.append([case.label, family, *cells, "-" if impacts is None else f"{impacts:.1f}"])
    return Table(
        "Million environment steps per CPU second, by number of rows",
        ["scene", "form", *(str(count) for count in rows), "impacts per step"],
        lines,
        (0, 1),
        f"Median (minimum to maximum). Actions drawn before the clock starts, fresh arrays, autoreset on. A "
        f"{SYNC} is a loop: above {SYNC_ROWS} rows a step costs what it does there. {NUMPY.name} and JAX keep no "
        "metrics, and take actions as they are; the others refuse what is not finite.",
    )


def _singles(cases: Sequence[Case], measured: Measured) -> Table:
    reference = measured.of(CARTPOLE, SCALAR, 1)
    lines = []
    for label in (CARTPOLE, *(case.label for case in cases)):
        spread = measured.of(label, SCALAR, 1)
        if spread is not None and reference is not None:
            times = Spread.of([1e6 / rate for rate in spread])
            lines.append([label, times.text(), f"{spread.median / reference.median:.2f}"])
    note = "All through `gym.make` with its usual wrappers, timed in turn; episodes that end are reset."
    return Table("One environment", ["environment", "us per step", f"speed over {CARTPOLE}"], lines, (0,), note)


def _shared(measured: Measured) -> Table:
    lines = [
        [
            s.case, str(s.rows), _millions(s.alone), str(s.threads), _millions(s.shared),
            f"{s.shared.median / s.alone.median:.2f}",
        ]
        for s in measured.shared
    ]  # fmt: skip
    return Table(
        "More threads: million environment steps per second by the wall clock",
        ["scene", "rows", "one thread", "threads", "together", "ratio"],
        lines,
        (0,),
        "Together: the rows in as many batches as threads, each stepped by a Python thread of its own; kernels do not "
        "hold Python's lock. What else the machine does counts here.",
    )


def _aims(goals: Sequence[Goal]) -> Table:
    lines = [
        [
            g.what, f"at least {g.wanted:g} {g.unit}", f"{g.found:.3g}",
            "met" if g.met else "not met",
        ]
        for g in goals
    ]  # fmt: skip
    return Table("Goals", ["what", "goal", "found", ""], lines, (0, 1, 3))


def _trainings(trainings: Sequence[dict[str, Any]]) -> Table:
    lines = []
    for t in trainings:
        parts = [t["environments"], t["policy"], t["update"]]
        total = sum(parts)
        shares = [f"{100.0 * part / total:.0f} %" for part in parts]
        lines.append([t["env_id"], t["vec_env"], str(t["rows"]), f"{1e-3 * t['steps'] / total:.1f}", *shares])
    head = ["environment", "form", "rows", "thousand steps/s", "environments", "policy", "update"]
    note = (
        "PPO of Stable-Baselines3, one thread, default scenes, the same samples per update and settings; shares of the "
        "CPU time. Policy: actions, values and the buffer."
    )
    return Table("Training", head, lines, (0, 1), note)


def _ratio_sentences(cases: Sequence[Case], measured: Measured, rows: Sequence[int]) -> list[str]:
    found = []
    for case in cases:
        ratios = []
        for count in rows:
            ours, theirs = (measured.of(case.label, family, count) for family in (NATIVE, NUMPY.name))
            if ours is not None and theirs is not None:
                ratios.append(f"{ours.median / theirs.median:.1f} at {count}")
        if ratios:
            found.append(f"{case.label}: the native batch makes {', '.join(ratios)} rows times the steps of NumPy.")
    return found


def account(
    cases: Sequence[Case],
    rows: Sequence[int],
    measured: Measured,
    goals: Sequence[Goal],
    trainings: Sequence[dict[str, Any]],
    left_out: Sequence[str],
) -> Report:
    """The report without its picture; `left_out`: sentences on what was not measured."""
    met = sum(goal.met for goal in goals)
    sentences = [f"{met} of {len(goals)} goals are met on this machine."] if goals else []
    missed = [goal for goal in goals if not goal.met]
    sentences += [f"Not met: {g.what}: {g.found:.3g} {g.unit} for {g.wanted:g}." for g in missed]
    sentences += _ratio_sentences(cases, measured, rows)
    for first, second in zip(trainings, trainings[1:], strict=False):
        if first["rows"] == second["rows"] and first["env_id"] == second["env_id"]:
            share = 100.0 * second["environments"] / first["environments"]
            sentences.append(
                f"{first['env_id']}: in training, {first['rows']} environments take {share:.0f} % of the CPU time in a "
                "native batch that they take one by one."
            )
    opponents = dict.fromkeys(case.opponent for case in cases if case.opponent is not None)
    sentences += [opponent.note for opponent in opponents if opponent.note]
    tables = [_speeds(cases, measured, rows), _singles(cases, measured)]
    tables += [_aims(goals)] if goals else []
    tables += [_shared(measured)] if measured.shared else []
    tables += [_trainings(trainings)] if trainings else []
    numbers = {
        "steps_per_cpu_second": [{**dataclasses.asdict(s), "spread": s.spread._asdict()} for s in measured.speeds],
        "threads": [
            {**dataclasses.asdict(s), "alone": s.alone._asdict(), "shared": s.shared._asdict()} for s in measured.shared
        ],
        IMPACTS: measured.impacts,
        "goals": [{**dataclasses.asdict(g), "met": g.met} for g in goals],
        "training_cpu_s": list(trainings),
    }
    return Report("speed", "Speed", [*sentences, *left_out], tables, numbers)
