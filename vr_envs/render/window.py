"""A window that shows pictures at a steady pace."""

from __future__ import annotations

import numpy as np

from vr_envs.render.canvas import import_pygame
from vr_envs.render.style import HEIGHT, WIDTH


class Window:
    """Opens at once. When its user closes it, it stays closed and later pictures are not shown."""

    def __init__(self, title: str, fps: float) -> None:
        """A window with a title that shows at most `fps` pictures per second."""
        self._pygame = import_pygame()
        self._pygame.display.init()
        self._pygame.display.set_caption(title)
        self._screen = self._pygame.display.set_mode((WIDTH, HEIGHT))
        self._clock = self._pygame.time.Clock()
        self._fps = fps

    def show(self, pixels: np.ndarray) -> None:
        """Show a picture (HEIGHT, WIDTH, 3) uint8, and wait until the next one is due."""
        if self._screen is None:
            return
        self._pygame.surfarray.blit_array(self._screen, pixels.swapaxes(0, 1))
        self._pygame.display.flip()
        self._clock.tick(self._fps)
        if self._pygame.event.get(self._pygame.QUIT):
            self.close()
        else:
            self._pygame.event.clear()

    def close(self) -> None:
        """Close the window, if it is open."""
        if self._screen is not None:
            self._screen = None
            self._pygame.display.quit()
