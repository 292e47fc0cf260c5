"""First-order lag with a rate limit, rate' = clamp((command - rate) / T, -slew, +slew), solved exactly.

While the rate is further than T slew from the command it ramps at the limit, from then on it closes in
exponentially; the distance to the command never changes sign, so there is one switch at most.
"""

from __future__ import annotations

import math

from vr_envs.models.elementary import exp
from vr_envs.models.jit import kernel


@kernel
def ramp_time(rate: float, command: float, time_constant: float, slew: float) -> float:
    """Time [s] for which the rate limit acts when the command is held; 0 if it does not act."""
    return max(0.0, abs(command - rate) / slew - time_constant)


@kernel
def clamped_lag(rate: float, command: float, time_constant: float, slew: float, duration: float) -> tuple[float, float]:
    """The rate after `duration` with the command held, and the integral of the rate over that time.

    Args:
        rate: value at the start.
        command: value that it tends to, in the same unit.
        time_constant: T [s], positive.
        slew: limit of the rate's derivative, unit of the rate per second, positive.
        duration: time [s], not negative.
    """
    gap = command - rate
    ramp = min(duration, ramp_time(rate, command, time_constant, slew))
    change = math.copysign(slew * ramp, gap)
    gap -= change  # distance to the command when the ramp is over
    closed = gap - gap * exp((ramp - duration) / time_constant)
    integral = command * duration - ramp * (gap + 0.5 * change) - time_constant * closed
    return rate + change + closed, integral
