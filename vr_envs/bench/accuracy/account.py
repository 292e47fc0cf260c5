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
WANTED = 100.0  # times faster than the best fixed step at `TARGET`


@dataclasses.dataclass(frozen=True)
class System:
    """A system's points.

    `measures`: the kinds of error its points may have. `episodes`: name -> what happens in it. `note`: sentences on
    what was tried and how.
    """

    name: str
    title: str
    measures: Sequence[Measure]
    episodes: dict[str, str]
    points: Sequence[Point]
    note: str = ""

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
    if number < 100.0:
        return f"{number:.2g}"
    return f"{float(f'{number:.2g}'):,.0f}" if number < 1e6 else f"{number:.1e}".replace("e+0", "e").replace("e+", "e")


def front_sentence(system: System) -> str:
    """On how many fronts the exact engine is, and what beats it on the others."""
    panels = [(e, m, with_error(system.points, e, m)) for e, m in system.panels()]
    off = [(e, m, points) for e, m, points in panels if not is_on_front(points, m)]
    if not off:
        return f"{system.title}: the exact engine is on the front in all {len(panels)} pairs of episode and error."
    told = []
    for episode, measure, points in off:
        mine = min((measure.of(p) for p in points if p.method.family == EXACT), default=math.inf)
        better = [p for p in front(points, measure) if measure.of(p) <= mine]
        told.append(f"{measure.name} in {episode!r}: beaten by {', '.join(p.label for p in better)}")
    return (
        f"{system.title}: the exact engine is on the front in {len(panels) - len(off)} of {len(panels)} pairs of "
        f"episode and error; not in {'; '.join(told)}."
    )


def _against(mine: float, others: Sequence[Reach], what: str) -> str:
    """A clause: how many times faster than the cheapest of `others` the exact engine is at the wanted error."""
    if not others:
        return f"no {what} was tried"
    best = others[0]
    if best.cost is None:
        return f"no {what} reaches it"
    how = f"{best.how} at order {best.order:.2f}" if best.how == "extrapolated" and best.order else best.how
    ratio = best.cost / mine
    times = f"{_short(ratio)} times faster" if ratio >= 1.0 else f"{_short(1.0 / ratio)} times slower"
    return f"exact is {times} than the best {what} ({best.method.name}, {how})"


def target_sentence(points: Sequence[Point], episode: str, measure: Measure) -> str:
    """How the exact engine compares at the wanted error with the best fixed step and the best of all others."""
    mine, stepped, others = rivals(points, measure)
    where = f"{episode}, {measure.name} to {TARGET:g} {measure.unit}"
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
    ratios: dict[str, float] = {}
    panels = system.panels()
    for episode, measure in panels:
        mine, stepped, others = rivals(with_error(system.points, episode, measure), measure)
        rest = stepped if fixed_step else others
        if mine is not None and rest and rest[0].cost is not None:
            ratios[f"{episode}, {measure.name}"] = rest[0].cost / mine
    what = "fixed step" if fixed_step else "other method"
    if not ratios:
        return f"{system.title}: no {what} reaches an error of {TARGET:g}."
    least, most = min(ratios, key=ratios.__getitem__), max(ratios, key=ratios.__getitem__)
    short = sum(ratio < WANTED for ratio in ratios.values()) if fixed_step else 0
    verdict = f"; short of the {WANTED:g} times wanted in {short} of {len(ratios)} pairs" if short else ""
    if missing := len(panels) - len(ratios):
        verdict += f" ({missing} of {len(panels)} pairs have no {what} that reaches it)"
    return (
        f"{system.title}: at an error of {TARGET:g} the exact engine is {_short(ratios[least])} ({least}) to "
        f"{_short(ratios[most])} ({most}) times as fast as the best {what}{verdict}."
    )


def sentences(system: System) -> list[str]:
    """What the points show, whether it is what was hoped for or not."""
    told = [target_sentence(with_error(system.points, e, m), e, m) for e, m in system.panels()]
    return [front_sentence(system), ratio_sentence(system, True), ratio_sentence(system, False), *told]


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
            error = f"{measure.name} ({measure.unit})"
            rows.append([episode, error, r.method.name, smallest, swept, _cost(r.cost), r.how, ratio])
    head = ["episode", "error", "method", "smallest error", "order", f"cost at {TARGET:g}", "known how", "over exact"]
    episodes = " ".join(f"{name.capitalize()}: {text}." for name, text in system.episodes.items())
    note = f"{episodes} {system.note}".rstrip() + (
        "\n\nCost: CPU seconds per simulated second, one core. Order: power of the step or tolerance with which the "
        "error falls. Extrapolated: from the finest step with the measured order, as if rounding did not stop it. "
        + " ".join(f"{m.name.capitalize()}: {m.meaning}." for m in system.measures)
    )
    return Table(f"{system.title}: at equal error", head, rows, left=(0, 1, 2, 6), note=note)


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
    head = ["episode", "method", "CPU s per simulated s", *(f"{m.name} ({m.unit})" for m in system.measures)]
    return Table(f"{system.title}: every point (* on the front)", head, rows, left=(0, 1))


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
