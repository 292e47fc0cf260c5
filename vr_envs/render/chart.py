"""Strip charts: what happened in the last seconds, the newest at the right edge."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from vr_envs.render.canvas import Box, Canvas, Point, View
from vr_envs.render.style import GREY, PANEL, RULE, SMALL, Colour


class History:
    """Values at increasing times, kept for `span` seconds; a time that goes back starts afresh."""

    def __init__(self, span: float) -> None:
        """Keep `span` seconds."""
        self.span = span
        self._rows: list[tuple[float, ...]] = []

    def add(self, time: float, *values: float) -> None:
        """Append the values at `time` (s), in place of those at the same time."""
        if self.starts_with(time):
            self._rows.clear()
        elif time == self._rows[-1][0]:
            self._rows.pop()
        self._rows.append((time, *values))
        while len(self._rows) > 1 and self._rows[1][0] <= time - self.span:
            self._rows.pop(0)

    def starts_with(self, time: float) -> bool:
        """Whether a row at `time` will be the first one."""
        return not self._rows or time < self._rows[-1][0]

    def last(self) -> tuple[float, ...]:
        """The newest row: time and values."""
        return self._rows[-1]

    def table(self) -> np.ndarray:
        """All rows, (n, 1 + number of values): time and values."""
        return np.array(self._rows)


def nice_step(size: float) -> float:
    """The smallest of 1, 2, 5 times a power of ten that is at least `size` > 0."""
    power = 10.0 ** math.floor(math.log10(size))
    return next(k * power for k in (1.0, 2.0, 5.0, 10.0) if k * power >= size * (1.0 - 1e-9))


def fitted(values: np.ndarray, least: float) -> tuple[float, float, float]:
    """(low, high, step) of an axis that holds `values`, is at least `least` long and ends on whole steps."""
    low, high = float(np.min(values)), float(np.max(values))
    short = max(0.0, least - (high - low))
    low, high = low - 0.5 * short, high + 0.5 * short
    step = nice_step((high - low) / 3.0)
    return step * math.floor(low / step), step * math.ceil(high / step), step


class Strip:
    """A frame with a time axis of `span` seconds that ends now, and a vertical axis from `low` to `high`."""

    def __init__(self, canvas: Canvas, box: Box, now: float, span: float, low: float, high: float) -> None:
        """Draw the frame."""
        self.canvas, self.frame = canvas, box
        self.view = View(
            (box.right - now * box.width / span, box.bottom + low * box.height / (high - low)),
            box.width / span,
            box.height / (high - low),
        )
        canvas.box(box, PANEL)

    def rule(self, value: float, label: str | None = None, colour: Colour = RULE) -> None:
        """A horizontal line at `value`, its label left of the frame."""
        _, y = self.view(0.0, value)
        self.canvas.line([(self.frame.left, y), (self.frame.right, y)], colour)
        if label is not None:
            self.canvas.text(label, (self.frame.left - 5, y), GREY, SMALL, "right")

    def points(self, times: Sequence[float] | np.ndarray, values: Sequence[float] | np.ndarray) -> list[Point]:
        """The points of a curve."""
        return [self.view(float(t), float(v)) for t, v in zip(times, values, strict=True)]

    def curve(
        self,
        times: Sequence[float] | np.ndarray,
        values: Sequence[float] | np.ndarray,
        colour: Colour,
        width: float = 1.5,
    ) -> None:
        """A curve, cut at the frame."""
        with self.canvas.inside(self.frame):
            self.canvas.line(self.points(times, values), colour, width)

    def dashes(self, times: Sequence[float] | np.ndarray, values: Sequence[float] | np.ndarray, colour: Colour) -> None:
        """A dashed curve, cut at the frame."""
        with self.canvas.inside(self.frame):
            self.canvas.dashes(self.points(times, values), colour, 1.6)
