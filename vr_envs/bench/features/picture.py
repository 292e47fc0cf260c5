"""What every option costs, as bars."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from vr_envs.bench.features.costs import Cost

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAMES = {
    "ball_on_bar": "ball on bar, per impact",
    "autopilot": "autopilot, per step",
    "terrain_ride": "terrain ride, per step",
}
TICKS = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0)
ROOM = 0.2  # of the axis, for the largest number


def option_bars(costs: Mapping[str, Sequence[Cost]], pruned: Mapping[str, Sequence[Cost]]) -> Figure:
    """Time with an option over time without it, one panel a system; and that of absent options."""
    from matplotlib.figure import Figure

    from vr_envs.render.style import BLUE, GREY, INK, ORANGE, PALE_BLUE

    blue, pale, grey, ink, orange = (
        tuple(part / 255.0 for part in colour) for colour in (BLUE, PALE_BLUE, GREY, INK, ORANGE)
    )
    tallest = max(len(found) for found in costs.values()) + 1
    figure = Figure((4.2 * len(costs), 1.2 + 0.3 * tallest), layout="constrained")
    panels = figure.subplots(1, len(costs), squeeze=False)[0]
    for axes, (system, found) in zip(panels, costs.items(), strict=True):
        bars = [("all off", pruned[system][0].ratio, orange)]
        bars += [
            (cost.name, cost.ratio, pale if cost.lockstep == (False, True) else blue)
            for cost in sorted(found, key=lambda cost: cost.ratio.median)
        ]
        for place, (_, ratio, colour) in enumerate(bars):
            axes.barh(place, ratio.median - 1.0, left=1.0, height=0.7, color=colour)
            axes.plot([ratio.minimum, ratio.maximum], [place, place], color=ink, linewidth=1.0)
            axes.annotate(
                f"{ratio.median:.2f}", (max(1.0, ratio.maximum), place), (4, 0), textcoords="offset points",
                va="center", fontsize=8, color=ink,
            )  # fmt: skip
        largest = max(ratio.maximum for _, ratio, _ in bars)
        smallest = min(ratio.minimum for _, ratio, _ in bars)
        low = min(0.7, 0.9 * smallest)
        high = low * (max(1.5, largest) / low) ** (1.0 / (1.0 - ROOM))
        axes.set(xscale="log", xlim=(low, high))
        ticks = [tick for tick in TICKS if low <= tick <= high]
        axes.xaxis.set_ticks(ticks, [f"{tick:g}" for tick in ticks])
        axes.xaxis.set_ticks([], minor=True)
        axes.set_yticks(range(len(bars)), [name for name, _, _ in bars])
        axes.axvline(1.0, color=grey, linewidth=1.0)
        axes.set_title(NAMES.get(system, system), fontsize=10, loc="left")
        axes.spines[["top", "right"]].set_visible(False)
    figure.supxlabel(
        "time with one option over time without (pale: with it the rows are moved one by one, without it eight at a "
        "time); orange: every option off, over kernels that never had any",
        fontsize=9,
    )
    return figure
