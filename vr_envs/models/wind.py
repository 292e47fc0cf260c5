"""Steady wind: it moves the aircraft over the ground and leaves its airspeed alone.

A wind is given by the direction that it comes from: from `origin` at a speed W its velocity is
(x', z') = -W (sin origin, cos origin).
"""

from __future__ import annotations

import math

from vr_envs.models.jit import kernel


@kernel
def drift(state, origin, distance):  # type: ignore[no-untyped-def]
    """Move the ground track by what a wind from the direction `origin` [rad] blows along `distance` [m] of air."""
    state.x -= distance * math.sin(origin)
    state.z -= distance * math.cos(origin)
