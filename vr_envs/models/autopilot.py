"""First-order aircraft under an autopilot: the lecture (virtual environments, after Vince 1995), solved exactly.

The aircraft is a point with altitude y, airspeed v and heading psi (from the z axis towards x). The command
sets vertical speed, acceleration and turn rate, each as a fraction of its limit; it is held over a control
interval, and the limits are those of the interval's start. So every channel is a constant rate (the lecture's
aircraft, which follows at once) or a first-order lag with a rate limit (`Lags`): closed forms, no time steps.
Positive: up, faster, turning from z towards x.
"""

from __future__ import annotations

import dataclasses
import math

from vr_envs.models.autopilot_options import G
from vr_envs.models.ground_track import turn_with_lags, uniform_turn
from vr_envs.models.jit import kernel
from vr_envs.models.lag import clamped_lag
from vr_envs.models.noise import normal_pair
from vr_envs.models.record import quantity
from vr_envs.models.wind import SCALE_LENGTH, gust_after, gust_integral


@dataclasses.dataclass(frozen=True)
class Params:
    """Constant limits of an airliner of about 100 t, where it operates, and the envelope that it must not leave.

    Rates: OpenAP, ADS-B statistics of B757-200 and A321. Accelerations: 2 ft/s^2, a civil comfort limit.
    """

    dt: float = quantity(1.0, "s", "control interval", low=1e-3, high=10.0)
    climb: float = quantity(13.0, "m/s", "largest climb rate, at sea level", low=0.1, high=100.0)
    descent: float = quantity(10.0, "m/s", "largest descent rate", low=0.1, high=100.0)
    acceleration: float = quantity(0.6, "m/s^2", "largest acceleration", low=0.01, high=10.0)
    deceleration: float = quantity(0.6, "m/s^2", "largest deceleration", low=0.01, high=10.0)
    turn: float = quantity(math.radians(3.0), "rad/s", "largest turn rate (the standard 3 deg/s)", low=1e-3, high=1.0)
    altitude_low: float = quantity(300.0, "m", "lowest altitude in operation", low=0.0, high=2e4)
    altitude_high: float = quantity(11000.0, "m", "highest altitude in operation", low=0.0, high=2e4)
    speed_low: float = quantity(75.0, "m/s", "lowest airspeed in operation", low=10.0, high=600.0)
    speed_high: float = quantity(250.0, "m/s", "highest airspeed in operation", low=10.0, high=600.0)
    stall_speed: float = quantity(60.0, "m/s", "airspeed below which the aircraft stalls", low=1.0, high=600.0)
    top_speed: float = quantity(300.0, "m/s", "airspeed above which it breaks up", low=1.0, high=600.0)
    ceiling: float = quantity(13000.0, "m", "altitude above which it cannot fly", low=1.0, high=2e4)


@dataclasses.dataclass(frozen=True)
class State:
    """Where the aircraft is, how it moves and the gusts it meets."""

    key: int = quantity(0, "", "key of the episode's random numbers", kind="key")
    steps: int = quantity(0, "", "control intervals since the start", low=0)
    x: float = quantity(0.0, "m", "ground track, x")
    z: float = quantity(0.0, "m", "ground track, z")
    altitude: float = quantity(0.0, "m", "altitude above the ground")
    speed: float = quantity(0.0, "m/s", "airspeed")
    heading: float = quantity(0.0, "rad", "heading in [-pi, pi), from z towards x")
    vertical_speed: float = quantity(0.0, "m/s", "climb rate through the air")
    acceleration: float = quantity(0.0, "m/s^2", "acceleration along the path")
    turn_rate: float = quantity(0.0, "rad/s", "turn rate")
    gust_vertical: float = quantity(0.0, "m/s", "rising air")
    gust_along: float = quantity(0.0, "m/s", "head wind of the gust, part of the airspeed")


@kernel
def wrap(angle: float) -> float:
    """The same direction in [-pi, pi)."""
    return angle - 2.0 * math.pi * math.floor((angle + math.pi) / (2.0 * math.pi))


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
    return min(params.turn, envelope.lateral / speed)


@kernel
def rate_limits(altitude, speed, params, envelope):  # type: ignore[no-untyped-def]
    """Largest falling and rising rates of the three channels at an altitude and airspeed, all positive."""
    turn = turn_limit(speed, params, envelope)
    rising = (climb_limit(altitude, params, envelope), params.acceleration, turn)
    return (params.descent, params.deceleration, turn), rising


@kernel
def fly(state, vertical_speed, acceleration, turn_rate, turn_slew, duration, lags, track):  # type: ignore[no-untyped-def]
    """Move a state in still air for `duration` [s] with the commanded rates held; exact, in any split of the time."""
    if lags is None:
        state.vertical_speed, state.acceleration, state.turn_rate = vertical_speed, acceleration, turn_rate
        rise, gain, turned = vertical_speed * duration, acceleration * duration, turn_rate * duration
        if track is not None:
            uniform_turn(state, duration)
    else:
        if track is not None:
            turn_with_lags(state, acceleration, turn_rate, turn_slew, duration, lags)
        state.vertical_speed, rise = clamped_lag(
            state.vertical_speed, vertical_speed, lags.vertical, lags.vertical_slew, duration
        )
        state.acceleration, gain = clamped_lag(state.acceleration, acceleration, lags.along, lags.jerk, duration)
        state.turn_rate, turned = clamped_lag(state.turn_rate, turn_rate, lags.turn, turn_slew, duration)
    state.altitude += rise
    state.speed += gain
    state.heading = wrap(state.heading + turned)


@kernel
def blow(state, time, dt, counter, turbulence):  # type: ignore[no-untyped-def]
    """Add what gusts of correlation time `time` do to altitude and airspeed in an interval `dt`, both in s.

    Uses the normal pairs `counter` and `counter` + 1 of the state's key.
    """
    decay = math.exp(-dt / time)
    end_vertical, end_along = normal_pair(state.key, counter)
    bridge, _ = normal_pair(state.key, counter + 1)
    vertical = gust_after(state.gust_vertical, decay, turbulence.sigma, end_vertical)
    along = gust_after(state.gust_along, decay, turbulence.sigma, end_along)
    state.altitude += gust_integral(state.gust_vertical, vertical, dt, time, decay, turbulence.sigma, bridge)
    state.speed += along - state.gust_along
    state.gust_vertical, state.gust_along = vertical, along


@kernel
def advance(state, action, params, envelope, energy, lags, atmosphere, wind, shear, turbulence, track, textbook):  # type: ignore[no-untyped-def]
    """Move one record over a control interval.

    `action`: vertical speed, acceleration and turn rate as fractions of their limits, each in [-1, 1].
    """
    falling, rising = rate_limits(state.altitude, state.speed, params, envelope)
    climb, turn = rising[0], rising[2]
    vertical_speed = action[0] * (climb if action[0] > 0.0 else falling[0])
    acceleration = action[1] * (rising[1] if action[1] > 0.0 else falling[1])
    if energy is not None:
        specific = G / state.speed
        acceleration = min(acceleration, specific * (climb - vertical_speed))
        acceleration = max(acceleration, specific * (-energy.idle_sink - vertical_speed))
    slew = 0.0
    if lags is not None:
        slew = turn / lags.roll_in
    speed = state.speed
    fly(state, vertical_speed, acceleration, action[2] * turn, slew, params.dt, lags, track)
    if turbulence is not None:
        blow(state, SCALE_LENGTH / speed, params.dt, 2 * state.steps, turbulence)


@kernel
def left_envelope(state, params):  # type: ignore[no-untyped-def]
    """Whether the aircraft has hit the ground, stalled, or left the envelope upwards."""
    return not (0.0 < state.altitude < params.ceiling and params.stall_speed < state.speed < params.top_speed)
