"""The lecture's recurrence for the first-order aircraft (virtual environments, after Vince 1995), step by step.

Kept as printed, so that what the time step does can be seen: the way forward is v dt + a dt^2 / 2 with the old
acceleration and the old heading, and a step turns by atan(v_x / v), v_x the lateral speed, without dt. The commanded
turn rate w means v_x = v tan(w 1 s): at a step of 1 s the heading is that of the exact motion, at 0.1 s the aircraft
turns ten times as fast.
"""

from __future__ import annotations

import math

from vr_envs.models.clock import equal_steps
from vr_envs.models.jit import kernel

REFERENCE = 1.0  # s, the step at which the turn is as commanded


@kernel
def fly_in_steps(state, vertical_speed, acceleration, turn_rate, duration, track, textbook):  # type: ignore[no-untyped-def]
    """Move a state for `duration` [s] in equal steps of at most `textbook.step`, the commanded rates held.

    An aircraft without airspeed does not turn; its airspeed does not fall below 0.
    """
    steps = equal_steps(duration, textbook.step)
    dt = duration / steps
    slope = math.tan(turn_rate * REFERENCE)
    state.vertical_speed, state.turn_rate = vertical_speed, turn_rate
    for _ in range(steps):
        if track is not None:
            forward = state.speed * dt + 0.5 * state.acceleration * dt * dt
            state.x += forward * math.sin(state.heading)
            state.z += forward * math.cos(state.heading)
        state.altitude += vertical_speed * dt
        state.acceleration = acceleration
        state.speed += acceleration * dt
        if state.speed <= 0.0 and acceleration <= 0.0:
            state.speed, state.acceleration = 0.0, 0.0
        state.heading += math.atan2(state.speed * slope, state.speed)
