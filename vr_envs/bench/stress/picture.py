"""Pictures of the trials: how long a step takes, and how deep a ball comes into its bar."""

from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from vr_envs.bench.stress.ball_walk import DEEPEST
from vr_envs.render.style import BLUE, GREY, ORANGE, PALE_BLUE, RED, Colour

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from vr_envs.bench.stress.measure import Finding

MARKS = (("p50", "o", BLUE), ("p99", "D", BLUE), ("p99.99", "s", GREY))


def _paint(colour: Colour) -> tuple[float, float, float]:
    red, green, blue = colour
    return red / 255.0, green / 255.0, blue / 255.0


def _frame(findings: Sequence[Finding], title: str, x: str) -> tuple[Figure, Axes]:
    """A picture with one line per trial, the first on top."""
    figure = Figure(figsize=(8.0, 1.4 + 0.3 * len(findings)), layout="constrained")
    axes = figure.subplots()
    axes.set_title(title, fontsize=10, loc="left", pad=20.0)
    axes.set_xlabel(x)
    axes.set_xscale("log")
    axes.set_yticks(range(len(findings)), [f.trial.name for f in findings], fontsize=8)
    axes.set_ylim(len(findings) - 0.5, -0.5)
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(axis="x", alpha=0.3)
    return figure, axes


def step_times(findings: Sequence[Finding]) -> Figure | None:
    """Time per step of every trial whose steps were timed: median, tail and the slowest of all."""
    timed = [f for f in findings if f.outcome.times.any()]
    if not timed:
        return None
    figure, axes = _frame(timed, "Time per step", "CPU time (us)")
    for y, finding in enumerate(timed):
        times = [1e6 * seconds for seconds in finding.quantiles]
        axes.plot([times[0], 1e6 * finding.seen], [y, y], color=_paint(PALE_BLUE), lw=5, zorder=1)
        for (name, marker, colour), time in zip(MARKS, times, strict=True):
            axes.plot(time, y, marker, color=_paint(colour), ms=5, label=name if y == 0 else None, zorder=3)
        axes.plot(1e6 * finding.seen, y, "x", color=_paint(RED), ms=7, label="slowest" if y == 0 else None, zorder=4)
        again = "slowest when run again" if y == 0 else None
        axes.plot(1e6 * finding.again, y, "X", color=_paint(ORANGE), ms=7, label=again, zorder=4)
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=5, borderaxespad=0.0, fontsize=8, frameon=False)
    return figure


def passages(findings: Sequence[Finding]) -> Figure | None:
    """The deepest passage of a ball through bar or lens in every trial that looks for one, and what is allowed."""
    deep = [f for f in findings if f.trial.figure.startswith("deepest")]
    if not deep:
        return None
    figure, axes = _frame(deep, "Deepest passage of the ball through bar or lens", "m")
    for y, finding in enumerate(deep):
        count = f"{finding.outcome.judged:.1e} {finding.trial.unit} searched"
        worst = max(finding.outcome.worst, 1e-21)
        axes.plot([1e-21, worst], [y, y], color=_paint(PALE_BLUE), lw=5, zorder=1)
        axes.plot(worst, y, "o", color=_paint(RED if finding.outcome.failures else BLUE), ms=6, zorder=3)
        axes.annotate(count, (worst, y), xytext=(8, 0), textcoords="offset points", va="center", fontsize=8)
    axes.axvline(DEEPEST, color=_paint(ORANGE), lw=2)
    axes.annotate("allowed", (DEEPEST, -0.5), xytext=(4, 4), textcoords="offset points", fontsize=8)
    axes.set_xlim(1e-21, 1e-10)
    return figure
