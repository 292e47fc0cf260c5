"""When a decelerating aircraft comes to a standstill: the first time at which its airspeed is 0, to rounding.

The acceleration is constant, or a lag with a limited rate on its way to the command. It is monotone in time either
way, so the airspeed is convex or concave, and Newton's iteration from the proper end converges to the root without
passing it. With a wind shear the airspeed is neither; there the search goes in steps that certainly hold no root.
"""

from __future__ import annotations

import math

from vr_envs.models.jit import kernel
from vr_envs.models.lag import clamped_lag, ramp_time
from vr_envs.models.root import converged, free_step
from vr_envs.models.shear import shear_bounds, shear_gain, shear_rate

NEVER = math.inf  # s, in place of a time
_ITERATIONS = 100  # Newton needs about 6, at a grazing minimum, where it halves the distance, about 50
# a march that long hovers at a fraction of 1e-6 m/s: a standstill for all that matters
_MOST_STEPS = 100_000


@kernel
def _time_of_lowest_speed(acceleration, command, duration, lags):  # type: ignore[no-untyped-def]
    """When a negative acceleration that rises to a positive command passes 0, at most `duration` [s]."""
    ramp = ramp_time(acceleration, command, lags.along, lags.jerk)
    time = -acceleration / lags.jerk
    if time > ramp:
        at_corner = acceleration + lags.jerk * ramp
        time = ramp + lags.along * math.log1p(-at_corner / command)
    return min(time, duration)


@kernel
def _stop_with_lag(speed, acceleration, command, duration, lags):  # type: ignore[no-untyped-def]
    if acceleration < 0.0 and command > acceleration:  # convex: Newton from the left
        lowest = duration
        if command > 0.0:
            lowest = _time_of_lowest_speed(acceleration, command, duration, lags)
        _, gain = clamped_lag(acceleration, command, lags.along, lags.jerk, lowest)
        if speed + gain > 0.0:
            return NEVER
        time = 0.0
        for _ in range(_ITERATIONS):
            slope, gain = clamped_lag(acceleration, command, lags.along, lags.jerk, time)
            if speed + gain <= 0.0 or slope >= 0.0:
                break
            later = min(lowest, time - (speed + gain) / slope)
            if later <= time:
                break
            time = later
        return time
    # concave: Newton from the right
    slope, gain = clamped_lag(acceleration, command, lags.along, lags.jerk, duration)
    if speed + gain >= 0.0:
        return NEVER
    time = duration
    for _ in range(_ITERATIONS):
        earlier = time - (speed + gain) / slope
        if earlier >= time:
            break
        time = max(0.0, earlier)
        slope, gain = clamped_lag(acceleration, command, lags.along, lags.jerk, time)
        if speed + gain >= 0.0 or slope >= 0.0:
            break
    return time


@kernel
def stop_time(state, acceleration, duration, lags):  # type: ignore[no-untyped-def]
    """First time [s] in [0, duration] at which the airspeed is 0 and falls, or NEVER; `acceleration` is commanded.

    An aircraft that stands and is not asked to accelerate stops at time 0.
    """
    if state.speed <= 0.0 and acceleration <= 0.0:
        if lags is None:
            return 0.0
        if state.acceleration <= 0.0:
            return 0.0
    if lags is None:
        return -state.speed / acceleration if state.speed + acceleration * duration < 0.0 else NEVER
    return _stop_with_lag(state.speed, state.acceleration, acceleration, duration, lags)


@kernel
def sheared_stop_time(state, vertical_speed, acceleration, turn_rate, turn_slew, duration, lags, shear):  # type: ignore[no-untyped-def]
    """As `stop_time`, where the shear changes the airspeed too: a march in steps that hold no root."""
    _, curvature = shear_bounds(state, vertical_speed, turn_rate, lags, shear)
    if lags is not None:
        curvature += lags.jerk
    time, sheared = 0.0, 0.0
    for _ in range(_MOST_STEPS):
        slope, gain = acceleration, acceleration * time
        if lags is not None:
            slope, gain = clamped_lag(state.acceleration, acceleration, lags.along, lags.jerk, time)
        slope += shear_rate(state, vertical_speed, turn_rate, turn_slew, time, lags, shear)
        speed = state.speed + gain + sheared
        if speed <= 0.0 and slope <= 0.0:
            return time
        step = free_step(max(0.0, speed), slope, curvature)
        if time + step >= duration:
            return NEVER
        if converged(time, step) and slope < 0.0:
            return time
        sheared += shear_gain(state, vertical_speed, turn_rate, turn_slew, time, time + step, lags, shear)
        time += step
    return time
