"""What follows from points of run time against error: the front, orders of convergence, the cost of a wanted error."""

from __future__ import annotations

import dataclasses
import math
import statistics
from collections.abc import Iterable, Sequence
from itertools import combinations

from vr_envs.bench.accuracy.points import Measure, Method, Point

TARGET = 1e-9
"""Error, in the SI unit of its measure, at which methods are compared."""
LEAST_ORDER = 0.5  # below it, as where errors are as large as they can be, nothing is extrapolated


def with_error(points: Iterable[Point], episode: str, measure: Measure) -> list[Point]:
    """The points of an episode that have this error."""
    return [p for p in points if p.episode == episode and measure.name in p.errors]


def front(points: Sequence[Point], measure: Measure) -> list[Point]:
    """The points that no other beats in cost without a larger error, or in error without a higher cost; cheapest first.

    Errors below rounding are the same. Points that went astray (infinite error) are not among them.
    """
    found: list[Point] = []
    for point in sorted(points, key=lambda p: (p.cost.median, measure.of(p))):
        if measure.of(point) < (measure.of(found[-1]) if found else math.inf):
            found.append(point)
    return found


def methods(points: Iterable[Point]) -> dict[Method, list[Point]]:
    """The points of each method, cheapest first, in the order in which the methods come."""
    found: dict[Method, list[Point]] = {}
    for point in points:
        found.setdefault(point.method, []).append(point)
    return {method: sorted(own, key=lambda p: p.cost.median) for method, own in found.items()}


def order(points: Sequence[Point], measure: Measure) -> float | None:
    """Power of the setting with which the error of one method falls: median slope over pairs of points, log-log.

    Of the points that have not gone astray, more than half, and two at least, must be above rounding; None if not. The
    median leaves out a coarse step that is not yet in the asymptotic range, or an error that is small by chance.
    """
    followed = [p for p in points if measure.of(p) <= measure.astray and math.isfinite(measure.of(p))]
    usable = [(math.log(p.value), math.log(measure.of(p))) for p in followed if p.value and measure.resolves(p)]
    if 2 * len(usable) <= len(followed):
        return None
    slopes = [(b[1] - a[1]) / (b[0] - a[0]) for a, b in combinations(usable, 2) if a[0] != b[0]]
    return statistics.median(slopes) if slopes else None


@dataclasses.dataclass(frozen=True)
class Reach:
    """What a method costs at the wanted error, CPU seconds per simulated second (None: it is not reached).

    `how`: "measured", of a method without a setting; "interpolated" between two measured points; "at most" (the cost is
    that of the cheapest point as good, and a setting that was not tried may do for less: that point is the cheapest of
    all, or so good that it is no matter of order); "extrapolated" from the finest with the measured order and a cost
    inverse to the step; or "not reached". `order`: the measured one, if any.
    """

    method: Method
    cost: float | None
    how: str
    order: float | None


def reach(points: Sequence[Point], measure: Measure, target: float = TARGET) -> Reach:
    """At what cost the method of these points (one method, one episode) has an error of at most `target`.

    Only a step is extrapolated: what another setting costs, and whether it helps, is not known beforehand. That no
    rounding is met on the way is in favour of the method.
    """
    method, found, best = points[0].method, order(points, measure), front(points, measure)
    after = next((k for k, p in enumerate(best) if measure.of(p) <= target), None)
    if after is not None and (after == 0 or not measure.resolves(best[after])):
        return Reach(method, best[after].cost.median, "at most" if method.setting else "measured", found)
    if after is not None:
        coarse, fine = best[after - 1], best[after]
        share = math.log(measure.of(coarse) / target) / math.log(measure.of(coarse) / measure.of(fine))
        return Reach(
            method, coarse.cost.median * (fine.cost.median / coarse.cost.median) ** share, "interpolated", found
        )
    if best and method.setting == "step" and found is not None and found >= LEAST_ORDER:
        factor = (measure.of(best[-1]) / target) ** (1.0 / found)
        return Reach(method, best[-1].cost.median * factor, "extrapolated", found)
    return Reach(method, None, "not reached", found)
