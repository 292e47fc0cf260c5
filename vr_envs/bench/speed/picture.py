"""Steps per second over rows, one panel a system, all forms of an environment in their colours."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vr_envs.bench.speed.arrays.namespace import NUMPY
from vr_envs.bench.speed.contestants import CARTPOLE, Case
from vr_envs.bench.speed.goals import GOAL_ROWS
from vr_envs.bench.speed.measure import FAMILIES, JAX, NATIVE, SCALAR, SYNC, Measured
from vr_envs.envs.registry import spec_of
from vr_envs.render.style import BLUE, GREY, GROUND, INK, ORANGE, PANEL, PAPER, RED, RULE, Colour

_COLOURS: dict[str, Colour] = {NATIVE: BLUE, NUMPY.name: ORANGE, JAX: RED, SYNC: GROUND, SCALAR: INK}
_DASHES = ("-", "--", ":", "-.")


def _rgb(colour: Colour) -> tuple[float, float, float]:
    red, green, blue = (value / 255.0 for value in colour)
    return red, green, blue


def picture(cases: Sequence[Case], measured: Measured) -> Figure:
    """Log-log; bars from the slowest to the fastest repeat; a star is a goal, a grey line CartPole."""
    systems: dict[str, list[Case]] = {}
    for case in cases:
        systems.setdefault(case.env_id, []).append(case)
    figure = Figure(figsize=(4.4 * len(systems), 4.6), layout="constrained", facecolor=_rgb(PAPER))
    axes = figure.subplots(1, len(systems), sharey=True, squeeze=False)[0]
    used: set[str] = set()
    for ax, (env_id, own) in zip(axes, systems.items(), strict=True):
        ax.set(xscale="log", yscale="log", xlabel="rows", title=spec_of(env_id).name, facecolor=_rgb(PANEL))
        rows = sorted({speed.rows for speed in measured.speeds})
        ax.set_xticks(rows, [str(count) for count in rows])
        ax.minorticks_off()
        ax.grid(True, which="major", color=_rgb(RULE), linewidth=0.8)
        ax.set_axisbelow(True)
        if (cartpole := measured.of(CARTPOLE, SCALAR, 1)) is not None:
            ax.axhline(cartpole.median, color=_rgb(GREY), linewidth=0.8)
            if ax is axes[-1]:
                ax.annotate(
                    CARTPOLE, (1.0, cartpole.median), xycoords=("axes fraction", "data"), xytext=(-3, 2),
                    textcoords="offset points", ha="right", color=_rgb(GREY), fontsize=8,
                )  # fmt: skip
        for case, dash in zip(own, _DASHES, strict=False):
            for family in FAMILIES:
                points = [s for s in measured.speeds if (s.case, s.family) == (case.label, family)]
                if points:
                    used.add(family)
                    low, middle, high = zip(*(s.spread for s in points), strict=True)
                    spans = [[m - a for m, a in zip(middle, low, strict=True)],
                             [b - m for m, b in zip(middle, high, strict=True)]]  # fmt: skip
                    ax.errorbar(
                        [s.rows for s in points], middle, spans, color=_rgb(_COLOURS[family]), linestyle=dash,
                        marker="o" if family != SCALAR else "D", markersize=4, linewidth=1.6, capsize=2,
                    )  # fmt: skip
            if case.goal is not None:
                ax.plot(GOAL_ROWS, case.goal, marker="*", markersize=11, color="none", markeredgecolor=_rgb(BLUE))
        lines = [
            Line2D([], [], color=_rgb(INK), linestyle=dash, label=case.label.removeprefix(spec_of(env_id).name).strip())
            for case, dash in zip(own, _DASHES, strict=False)
        ]
        ax.legend(handles=lines, fontsize=8, frameon=False, loc="upper left")
    axes[0].set_ylabel("environment steps per CPU second")
    handles = [
        Line2D([], [], color=_rgb(_COLOURS[name]), marker="D" if name == SCALAR else "o", markersize=4, label=name)
        for name in FAMILIES
        if name in used
    ]
    star = Line2D([], [], color="none", marker="*", markersize=11, markeredgecolor=_rgb(BLUE), label="goal")
    figure.legend(handles=[*handles, star], loc="outside lower center", ncols=6, fontsize=9, frameon=False)
    return figure
