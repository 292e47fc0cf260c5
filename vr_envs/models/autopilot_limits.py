"""What an aircraft can do: the largest rates of its three channels, and the power that climb and speed share.

A command is a fraction of a limit. Limits that depend on the flight are those of the last renewal.
"""

from __future__ import annotations

from vr_envs.models.constants import G
from vr_envs.models.jit import kernel
from vr_envs.models.lanes import where

# m/s: below it the power that the energy limit shares out is that of this airspeed, so that g / v stays finite
SLOWEST = 0.01


@kernel
def climb_limit(altitude, params, envelope):  # type: ignore[no-untyped-def]
    """Largest climb rate [m/s] at an altitude [m]."""
    if envelope is None:
        return params.climb
    lapse = (params.climb - envelope.cruise_climb) / envelope.cruise_altitude
    return max(0.0, params.climb - lapse * altitude)


@kernel
def turn_limit(speed, params, envelope):  # type: ignore[no-untyped-def]
    """Largest turn rate [rad/s] at an airspeed [m/s]: the lesser of the standard rate and g tan(bank) / v."""
    if envelope is None:
        return params.turn
    return where(speed > 0.0, min(params.turn, envelope.lateral / speed), params.turn)


@kernel
def rate_limits(altitude, speed, params, envelope):  # type: ignore[no-untyped-def]
    """Largest falling and rising rates of the three channels at an altitude and true airspeed, all positive."""
    turn = turn_limit(speed, params, envelope)
    rising = (climb_limit(altitude, params, envelope), params.acceleration, turn)
    return (params.descent, params.deceleration, turn), rising


@kernel
def renew_limits(state, params, envelope, energy):  # type: ignore[no-untyped-def]
    """Take the limits of where the aircraft is now."""
    if envelope is not None:
        state.climb_limit = climb_limit(state.altitude, params, envelope)
        state.turn_limit = turn_limit(state.speed, params, envelope)
    if energy is not None:
        state.weight_per_speed = G / max(state.speed, SLOWEST)
    state.sheared = state.speed > 0.0
    state.time_to_refresh = params.refresh


@kernel
def within_power(vertical_speed, acceleration, weight_per_speed, climb, params, energy):  # type: ignore[no-untyped-def]
    """The acceleration [m/s^2] that the shared power leaves of a command beside a climb, which has priority.

    `weight_per_speed` is g / v [1/s], `climb` the largest climb rate [m/s].
    """
    acceleration = min(acceleration, weight_per_speed * (climb - vertical_speed))
    idle = weight_per_speed * (-energy.idle_sink - vertical_speed)
    return max(acceleration, min(params.acceleration, idle))


@kernel
def commanded_rates(state, action, params, envelope, energy):  # type: ignore[no-untyped-def]
    """Vertical speed, acceleration and turn rate that an action asks for, and the largest turn rate, as limited now."""
    climb, turn = params.climb, params.turn
    if envelope is not None:
        climb, turn = state.climb_limit, state.turn_limit
    vertical_speed = action[0] * where(action[0] > 0.0, climb, params.descent)
    acceleration = action[1] * where(action[1] > 0.0, params.acceleration, params.deceleration)
    if energy is not None:
        acceleration = within_power(vertical_speed, acceleration, state.weight_per_speed, climb, params, energy)
    return vertical_speed, acceleration, action[2] * turn, turn
