"""The tables and sentences of the speed benchmark, all from the numbers."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

from vr_envs.bench.report import Report, Table
from vr_envs.bench.speed.arrays.namespace import NUMPY
from vr_envs.bench.speed.contestants import CARTPOLE, IMPACTS, Case
from vr_envs.bench.speed.goals import Goal
from vr_envs.bench.speed.measure import (
    FAMILIES,
    JAX,
    NATIVE,
    SCALAR,
    SETTLED,
    SYNC,
    SYNC_ROWS,
    Measured,
    episode_calls,
)
from vr_envs.bench.timing import Spread


def _millions(spread: Spread | None) -> str:
    return "-" if spread is None else spread.scaled(1e-6).text()


def _timings(measured: Measured) -> str:
    return f"Median (minimum to maximum) of {measured.repeats} timings"


def _has_jax(measured: Measured) -> bool:
    return any(speed.family == JAX for speed in measured.speeds)


def _speeds_note(cases: Sequence[Case], measured: Measured) -> str:
    calls = sorted({episode_calls(case, NATIVE) for case in cases})
    resets = " to ".join(f"one in {count}" for count in dict.fromkeys((calls[0], calls[-1])))
    sentences = [
        f"{_timings(measured)}. Actions drawn before the clock starts, fresh arrays, autoreset on.",
        f"Every form of a scene has made {SETTLED} steps when its clock starts.",
        f"A timing lasts about {measured.seconds:g} s: a whole number of episodes where one takes at most twice as "
        "long; less than an episode in slower forms, with or without the call in which most rows begin anew.",
        f"In a {NATIVE} and a {SYNC} the reset of a row is a call without physics that counts as a step, {resets} "
        "where episodes last until they are cut.",
        f"A {SYNC} is a loop: above {SYNC_ROWS} rows a step costs what it does there.",
        "All forms hand every step back to Python.",
        f"{NUMPY.name} and {JAX} keep no metrics, and take actions as they are; the others refuse what is not finite.",
    ]
    if _has_jax(measured):
        sentences.append(
            f"{JAX} computes in one thread. A program whose loop over steps {JAX} compiles too (`lax.scan`) avoids the "
            "dispatch of every step, which dominates at few rows."
        )
    return " ".join(sentences)


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
        _speeds_note(cases, measured),
    )


def _singles(cases: Sequence[Case], measured: Measured) -> Table:
    reference = measured.of(CARTPOLE, SCALAR, 1)
    lines = []
    for label in (CARTPOLE, *(case.label for case in cases)):
        spread = measured.of(label, SCALAR, 1)
        if spread is not None and reference is not None:
            times = Spread.of([1e6 / rate for rate in spread])
            lines.append([label, times.text(), f"{spread.median / reference.median:.2f}"])
    note = (
        f"{_timings(measured)}, in turn. All through `gym.make` with its usual wrappers; episodes that end are reset."
    )
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
        f"{_timings(measured)}, in turn. Together: the rows in as many batches as threads, each stepped by a Python "
        "thread of its own; kernels do not hold Python's lock. What else the machine does counts here.",
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


def _parts(training: dict[str, Any]) -> list[tuple[float, ...]]:
    """CPU seconds in the environments, the policy and the updates, by repeat."""
    return list(zip(training["environments"], training["policy"], training["update"], strict=True))


def _trainings(trainings: Sequence[dict[str, Any]]) -> Table:
    lines = []
    for t in trainings:
        parts = _parts(t)
        rate = Spread.of([1e-3 * t["steps"] / sum(some) for some in parts])
        shares = [Spread.of([100.0 * some[k] / sum(some) for some in parts]).text(2) for k in range(3)]
        lines.append([t["env_id"], t["vec_env"], str(t["rows"]), rate.text(), *shares])
    head = ["environment", "form", "rows", "thousand steps/s", "environments, %", "policy, %", "update, %"]
    repeats, steps = len(trainings[0]["environments"]), trainings[0]["steps"]
    note = (
        f"Median (minimum to maximum) of {repeats} runs of {steps} steps, in turn. PPO of Stable-Baselines3, one "
        "thread, default scenes, the same samples per update and settings; shares of the CPU time. Policy: actions, "
        "values and the buffer."
    )
    return Table("Training", head, lines, (0, 1), note)


def _training_sentences(trainings: Sequence[dict[str, Any]]) -> list[str]:
    found = []
    for one, batch in zip(trainings, trainings[1:], strict=False):
        if (one["rows"], one["env_id"]) == (batch["rows"], batch["env_id"]):
            times = zip(batch["environments"], one["environments"], strict=True)
            share = Spread.of([100.0 * ours / theirs for ours, theirs in times])
            found.append(
                f"{one['env_id']}: in training, {one['rows']} environments take {share.text(2)} % of the CPU time in a "
                "native batch that they take one by one."
            )
    return found


def _ratio(ours: Spread, theirs: Spread) -> str:
    """Of the medians, to three significant digits, without an exponent."""
    return f"{float(f'{ours.median / theirs.median:.3g}'):g} times"


def _ratio_sentences(cases: Sequence[Case], measured: Measured, rows: Sequence[int]) -> list[str]:
    found = []
    for case in cases:
        for family in (NUMPY.name, JAX):
            ratios = []
            for count in rows:
                ours, theirs = (measured.of(case.label, name, count) for name in (NATIVE, family))
                if ours is not None and theirs is not None:
                    what = "" if ratios else f" the steps of {family}"
                    unit = "" if ratios else " row" if count == 1 else " rows"
                    ratios.append(f"{_ratio(ours, theirs)}{what} at {count}{unit}")
            if ratios:
                found.append(f"{case.label}: the native batch makes {', '.join(ratios)}.")
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
    sentences += _training_sentences(trainings)
    opponents = dict.fromkeys(case.opponent for case in cases if case.opponent is not None)
    sentences += [opponent.note for opponent in opponents if opponent.note]
    tables = [_speeds(cases, measured, rows), _singles(cases, measured)]
    tables += [_aims(goals)] if goals else []
    tables += [_shared(measured)] if measured.shared else []
    tables += [_trainings(trainings)] if trainings else []
    numbers = {
        "repeats": measured.repeats,
        "seconds_per_timing": measured.seconds,
        "steps_before_timing": SETTLED,
        "steps_per_cpu_second": [{**dataclasses.asdict(s), "spread": s.spread._asdict()} for s in measured.speeds],
        "threads": [
            {**dataclasses.asdict(s), "alone": s.alone._asdict(), "shared": s.shared._asdict()} for s in measured.shared
        ],
        IMPACTS: measured.impacts,
        "goals": [{**dataclasses.asdict(g), "met": g.met} for g in goals],
        "training_cpu_s": list(trainings),
    }
    packages = [*(["jax"] if _has_jax(measured) else []), *(["torch", "stable-baselines3"] if trainings else [])]
    return Report("speed", "Speed", [*sentences, *left_out], tables, numbers, packages=packages)
