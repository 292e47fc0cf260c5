"""The look that the experiments' pictures share."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vr_envs.render.style import BLUE, GREY, INK, ORANGE, RED, Colour

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def paint(colour: Colour) -> tuple[float, float, float]:
    """A colour of the suite's style for matplotlib."""
    red, green, blue = colour
    return red / 255.0, green / 255.0, blue / 255.0


BALL, BAR, FOUND, FORMULA, FAINT = paint(BLUE), paint(ORANGE), paint(RED), paint(INK), paint(GREY)


def label(axes: Axes, title: str, x: str, y: str, legend: bool = False) -> None:
    """Title, axes with units, and above the axes a legend of what has a label."""
    axes.set_title(title, fontsize=10, loc="left")
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.spines[["top", "right"]].set_visible(False)
    if legend:
        axes.legend(
            fontsize=8, frameon=False, loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=6, borderaxespad=0.0
        )
