"""Ground track of an aircraft: x' = v sin(psi), z' = v cos(psi), psi from the z axis towards x.

With constant acceleration and turn rate it has a closed form; with lagging rates it is integrated by
Gauss-Legendre quadrature on the smooth pieces, in panels short enough for an error below rounding.
The speed over the ground is the airspeed without the gust.
"""

from __future__ import annotations

import math

from vr_envs.models.elementary import cos_sin
from vr_envs.models.jit import kernel
from vr_envs.models.lag import clamped_lag, ramp_time
from vr_envs.models.lanes import any_lane, where
from vr_envs.models.quadrature import integral, points


def _bessel_series(order: int, terms: int) -> tuple[float, ...]:
    """Coefficients of j0 (order 0) or j1(q) / q (order 1) in q^2, the highest first."""
    row = [1.0 / (2 * order + 1)]
    for k in range(1, terms):
        row.append(-row[-1] / (2 * k * (2 * k + 2 * order + 1)))
    return tuple(reversed(row))


_J0, _J1 = _bessel_series(0, 8), _bessel_series(1, 8)


@kernel
def spherical_bessel(q):  # type: ignore[no-untyped-def]
    """Spherical Bessel functions j0(q) = sin q / q and j1(q) = (sin q - q cos q) / q^2."""
    s = q * q
    j0, j1 = 0.0 * s, 0.0 * s
    for a, b in zip(_J0, _J1):  # noqa: B905 (numba knows no strict)
        j0, j1 = j0 * s + a, j1 * s + b
    j1 *= q
    large = s >= 0.25
    if any_lane(large):
        cosine, sine = cos_sin(q)
        j0 = where(large, sine / q, j0)
        j1 = where(large, (sine - q * cosine) / s, j1)
    return j0, j1


@kernel
def uniform_turn(state, duration):  # type: ignore[no-untyped-def]
    """Move x and z over `duration` [s] with the state's acceleration and turn rate constant.

    About the middle of the interval (speed V, heading P, half turn q) the integrals of (V + a s) sin, cos(P + w s)
    are spherical Bessel functions, regular as w -> 0.
    """
    half = 0.5 * duration
    q = state.turn_rate * half
    j0, j1 = spherical_bessel(q)
    chord = duration * (state.speed - state.gust_along + state.acceleration * half) * j0
    skew = duration * state.acceleration * half * j1
    cosine, sine = cos_sin(state.heading + q)
    state.x += chord * sine + skew * cosine
    state.z += chord * cosine - skew * sine


@kernel
def turn_with_lags(state, acceleration, turn_rate, turn_slew, duration, lags):  # type: ignore[no-untyped-def]
    """Move x and z over `duration` [s] while acceleration and turn rate follow the commands given."""
    first = min(duration, ramp_time(state.acceleration, acceleration, lags.along, lags.jerk))
    second = min(duration, ramp_time(state.turn_rate, turn_rate, lags.turn, turn_slew))
    ground_speed = state.speed - state.gust_along
    # decays and radians per second, together: a panel spans at most one
    pace = 1.0 / lags.along + 1.0 / lags.turn + max(abs(state.turn_rate), abs(turn_rate))
    begin = 0.0
    for piece in range(3):
        end = duration if piece == 2 else (max(first, second) if piece else min(first, second))
        panels = math.ceil((end - begin) * pace)
        for panel in range(panels):
            length = (end - begin) / panels
            time = points(begin + length * panel, length)
            _, gain = clamped_lag(state.acceleration, acceleration, lags.along, lags.jerk, time)
            _, turned = clamped_lag(state.turn_rate, turn_rate, lags.turn, turn_slew, time)
            cosine, sine = cos_sin(state.heading + turned)
            state.x += integral((ground_speed + gain) * sine, length)
            state.z += integral((ground_speed + gain) * cosine, length)
        begin = end
