"""Forward speed as a command: it goes there at the largest acceleration, and no faster (option `Cruise`)."""

from __future__ import annotations

import math

from vr_envs.models.jit import kernel


@kernel
def commanded_speed(command, cruise):
    """Speed [m/s] of a command in [-1, 1]."""
    return cruise.slowest + 0.5 * (command + 1.0) * (cruise.fastest - cruise.slowest)


@kernel
def acceleration_to(speed, target, cruise):
    """Acceleration [m/s^2] from `speed` to `target` [m/s], and the time [s] that it takes; (0, inf) if it is there."""
    if speed == target:
        return 0.0, math.inf
    return math.copysign(cruise.acceleration, target - speed), abs(target - speed) / cruise.acceleration


@kernel
def time_to_cover(distance, speed, acceleration):
    """Time [s] until `distance` [m] is covered at a constant acceleration; inf if the ride stands before."""
    square = speed * speed + 2.0 * acceleration * distance
    if square < 0.0:
        return math.inf
    return 2.0 * distance / (speed + math.sqrt(square))
