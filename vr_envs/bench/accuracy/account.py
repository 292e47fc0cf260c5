"""What the points of one system say: sentences computed from them, tables, and everything as numbers."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

from vr_envs.bench.accuracy.front import TARGET, Reach, front, methods, reach, with_error
from vr_envs.bench.accuracy.points import Measure, Point
from vr_envs.bench.report import Table

EXACT = "exact"
WANTED = 100.0  # times as fast as the best fixed step at `TARGET`
UNSURE = ("extrapolated", "at most")  # ways to know a cost that a sentence names


@dataclasses.dataclass(frozen=True)
class System:
    """A system's points.

    `measures`: the kinds of error its points may have. `episodes`: name -> what happens in it. `note`: sentences on
    what was tried and how. `interval`: the control interval [s], if it is to be told what one costs.
    """

    name: str
    title: str
    measures: Sequence[Measure]
    episodes: dict[str, str]
    points: Sequence[Point]
    note: str = ""
    interval: float | None = None

    def panels(self) -> list[tuple[str, Measure]]:
        """The pairs of episode and kind of error that have points."""
        pairs = [(episode, measure) for episode in self.episodes for measure in self.measures]
        return [pair for pair in pairs if with_error(self.points, *pair)]


def reaches(points: Sequence[Point], measure: Measure) -> list[Reach]:
    """`reach` of each method among the points of one episode, the cheapest first, those that do not reach it last."""
    found = [reach(own, measure) for own in methods(points).values()]
    return sorted(found, key=lambda r: math.inf if r.cost is None else r.cost)


def is_on_front(points: Sequence[Point], measure: Measure) -> bool:
    """Whether the exact engine is on the front of these points."""
    return any(p.method.family == EXACT for p in front(points, measure))


def _short(number: float) -> str:
    """Two digits; a large number as a power of ten."""
    rounded = float(f"{number:.2g}")
    if rounded < 100.0:
        return f"{rounded:.2g}"
    return f"{rounded:,.0f}" if rounded < 1e6 else f"{rounded:.1e}".replace("e+0", "e").replace("e+", "e")


def _of(some: int, total: int) -> str:
    return f"{some} of {total} pair{'s' * (total != 1)}"


def front_sentence(system: System) -> str:
    """On how many fronts the exact engine is, and what beats it on the others."""
    panels = [(e, m, with_error(system.points, e, m)) for e, m in system.panels()]
    off = [(e, m, points) for e, m, points in panels if not is_on_front(points, m)]
    if not off:
        where = f"all {len(panels)} pairs" if len(panels) > 1 else "the one pair"
        return f"{system.title}: the exact engine is on the front in {where} of episode and error."
    told = []
    for episode, measure, points in off:
        mine = min((measure.of(p) for p in points if p.method.family == EXACT), default=math.inf)
        better = [p for p in front(points, measure) if measure.of(p) <= mine]
        told.append(f"{measure.name} in {episode!r}: beaten by {', '.join(p.label for p in better)}")
    return (
        f"{system.title}: the exact engine is on the front in {_of(len(panels) - len(off), len(panels))} of "
        f"episode and error; not in {'; '.join(told)}."
    )


def _against(mine: float, others: Sequence[Reach], what: str) -> str:
    """A clause: how many times as fast as the cheapest of `others` the exact engine is at the wanted error."""
    if not others:
        return f"no {what} was tried"
    best = others[0]
    if best.cost is None:
        return f"no {what} reaches it"
    ratio, bound = best.cost / mine, best.how == "at most"
    how = f", {best.how} at order {best.order:.2f}" if best.how == "extrapolated" else f", {best.how}"
    times = f"{'at most ' * bound}{_short(ratio)} times as fast"
    if ratio < 1.0:
        times = f"{'at least ' * bound}{_short(1.0 / ratio)} times as slow"
    return f"exact is {times} as the best {what} ({best.method.name}{how * (not bound)})"


def target_sentence(points: Sequence[Point], episode: str, measure: Measure) -> str:
    """How the exact engine compares at the wanted error with the best fixed step and the best of all others."""
    mine, stepped, others = rivals(points, measure)
    where = f"{episode}, {measure.name} to {measure.amount(TARGET)}"
    if mine is None:
        return f"{where}: the exact engine does not reach it."
    first, second = _against(mine, stepped, "fixed step"), _against(mine, others, "other method")
    return f"{where}: {first}; {second}."


def rivals(points: Sequence[Point], measure: Measure) -> tuple[float | None, list[Reach], list[Reach]]:
    """What the exact engine costs at the wanted error, and `reaches` of the fixed steps and of all others."""
    found = reaches(points, measure)
    mine = next((r.cost for r in found if r.method.family == EXACT), None)
    rest = [r for r in found if r.method.family != EXACT]
    return mine, [r for r in rest if r.method.fixed_step], [r for r in rest if not r.method.fixed_step]


def ratio_sentence(system: System, fixed_step: bool) -> str:
    """Between which bounds the exact engine is faster than the best fixed step, or the best of the other methods."""
    what = "fixed step" if fixed_step else "other method"
    ratios: list[tuple[float, str, str]] = []
    unreached, untried, short = 0, 0, 0
    panels = system.panels()
    for episode, measure in panels:
        mine, stepped, others = rivals(with_error(system.points, episode, measure), measure)
        rest = stepped if fixed_step else others
        if mine is None:
            short += 1
        elif not rest:
            untried += 1
        elif rest[0].cost is None:
            unreached += 1
        else:
            ratios.append((rest[0].cost / mine, f"{episode}, {measure.name}", rest[0].how))
    told = []
    if ratios:
        ends = [min(ratios), max(ratios)] if len(ratios) > 1 else ratios
        bounds = " to ".join(
            f"{_short(ratio)} ({pair}{f'; {how}' if how in UNSURE else ''})" for ratio, pair, how in ends
        )
        kinds = {how: sum(r[2] == how for r in ratios) for how in UNSURE}
        known = ", ".join(f"{number} of {len(ratios)} {how}" for how, number in kinds.items() if number)
        told.append(f"the exact engine is {bounds} times as fast as the best {what}{f' ({known})' if known else ''}")
        missed = sum(ratio < WANTED for ratio, *_ in ratios)
        if fixed_step and missed:
            told.append(f"short of the {WANTED:g} times wanted in {_of(missed, len(ratios))}")
    told += [
        f"{clause} in {_of(number, len(panels))}"
        for clause, number in (
            (f"no {what} reaches it", unreached),
            (f"no {what} was tried", untried),
            ("the exact engine itself does not reach it", short),
        )
        if number
    ]
    return f"{system.title}: at an error of {TARGET:g} {'; '.join(told)}."


def interval_sentence(system: System) -> str | None:
    """Why the wanted ratio is missed, if that is so because the best fixed step makes few steps a control interval.

    What one of its steps costs is that of the points with one step per interval. None if nothing is to be told: no
    ratio is missed, there are no such points, or a hundredth of what the fixed step costs is more than one step.
    """
    if system.interval is None:
        return None
    told: dict[str, list[tuple[str, float]]] = {}
    for episode, measure in system.panels():
        points = with_error(system.points, episode, measure)
        mine, stepped, _ = rivals(points, measure)
        best = stepped[0] if stepped else None
        if mine is None or best is None or best.cost is None or best.cost >= WANTED * mine:
            continue
        whole = [p for p in points if p.method == best.method and p.value and math.isclose(p.value, system.interval)]
        if not whole or best.cost >= WANTED * whole[0].cost.median:
            continue
        name, step = best.method.name, whole[0].cost.median
        own, one = (f"{_short(1e9 * cost * system.interval)} ns" for cost in (mine, step))
        costs = (
            f"in {episode!r} a control interval of {system.interval:g} s costs the exact engine {own} and one step of "
            f"{name} {one}, and {name} needs"
        )
        wanted = 1e9 * best.cost / WANTED * system.interval
        told.setdefault(costs, []).append((f"{_short(best.cost / step)} ({measure.name})", wanted))
    if not told:
        return None
    clauses = [
        f"{costs} the time of {', '.join(steps for steps, _ in pairs)} such steps for {TARGET:g}, so that the exact "
        f"engine would have to move a record in {_short(min(wanted for _, wanted in pairs))} ns"
        for costs, pairs in told.items()
    ]
    return f"{system.title}, why not {WANTED:g} times as fast: {'; '.join(clauses)}."


def sentences(system: System) -> list[str]:
    """What the points show, whether it is what was hoped for or not."""
    told = [target_sentence(with_error(system.points, e, m), e, m) for e, m in system.panels()]
    why = interval_sentence(system)
    ratios = [ratio_sentence(system, True), *([] if why is None else [why]), ratio_sentence(system, False)]
    return [front_sentence(system), *ratios, *told]


def _cost(cost: float | None) -> str:
    return "-" if cost is None else f"{cost:.2g}"


def target_table(system: System) -> Table:
    """Every method at the wanted error: order, cost, how that is known, and how many times the exact engine's it is."""
    rows = []
    for episode, measure in system.panels():
        points = with_error(system.points, episode, measure)
        found = reaches(points, measure)
        mine = next((r.cost for r in found if r.method.family == EXACT), None)
        finest = {method: min(p.errors[measure.name] for p in own) for method, own in methods(points).items()}
        for r in found:
            swept = "" if r.order is None or not r.method.setting else f"{r.order:.2f}"
            ratio = "-" if r.cost is None or mine is None else _short(r.cost / mine)
            best = finest[r.method]
            smallest = f"{best:.1e}" if math.isfinite(best) else "astray"
            rows.append([episode, measure.label, r.method.name, smallest, swept, _cost(r.cost), r.how, ratio])
    head = ["episode", "error", "method", "smallest error", "order", f"cost at {TARGET:g}", "known how", "over exact"]
    episodes = " ".join(f"{name.capitalize()}: {text}." for name, text in system.episodes.items())
    note = f"{episodes} {system.note}".rstrip() + (
        "\n\nCost: CPU seconds per simulated second, one core. Order: power of the step or tolerance with which the "
        "error falls. Extrapolated: from the finest step with the measured order, as if rounding did not stop it. At "
        "most: a setting that was not tried may do for less. "
        + " ".join(f"{m.name.capitalize()}: {m.meaning}." for m in system.measures)
    )
    return Table(f"{system.title}: at equal error", head, rows, left=(0, 1, 2, 6), note=note, detail=True)


def points_table(system: System) -> Table:
    """Every point; a star marks the errors with which it is on the front."""
    best = {(e, m.name): front(with_error(system.points, e, m), m) for e, m in system.panels()}
    rows = []
    for p in system.points:
        cells = []
        for m in system.measures:
            error = p.errors.get(m.name)
            star = " *" if error is not None and p in best[p.episode, m.name] else ""
            cells.append("" if error is None else f"{error:.1e}{star}" if math.isfinite(error) else "astray")
        went = any(math.isfinite(error) for error in p.errors.values())
        rows.append([p.episode, p.label, p.cost.text(2) if went else "-", *cells])
    head = ["episode", "method", "CPU s per simulated s", *(m.label for m in system.measures)]
    floors = ", ".join(f"{m.name} {m.amount(m.rounding)}" for m in system.measures)
    note = f"For the front, errors below what rounding leaves are equal: {floors}."
    return Table(f"{system.title}: every point (* on the front)", head, rows, left=(0, 1), note=note, detail=True)


def numbers(system: System) -> dict[str, Any]:
    """Everything, for programs."""
    panels = []
    for episode, measure in system.panels():
        points = with_error(system.points, episode, measure)
        panels.append(
            {
                "episode": episode,
                "error": measure.name,
                "unit": measure.unit,
                "front": [p.label for p in front(points, measure)],
                "exact_on_front": is_on_front(points, measure),
                "at_target": [
                    {"method": r.method.name, "cost": r.cost, "known": r.how, "order": r.order}
                    for r in reaches(points, measure)
                ],
            }
        )
    return {
        "episodes": system.episodes,
        "target": TARGET,
        "panels": panels,
        "points": [p.as_dict() for p in system.points],
    }
