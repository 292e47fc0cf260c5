"""The look that the experiments' pictures share."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

from vr_envs.render.style import BLUE, GREY, INK, ORANGE, RED, Colour

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

LEGEND: dict[str, Any] = {"fontsize": 8, "frameon": False, "columnspacing": 1.5}


def paint(colour: Colour) -> tuple[float, float, float]:
    """A colour of the suite's style for matplotlib."""
    red, green, blue = colour
    return red / 255.0, green / 255.0, blue / 255.0


BALL, BAR, FOUND, FORMULA, FAINT = paint(BLUE), paint(ORANGE), paint(RED), paint(INK), paint(GREY)


def label(axes: Axes, title: str, x: str, y: str, legend: bool = False) -> None:
    """Title, names of the axes as "quantity (unit)", and between title and axes a legend of what has a label."""
    axes.set_title(title, fontsize=10, loc="left", pad=20.0 if legend else 6.0)
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.spines[["top", "right"]].set_visible(False)
    if legend:
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=6, borderaxespad=0.0, **LEGEND)


def shared_legend(figure: Figure | SubFigure, handles: Sequence[Artist], names: Sequence[str]) -> None:
    """One legend under all panels of a picture."""
    figure.legend(handles, names, loc="outside lower center", ncols=len(names), **LEGEND)


def plain_log(axes: Axes, direction: Literal["x", "y"], ticks: Sequence[float]) -> None:
    """A logarithmic axis with these ticks alone, written out."""
    axes.set(**{f"{direction}scale": "log"})
    axis = axes.xaxis if direction == "x" else axes.yaxis
    axis.set_ticks(ticks, [f"{tick:g}" for tick in ticks])
    axis.set_ticks([], minor=True)
