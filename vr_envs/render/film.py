"""From the states of an episode to the pictures of a film: which states are shown, and how fast."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

FRAMES_PER_SECOND = 30.0
SLOWEST = 10.0


def pace(dt: float, between: int = 1) -> tuple[int, float]:
    """Control intervals per picture, and pictures per second.

    Real time, but never below 10 pictures per second; with pictures in between, slow motion at 30 per second.
    """
    if between > 1:
        return 1, FRAMES_PER_SECOND
    stride = max(1, round(1.0 / (FRAMES_PER_SECOND * dt)))
    return stride, max(SLOWEST, 1.0 / (stride * dt))


def pictures(artist: Any, states: Iterable[np.void], stride: int, between: int) -> Iterator[np.ndarray]:
    """The first state, then every `stride`-th one and the last; or each with `between` - 1 pictures before it."""
    before = state = None
    step = shown = 0
    for step, state in enumerate(states):
        if before is not None and between > 1:
            yield from artist.frames(before, state, between)
            shown = step
        elif step % stride == 0:
            yield artist.draw(state)
            shown = step
        before = state
    if shown != step:
        yield artist.draw(state)
