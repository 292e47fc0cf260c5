"""The picture of run time against error of one system: a panel for each episode and kind of error."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure

from vr_envs.bench.accuracy.account import System
from vr_envs.bench.accuracy.front import front, methods, with_error
from vr_envs.bench.accuracy.points import FAMILIES, Measure, Method

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS: dict[str, str] = dict(
    zip(FAMILIES, ("#c43e34", "#dd8028", "#8c6b3f", "#2f6fa3", "#7b4fa3", "#c765a0", "#80858d", "#2b313a"), strict=True)
)
MARKERS = "osD^v"
ACROSS, DOWN = 4, 3  # panels across, if there would be more rows than this
EDGE = 3.0  # the axes go beyond the points by this factor


def _style(method: Method, names: list[Method]) -> dict[str, Any]:
    """Colour by family, marker by place among the methods of the family."""
    place = [m for m in names if m.family == method.family].index(method)
    star = method.family == "exact"
    return {
        "color": COLOURS[method.family],
        "marker": "*" if star else MARKERS[place % len(MARKERS)],
        "markersize": 13 if star else 4.5,
        "lw": 1.0,
        "ls": ("-", "--", ":", "-.")[place % 4],
        "zorder": 5 if star else 3,
        "label": method.name,
    }


def _panel(axes: Axes, system: System, episode: str, measure: Measure, names: list[Method]) -> None:
    points = [p for p in with_error(system.points, episode, measure) if math.isfinite(measure.of(p))]
    errors, costs = [measure.of(p) for p in points], [p.cost.median for p in points]
    left, right = min(errors) / EDGE, EDGE * max(errors)
    bottom, top = min(costs) / EDGE, EDGE * max(costs)
    best = [(measure.of(p), p.cost.median) for p in front(points, measure)]
    # from the right along the cheapest, up and to the left: no point lies below or left of it
    stairs = [(right, best[0][1])]
    for error, cost in best:
        stairs += [(stairs[-1][0], cost), (error, cost)]
    stairs.append((stairs[-1][0], top))
    x, y = [corner[0] for corner in stairs], [corner[1] for corner in stairs]
    axes.fill_between(x, y, bottom, color="#f2ba80", alpha=0.25, lw=0, zorder=0)
    axes.plot(x, y, color="#dd8028", lw=4, alpha=0.35, zorder=1, label="front")
    for method, own in methods(points).items():
        axes.plot([measure.of(p) for p in own], [p.cost.median for p in own], **_style(method, names))
    axes.set(xscale="log", yscale="log", xlim=(left, right), ylim=(bottom, top))
    axes.set_title(f"{episode}: {measure.name}", fontsize=9, loc="left")
    axes.set_xlabel(f"error ({measure.unit or 'relative'})", fontsize=8)
    axes.set_ylabel("CPU s per simulated s", fontsize=8)
    axes.tick_params(labelsize=7)
    axes.minorticks_off()  # over so many decades they say nothing, and take a third of the time to draw
    axes.grid(color="#e3e1d9", lw=0.5)
    axes.spines[["top", "right"]].set_visible(False)
    arrow = {"arrowstyle": "->", "color": "#80858d"}
    axes.annotate(
        "better", xy=(0.01, 0.02), xytext=(0.1, 0.12), xycoords="axes fraction", textcoords="axes fraction",
        fontsize=7, color="#80858d", arrowprops=arrow,
    )  # fmt: skip


def picture(system: System) -> Figure:
    """Error to the right, cost upwards, both logarithmic; an episode's kinds of error stand side by side."""
    panels = system.panels()
    groups = [[m for e, m in panels if e == episode] for episode in dict.fromkeys(e for e, _ in panels)]
    widest = max(map(len, groups))
    abreast = max(1, ACROSS // widest) if len(groups) > DOWN else 1  # episodes in a row
    down = math.ceil(len(groups) / abreast)
    figure = Figure(figsize=(3.9 * widest * abreast, 3.0 * down + 0.9), layout="constrained")
    names = list(methods(system.points))
    handles: dict[str, Any] = {}
    for k, episode in enumerate(dict.fromkeys(e for e, _ in panels)):
        for j, measure in enumerate(groups[k]):
            place = k // abreast * widest * abreast + k % abreast * widest + j + 1
            axes = figure.add_subplot(down, widest * abreast, place)
            _panel(axes, system, episode, measure, names)
            handles |= {label: handle for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    figure.suptitle(f"{system.title}: run time against error, one core", fontsize=11)
    figure.legend(list(handles.values()), list(handles), loc="outside lower center", ncols=4, fontsize=8, frameon=False)
    return figure
