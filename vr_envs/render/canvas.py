"""A picture in points, drawn larger with pygame-ce and scaled down, so that every edge is smooth."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vr_envs.render.extras import extra
from vr_envs.render.style import BODY, HEIGHT, INK, PAPER, WIDTH, Colour

Point = tuple[float, float]
OVERSAMPLE = 4


class Box(NamedTuple):
    """A rectangle in points, y down."""

    left: float
    top: float
    width: float
    height: float

    @property
    def right(self) -> float:
        """Right edge."""
        return self.left + self.width

    @property
    def bottom(self) -> float:
        """Bottom edge."""
        return self.top + self.height

    @property
    def centre(self) -> Point:
        """Middle."""
        return self.left + 0.5 * self.width, self.top + 0.5 * self.height


class View(NamedTuple):
    """World (x right, y up) to points: the world's origin lies at `origin`; scales in points per world unit."""

    origin: Point
    x_scale: float
    y_scale: float

    def __call__(self, x: float, y: float) -> Point:
        """The point of (x, y)."""
        return self.origin[0] + self.x_scale * x, self.origin[1] - self.y_scale * y


def import_pygame() -> Any:
    """pygame without its greeting."""
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    return extra("pygame")


def _thick(a: Point, b: Point, half: float) -> list[Point]:
    """Corners of the line from a to b, `2 half` wide."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    length = math.hypot(dx, dy)
    if length == 0.0:
        return []
    nx, ny = -dy / length * half, dx / length * half
    return [(a[0] + nx, a[1] + ny), (b[0] + nx, b[1] + ny), (b[0] - nx, b[1] - ny), (a[0] - nx, a[1] - ny)]


class Canvas:
    """Shapes and text in points, the origin at the top left; y points down."""

    def __init__(self) -> None:
        """A blank picture of WIDTH x HEIGHT points; needs no display.

        Raises:
            ImportError: pygame-ce or matplotlib is missing.
        """
        self._pygame = import_pygame()
        self._pygame.font.init()
        # matplotlib's own font: the same letters on every machine
        self._font_file = str(Path(extra("matplotlib").get_data_path(), "fonts", "ttf", "DejaVuSans.ttf"))
        self._fonts: dict[int, Any] = {}
        self._surface = self._pygame.Surface((WIDTH * OVERSAMPLE, HEIGHT * OVERSAMPLE), depth=32)
        self.clear()

    def clear(self) -> None:
        """Wipe the picture."""
        self._surface.fill(PAPER)

    @contextmanager
    def inside(self, box: Box) -> Iterator[None]:
        """What is drawn meanwhile shows inside `box` only."""
        self._surface.set_clip(self._pygame.Rect(*(round(v * OVERSAMPLE) for v in box)))
        yield
        self._surface.set_clip(None)

    def polygon(self, points: Sequence[Point], colour: Colour) -> None:
        """A filled polygon."""
        self._pygame.draw.polygon(self._surface, colour, [(x * OVERSAMPLE, y * OVERSAMPLE) for x, y in points])

    def box(self, box: Box, colour: Colour, radius: float = 0.0) -> None:
        """A filled rectangle, its corners rounded by `radius`."""
        rectangle = self._pygame.Rect(*(round(v * OVERSAMPLE) for v in box))
        self._pygame.draw.rect(self._surface, colour, rectangle, border_radius=round(radius * OVERSAMPLE))

    def disc(self, centre: Point, radius: float, colour: Colour) -> None:
        """A filled circle."""
        at = (centre[0] * OVERSAMPLE, centre[1] * OVERSAMPLE)
        self._pygame.draw.circle(self._surface, colour, at, radius * OVERSAMPLE)

    def ring(self, centre: Point, radius: float, colour: Colour, width: float = 1.0) -> None:
        """A circle line, `width` wide, centred on the radius."""
        at = (centre[0] * OVERSAMPLE, centre[1] * OVERSAMPLE)
        outer, thickness = (radius + 0.5 * width) * OVERSAMPLE, max(1, round(width * OVERSAMPLE))
        self._pygame.draw.circle(self._surface, colour, at, outer, thickness)

    def line(self, points: Sequence[Point], colour: Colour, width: float = 1.0) -> None:
        """A line through points, round at its corners and ends."""
        for a, b in zip(points[:-1], points[1:], strict=True):
            corners = _thick(a, b, 0.5 * width)
            if corners:
                self.polygon(corners, colour)
        if width > 1.0:
            for point in points:
                self.disc(point, 0.5 * width, colour)

    def dashes(
        self, points: Sequence[Point], colour: Colour, width: float = 1.0, dash: float = 5.0, gap: float = 3.0
    ) -> None:
        """A dashed line through points; the pattern runs on round corners."""
        place = 0.0
        for a, b in zip(points[:-1], points[1:], strict=True):
            length = math.hypot(b[0] - a[0], b[1] - a[1])
            at = 0.0
            while at < length:
                phase = (place + at) % (dash + gap)
                end = min(length, at + (dash if phase < dash else dash + gap) - phase)
                if phase < dash:
                    ends = [(a[0] + (b[0] - a[0]) * s / length, a[1] + (b[1] - a[1]) * s / length) for s in (at, end)]
                    self.polygon(_thick(ends[0], ends[1], 0.5 * width), colour)
                # the smallest advance keeps a rounded phase from stalling the loop
                at = max(end, at + 1e-6)
            place += length

    def arrow(self, tail: Point, tip: Point, colour: Colour, width: float = 2.0, head: float = 6.0) -> None:
        """A line with a head at its tip; a line shorter than the head is all head."""
        dx, dy = tip[0] - tail[0], tip[1] - tail[1]
        length = math.hypot(dx, dy)
        if length < 1e-9:
            return
        head = min(head, length)
        ux, uy = dx / length, dy / length
        base = (tip[0] - head * ux, tip[1] - head * uy)
        self.line([tail, base], colour, width)
        side = 0.5 * head
        self.polygon(
            [tip, (base[0] - side * uy, base[1] + side * ux), (base[0] + side * uy, base[1] - side * ux)], colour
        )

    def text(self, string: str, at: Point, colour: Colour = INK, size: int = BODY, align: str = "left") -> None:
        """Text whose middle height lies at `at`; `align` says which part of it lies there: left, centre or right."""
        if size not in self._fonts:
            self._fonts[size] = self._pygame.font.Font(self._font_file, size * OVERSAMPLE)
        picture = self._fonts[size].render(string, True, colour)
        x = at[0] * OVERSAMPLE - {"left": 0.0, "centre": 0.5, "right": 1.0}[align] * picture.get_width()
        self._surface.blit(picture, (round(x), round(at[1] * OVERSAMPLE - 0.5 * picture.get_height())))

    def pixels(self) -> np.ndarray:
        """A fresh array (HEIGHT, WIDTH, 3) uint8 of the picture."""
        small = self._pygame.transform.smoothscale(self._surface, (WIDTH, HEIGHT))
        return np.ascontiguousarray(self._pygame.surfarray.array3d(small).swapaxes(0, 1))
