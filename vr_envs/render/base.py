"""What draws a task's states: a canvas, and the window in which it may be shown."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from vr_envs.render.canvas import Canvas
from vr_envs.render.style import GREY, INK, MARGIN, SMALL, TITLE, WIDTH
from vr_envs.render.window import Window

if TYPE_CHECKING:
    from vr_envs.envs.scene import Scene

MODES = ("rgb_array", "human")


class Painter:
    """Draws state records one after another and remembers what it needs of the earlier ones.

    Subclasses set `TITLE` and define `paint`. The first picture of a painter depends on the state alone.
    """

    TITLE: ClassVar[str]

    def __init__(self, scene: Scene, render_mode: str) -> None:
        """`render_mode` is "rgb_array" or "human" (a window).

        Raises:
            ValueError: another mode.
            ImportError: a package for pictures is missing; it says what to install.
        """
        if render_mode not in MODES:
            raise ValueError(f"render_mode = {render_mode!r}; choose one of {', '.join(MODES)}")
        self.scene = scene
        self.params, options = scene.records()
        self.options = dict(zip(scene.options, options, strict=True))
        self.canvas = Canvas()
        self._window: Window | None = None
        if render_mode == "human":
            from vr_envs.envs.scalar import ScalarEnv

            self._window = Window(self.TITLE, ScalarEnv.metadata["render_fps"])

    def paint(self, state: np.void) -> None:
        """Draw a state on the blank canvas."""
        raise NotImplementedError

    def draw(self, state: np.void) -> np.ndarray | None:
        """A picture of `state`: (height, width, 3) uint8, or None when it goes to the window."""
        self.canvas.clear()
        self.paint(state)
        return self.deliver()

    def deliver(self) -> np.ndarray | None:
        """What is on the canvas: as an array, or to the window."""
        pixels = self.canvas.pixels()
        if self._window is None:
            return pixels
        self._window.show(pixels)
        return None

    def heading(self, right: str) -> None:
        """The title line: the system and its scene, and `right` at the right margin."""
        self.canvas.text(self.TITLE, (MARGIN, 20), INK, TITLE)
        label = self.scene.label if len(self.scene.label) <= 40 else f"{self.scene.name} with changes"
        self.canvas.text(f"scene {label}", (0.5 * WIDTH, 21), GREY, SMALL, "centre")
        self.canvas.text(right, (WIDTH - MARGIN, 21), INK, align="right")

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._window is not None:
            self._window.close()
