"""One episode in a compiled loop over control intervals, whatever moves the state.

So the exact kernel is timed as the loops of fixed steps are: without Python between the intervals.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from vr_envs.models.jit import kernel

STEPS = 20_000  # that one call of a compiled loop makes at least, so that the call itself costs nothing


def episode_loop(move: Any, look: Any) -> Any:
    """Kernel that drives an episode with `move(state, action, *arguments)` and writes what `look(state, row)` sees."""

    @kernel
    def drive(states, actions, seen, times, arguments):
        """From the state `states[1]`, in `states[0]`, so many times; `seen` has a row for every action."""
        for _ in range(times):
            states[0] = states[1]
            for k in range(actions.shape[0]):
                move(states[0], actions[k], *arguments)
                look(states[0], seen[k])

    return drive


def times_for(steps: int) -> int:
    """How often one call of a compiled loop goes through an episode of so many steps, for `STEPS` at least."""
    return math.ceil(STEPS / steps)


def driven(
    loop: Any, start: np.void, actions: np.ndarray, width: int, times: int, arguments: tuple[Any, ...]
) -> np.ndarray:
    """What a loop of `episode_loop` has seen of an episode driven `times` times, (intervals, width)."""
    states = np.array([start, start])
    seen = np.empty((len(actions), width))
    loop(states, actions, seen, times, arguments)
    return seen
