"""Wind shear: a wind W(y) that grows linearly with altitude, and what it does to airspeed and ground track.

The velocity over the ground is the airspeed's vector plus the wind. Commands set the acceleration of the aircraft
itself, so v' = a - dW/dy . e(psi) v_y with e the direction of flight: with gradient k and the wind from `origin`,
v' = a + k v_y cos(psi - origin). Climbing into a wind that grows adds airspeed, as does descending out of a tail wind.
The component across the path is left to the turn control, which holds the turn rate. Rising air carries its own
wind along, so the climb that counts is the one through the air, without gusts.

At low speed: an aircraft that has come to a standstill in the air is no longer pushed by the shear (`sheared` in the
state); from the next renewal of the limits at which it moves, it is again. The wind carries it all the time.

Right-hand sides depend on time alone: with rates that follow at once there are closed forms, with lagging ones
panels of `quadrature`; the track's integral over the airspeed's integral needs its running integral.
"""

from __future__ import annotations

import math

from vr_envs.models.elementary import cos_sin
from vr_envs.models.ground_track import spherical_bessel
from vr_envs.models.jit import kernel
from vr_envs.models.lag import clamped_lag, ramp_time
from vr_envs.models.quadrature import integral, points, running_integral
from vr_envs.models.wind import drift


@kernel
def shear_rate(state, vertical_speed, turn_rate, turn_slew, time, lags, shear):  # type: ignore[no-untyped-def]
    """Change [m/s^2] of the airspeed that the shear causes `time` [s] after the state, with the commands held."""
    climb, turned = vertical_speed, turn_rate * time
    if lags is not None:
        climb, _ = clamped_lag(state.vertical_speed, vertical_speed, lags.vertical, lags.vertical_slew, time)
        _, turned = clamped_lag(state.turn_rate, turn_rate, lags.turn, turn_slew, time)
    cosine, _ = cos_sin(state.heading + turned - shear.origin)
    return state.sheared * shear.gradient * climb * cosine


@kernel
def shear_bounds(state, vertical_speed, turn_rate, lags, shear):  # type: ignore[no-untyped-def]
    """Bounds of `shear_rate` [m/s^2] and of its rate of change [m/s^3] while the commands are held."""
    climb, turn, bend = abs(vertical_speed), abs(turn_rate), 0.0
    if lags is not None:
        climb, turn = max(climb, abs(state.vertical_speed)), max(turn, abs(state.turn_rate))
        bend = lags.vertical_slew
    return shear.gradient * climb, shear.gradient * (bend + climb * turn)


@kernel
def _next_corner(begin, end, first, second, third):  # type: ignore[no-untyped-def]
    """The earliest of three times that is later than `begin`, or `end`."""
    for corner in (first, second, third):
        if begin < corner < end:
            end = corner
    return end


@kernel
def shear_gain(state, vertical_speed, turn_rate, turn_slew, begin, end, lags, shear):  # type: ignore[no-untyped-def]
    """Airspeed [m/s] that the shear adds from `begin` to `end` [s] after the state, with the commands held."""
    if lags is None:
        half = 0.5 * (end - begin)
        j0, _ = spherical_bessel(turn_rate * half)
        middle = state.heading + turn_rate * (begin + half) - shear.origin
        return 2.0 * half * j0 * state.sheared * shear.gradient * vertical_speed * math.cos(middle)
    climbing = ramp_time(state.vertical_speed, vertical_speed, lags.vertical, lags.vertical_slew)
    turning = ramp_time(state.turn_rate, turn_rate, lags.turn, turn_slew)
    pace = 1.0 / lags.vertical + 1.0 / lags.turn + max(abs(state.turn_rate), abs(turn_rate))
    gain = 0.0
    while begin < end:
        corner = _next_corner(begin, end, climbing, turning, turning)
        panels = math.ceil((corner - begin) * pace)
        length = (corner - begin) / panels
        for panel in range(panels):
            time = points(begin + length * panel, length)
            gain += integral(shear_rate(state, vertical_speed, turn_rate, turn_slew, time, lags, shear), length)
        begin = corner
    return gain


@kernel
def _excess_over_sine(x: float) -> float:
    """(x - sin x) / x^2, regular at 0."""
    s = x * x
    if s < 0.25:
        return x / 6 * (1 - s / 20 * (1 - s / 42 * (1 - s / 72 * (1 - s / 110 * (1 - s / 156 * (1 - s / 210))))))
    return (x - math.sin(x)) / s


@kernel
def uniform_track_in_shear(state, duration, shear):  # type: ignore[no-untyped-def]
    """What a shear adds to the ground track over `duration` [s] with the state's rates constant.

    The airspeed gained, k v_y times the integral of cos(psi - origin), moves the aircraft on along its heading, and
    the wind itself carries it. The double integral over s < t of cos(psi_s - origin) (sin, cos)(psi_t) splits into
    a part with the sum of the two headings, half of a square, and one with their difference, a single integral.
    """
    area = 0.5 * duration * duration
    q = 0.5 * state.turn_rate * duration
    j0, _ = spherical_bessel(q)
    square = 0.5 * j0 * j0 * area
    excess = _excess_over_sine(2.0 * q) * area
    both = 2.0 * (state.heading + q) - shear.origin
    sine, cosine = math.sin(shear.origin), math.cos(shear.origin)
    gained = state.sheared * shear.gradient * state.vertical_speed
    state.x += gained * (square * (math.sin(both) + sine) + excess * cosine)
    state.z += gained * (square * (math.cos(both) + cosine) - excess * sine)
    drift(state, shear.origin, shear.gradient * (state.altitude * duration + state.vertical_speed * area))


@kernel
def _instant(state, commands, time, lags, growth):  # type: ignore[no-untyped-def]
    """Change of the airspeed by the shear, sine and cosine of the heading, airspeed and height gained at a time.

    `growth`: the head wind's growth with altitude, per sine and per cosine of the heading [1/s].
    """
    vertical_speed, acceleration, turn_rate, turn_slew = commands
    climb, rise = clamped_lag(state.vertical_speed, vertical_speed, lags.vertical, lags.vertical_slew, time)
    _, gain = clamped_lag(state.acceleration, acceleration, lags.along, lags.jerk, time)
    _, turned = clamped_lag(state.turn_rate, turn_rate, lags.turn, turn_slew, time)
    cosine, sine = cos_sin(state.heading + turned)
    return climb * (sine * growth[0] + cosine * growth[1]), sine, cosine, gain, rise


@kernel
def lagging_track_in_shear(state, vertical_speed, acceleration, turn_rate, turn_slew, duration, lags, shear):  # type: ignore[no-untyped-def]
    """Move the ground track over `duration` [s] while the rates follow the commands; return the airspeed gained.

    That is `shear_gain`; the track contains the way through the air and the wind of the shear.
    """
    climbing = ramp_time(state.vertical_speed, vertical_speed, lags.vertical, lags.vertical_slew)
    speeding = ramp_time(state.acceleration, acceleration, lags.along, lags.jerk)
    turning = ramp_time(state.turn_rate, turn_rate, lags.turn, turn_slew)
    decays = 1.0 / lags.vertical + 1.0 / lags.along + 1.0 / lags.turn
    pace = decays + max(abs(state.turn_rate), abs(turn_rate))
    ground_speed = state.speed - state.gust_along
    commands = (vertical_speed, acceleration, turn_rate, turn_slew)
    gradient = state.sheared * shear.gradient
    growth = (gradient * math.sin(shear.origin), gradient * math.cos(shear.origin))
    begin, gained, air = 0.0, 0.0, 0.0
    while begin < duration:
        corner = _next_corner(begin, duration, climbing, speeding, turning)
        panels = math.ceil((corner - begin) * pace)
        length = (corner - begin) / panels
        for panel in range(panels):
            time = points(begin + length * panel, length)
            rate, sine, cosine, gain, rise = _instant(state, commands, time, lags, growth)
            airspeed = ground_speed + gain + (gained + running_integral(rate, length))
            state.x += integral(airspeed * sine, length)
            state.z += integral(airspeed * cosine, length)
            air += integral(state.altitude + rise, length)
            gained += integral(rate, length)
        begin = corner
    drift(state, shear.origin, shear.gradient * air)
    return gained
