"""First-order aircraft under an autopilot: the lecture (virtual environments, after Vince 1995), solved exactly.

The aircraft is a point with altitude y, true airspeed v and heading psi (from the z axis towards x). The command
sets vertical speed, acceleration and turn rate, each as a fraction of its limit; it is held over a control
interval. Limits that depend on the flight are renewed at fixed instants, `Params.refresh` apart as in a flight
computer, and held in the state in between. So every channel is a constant rate (the lecture's aircraft, which
follows at once) or a first-order lag with a rate limit (`Lags`): closed forms, no time steps, and the same motion
however the time is split into intervals. Positive: up, faster, turning from z towards x.

The airspeed is never negative: an aircraft whose deceleration brings it to 0 stands, with no acceleration, until
one is commanded. It may turn and climb there.
"""

from __future__ import annotations

import dataclasses
import math

from vr_envs.models.atmosphere import airspeed, sound_speed
from vr_envs.models.autopilot_limits import commanded_rates, renew_limits
from vr_envs.models.autopilot_textbook import fly_in_steps
from vr_envs.models.clock import MEET, left_after, piece_of, to_next_tick
from vr_envs.models.ground_track import turn_with_lags, uniform_turn
from vr_envs.models.jit import kernel
from vr_envs.models.lag import clamped_lag
from vr_envs.models.lanes import floor, negate
from vr_envs.models.record import quantity
from vr_envs.models.shear import lagging_track_in_shear, shear_bounds, shear_gain, uniform_track_in_shear
from vr_envs.models.standstill import sheared_stop_time, stop_time
from vr_envs.models.turbulence import blow
from vr_envs.models.wind import drift


@dataclasses.dataclass(frozen=True)
class Params:
    """Constant limits of an airliner of about 100 t, where it operates, and the envelope that it must not leave.

    Rates: OpenAP, ADS-B statistics of B757-200 and A321. Accelerations: 2 ft/s^2, a civil comfort limit.
    """

    dt: float = quantity(1.0, "s", "control interval", low=1e-3, high=3600.0)
    refresh: float = quantity(
        1.0, "s", "time between renewals of the limits that depend on the flight", low=1e-3, high=10.0
    )
    climb: float = quantity(13.0, "m/s", "largest climb rate, at sea level", low=0.1, high=100.0)
    descent: float = quantity(10.0, "m/s", "largest descent rate", low=0.1, high=100.0)
    acceleration: float = quantity(0.6, "m/s^2", "largest acceleration", low=0.01, high=10.0)
    deceleration: float = quantity(0.6, "m/s^2", "largest deceleration", low=0.01, high=10.0)
    turn: float = quantity(math.radians(3.0), "rad/s", "largest turn rate (the standard 3 deg/s)", low=1e-3, high=1.0)
    altitude_low: float = quantity(300.0, "m", "lowest altitude in operation", low=1.0, high=2e4)
    altitude_high: float = quantity(11000.0, "m", "highest altitude in operation", low=0.0, high=2e4)
    speed_low: float = quantity(75.0, "m/s", "lowest airspeed in operation", low=10.0, high=600.0)
    speed_high: float = quantity(250.0, "m/s", "highest airspeed in operation", low=10.0, high=600.0)
    stall_speed: float = quantity(60.0, "m/s", "airspeed below which it stalls; 0: never", low=0.0, high=600.0)
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
    speed: float = quantity(0.0, "m/s", "true airspeed", low=0.0)
    heading: float = quantity(0.0, "rad", "heading in [-pi, pi), from z towards x")
    vertical_speed: float = quantity(0.0, "m/s", "climb rate through the air")
    acceleration: float = quantity(0.0, "m/s^2", "acceleration along the path")
    turn_rate: float = quantity(0.0, "rad/s", "turn rate", low=-2.0, high=2.0)
    time_to_refresh: float = quantity(0.0, "s", "time to the next renewal of the limits; 0: now", low=0.0)
    owed: float = quantity(0.0, "s", "by which the last interval ended early", low=-2.0 * MEET, high=2.0 * MEET)
    climb_limit: float = quantity(0.0, "m/s", "largest climb rate at the last renewal", low=0.0)
    turn_limit: float = quantity(0.0, "rad/s", "largest turn rate at the last renewal", low=0.0)
    weight_per_speed: float = quantity(0.0, "1/s", "g / v at the last renewal, m/s^2 per m/s of climb", low=0.0)
    sheared: bool = quantity(False, "", "the shear changes the airspeed", low=0, high=1)
    gust_along: float = quantity(0.0, "m/s", "head wind of the gust, part of the airspeed")
    headwind: float = quantity(0.0, "", "gust along the path over its standard deviation")
    updraught: float = quantity(0.0, "", "p1 of the vertical gust, as in turbulence.py")
    updraught_lag: float = quantity(0.0, "", "p2 of the vertical gust")
    crosswind: float = quantity(0.0, "", "p1 of the gust across the path")
    crosswind_lag: float = quantity(0.0, "", "p2 of the gust across the path")


@kernel
def wrap(angle: float) -> float:
    """The same direction in [-pi, pi)."""
    return angle - 2.0 * math.pi * floor((angle + math.pi) / (2.0 * math.pi))


@kernel
def _renewing(envelope, energy, shear):  # type: ignore[no-untyped-def]
    """Whether anything is renewed at fixed instants; a constant to the compiler."""
    if envelope is not None:
        return True
    if energy is not None:
        return True
    return shear is not None


@kernel
def _glide(state, vertical_speed, acceleration, turn_rate, turn_slew, duration, lags, wind, shear, track):  # type: ignore[no-untyped-def]
    """Move a state that does not come to a standstill; exact, in any split of the time."""
    sheared = 0.0
    if lags is None:
        state.vertical_speed, state.acceleration, state.turn_rate = vertical_speed, acceleration, turn_rate
        rise, gain, turned = vertical_speed * duration, acceleration * duration, turn_rate * duration
        if shear is not None:
            sheared = shear_gain(state, vertical_speed, turn_rate, turn_slew, 0.0, duration, lags, shear)
        if track is not None:
            uniform_turn(state, duration)
            if shear is not None:
                uniform_track_in_shear(state, duration, shear)
    else:
        if shear is None:
            if track is not None:
                turn_with_lags(state, acceleration, turn_rate, turn_slew, duration, lags)
        else:
            if track is None:
                sheared = shear_gain(state, vertical_speed, turn_rate, turn_slew, 0.0, duration, lags, shear)
            else:
                sheared = lagging_track_in_shear(
                    state, vertical_speed, acceleration, turn_rate, turn_slew, duration, lags, shear
                )
        state.vertical_speed, rise = clamped_lag(
            state.vertical_speed, vertical_speed, lags.vertical, lags.vertical_slew, duration
        )
        state.acceleration, gain = clamped_lag(state.acceleration, acceleration, lags.along, lags.jerk, duration)
        state.turn_rate, turned = clamped_lag(state.turn_rate, turn_rate, lags.turn, turn_slew, duration)
    if wind is not None:
        if track is not None:
            drift(state, wind.origin, wind.speed * duration)
    state.altitude += rise
    state.speed = max(0.0, state.speed + (gain + sheared))  # rounding, where it does not come to a standstill
    state.heading = wrap(state.heading + turned)


@kernel
def _lowest_speed(state, vertical_speed, acceleration, turn_rate, duration, lags, shear):  # type: ignore[no-untyped-def]
    """A lower bound of the airspeed [m/s] over `duration`, without a standstill."""
    lowest = min(0.0, acceleration)
    if lags is not None:
        lowest = min(lowest, state.acceleration)
    if shear is not None:
        lowest -= shear_bounds(state, vertical_speed, turn_rate, lags, shear)[0]
    return state.speed + lowest * duration


@kernel
def fly(state, vertical_speed, acceleration, turn_rate, turn_slew, duration, lags, wind, shear, track):  # type: ignore[no-untyped-def]
    """Move a state without gusts for `duration` [s], the commanded rates held; exact, in any split of the time."""
    if _lowest_speed(state, vertical_speed, acceleration, turn_rate, duration, lags, shear) < 0.0:
        stop = stop_time(state, acceleration, duration, lags)
        if shear is not None:
            if state.sheared:
                stop = sheared_stop_time(
                    state, vertical_speed, acceleration, turn_rate, turn_slew, duration, lags, shear
                )
        if stop <= duration:
            _glide(state, vertical_speed, acceleration, turn_rate, turn_slew, stop, lags, wind, shear, track)
            state.speed, state.acceleration, state.sheared = 0.0, 0.0, False
            duration -= stop
            acceleration = max(0.0, acceleration)
    _glide(state, vertical_speed, acceleration, turn_rate, turn_slew, duration, lags, wind, shear, track)


@kernel
def _roll_in(turn, lags):  # type: ignore[no-untyped-def]
    """Largest rate of change of the turn rate [rad/s^2], 0 where it follows at once; `turn`: the largest turn rate."""
    if lags is None:
        return 0.0
    return turn / lags.roll_in


@kernel
def _hold(state, action, params, duration, envelope, energy, lags, wind, shear, track, textbook):  # type: ignore[no-untyped-def]
    """Fly for `duration` [s] as commanded, with the limits as they are."""
    vertical_speed, acceleration, turn_rate, turn = commanded_rates(state, action, params, envelope, energy)
    if textbook is None:
        slew = _roll_in(turn, lags)
        fly(state, vertical_speed, acceleration, turn_rate, slew, duration, lags, wind, shear, track)
    else:
        fly_in_steps(state, vertical_speed, acceleration, turn_rate, duration, track, textbook)
        state.heading = wrap(state.heading)


@kernel
def even(state, params, envelope, energy, shear, textbook):  # type: ignore[no-untyped-def]
    """Whether the next control interval is flown in one piece: limits renewed at its ends alone, no standstill."""
    if shear is not None or textbook is not None:
        return False
    moves = state.speed > params.dt * max(params.deceleration, -state.acceleration)
    if not _renewing(envelope, energy, shear):
        return moves
    late = params.dt + state.owed - params.refresh
    return moves & (state.time_to_refresh <= 0.0) & (late >= -MEET) & (late <= MEET)


@kernel
def advance_evenly(state, action, params, envelope, energy, lags, wind, track):  # type: ignore[no-untyped-def]
    """Move a record for which `even` holds over a control interval, gusts apart; on lanes too."""
    duration = params.dt
    if _renewing(envelope, energy, None):
        duration = params.refresh
        state.owed = left_after(params.dt + state.owed, duration, 1, duration)
        renew_limits(state, params, envelope, energy)
        state.time_to_refresh = 0.0
    vertical_speed, acceleration, turn_rate, turn = commanded_rates(state, action, params, envelope, energy)
    _glide(
        state, vertical_speed, acceleration, turn_rate, _roll_in(turn, lags), duration, lags, wind, None, track
    )  # fmt: skip


@kernel
def _advance_in_pieces(state, action, params, envelope, energy, lags, wind, shear, track, textbook):  # type: ignore[no-untyped-def]
    """Move any record over a control interval, gusts apart."""
    if not _renewing(envelope, energy, shear):
        _hold(state, action, params, params.dt, envelope, energy, lags, wind, shear, track, textbook)
        return
    total, to_tick = params.dt + state.owed, state.time_to_refresh
    first, ticks = (to_tick if to_tick > 0.0 else params.refresh), 0
    left = total
    while left > MEET:
        # renewed when flown on, so that what a gust does at the end of an interval counts
        if state.time_to_refresh <= 0.0:
            renew_limits(state, params, envelope, energy)
        piece = piece_of(left, state.time_to_refresh)
        state.time_to_refresh, ticked = to_next_tick(state.time_to_refresh, piece, 0.0)
        _hold(state, action, params, piece, envelope, energy, lags, wind, shear, track, textbook)
        left -= piece
        if ticked:
            ticks += 1
            left = left_after(total, first, ticks, params.refresh)
    state.owed = left


@kernel
def advance(state, action, params, envelope, energy, lags, atmosphere, wind, shear, turbulence, track, textbook):  # type: ignore[no-untyped-def]
    """Move one record over a control interval.

    `action`: vertical speed, acceleration and turn rate as fractions of their limits, each in [-1, 1].
    """
    altitude, speed, heading = state.altitude, state.speed, state.heading
    if even(state, params, envelope, energy, shear, textbook):
        advance_evenly(state, action, params, envelope, energy, lags, wind, track)
    else:
        _advance_in_pieces(state, action, params, envelope, energy, lags, wind, shear, track, textbook)
    if turbulence is not None:
        blow(state, altitude, speed, heading, params.dt, turbulence, track)


@kernel
def left_envelope(state, params, atmosphere):  # type: ignore[no-untyped-def]
    """Whether the aircraft has hit the ground, stalled, or left the envelope upwards.

    Stall and top speed are airspeeds as measured: equivalent ones with the option `atmosphere`, whose `top_mach`
    is a limit too.
    """
    measured = airspeed(state.altitude, state.speed, atmosphere)
    fast = measured >= params.top_speed
    if atmosphere is not None:
        fast = fast | (state.speed >= atmosphere.top_mach * sound_speed(state.altitude))
    aloft = (state.altitude > 0.0) & (state.altitude < params.ceiling)
    return fast | (measured < params.stall_speed) | negate(aloft)
