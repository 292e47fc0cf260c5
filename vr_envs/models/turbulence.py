"""Dryden turbulence of MIL-F-8785C along, across and vertical to the path, discretised exactly.

With the scale lengths and standard deviations of this standard (MIL-STD-1797 halves the lengths of the lateral and
vertical components and has other factors in their spectra), as one-sided densities over the wavenumber W [rad/m],
Phi_u = sigma^2 (2 L / pi) / (1 + (L W)^2) and Phi_v,w = sigma^2 (L / pi) (1 + 3 (L W)^2) / (1 + (L W)^2)^2. With
T = L / V, time in units of T and white noise xi of unit intensity these are the processes

    u' = sqrt(2) xi - u,    p1' = xi - p1,    p2' = p1 - p2,    w = sqrt(3) p1 + (1 - sqrt(3)) p2,

u and w of variance 1. They are what a state holds; sigma and L, from altitude and airspeed, scale them. Over an
interval sigma and T are those of its beginning: a change within the interval is felt in the next.

An interval of length q = dt V / L adds to p1, p2 and the integral of p2 noise with the kernels k1 = exp(-r),
k2 = r exp(-r) and k3 = 1 - (1 + r) exp(-r), r the time left: jointly normal numbers, whose covariance (the integrals
G_ij of k_i k_j over r up to q) follows from k3, G22 and G33 alone, by parts. The integral of w is
(integral of p2) + sqrt(3) (increment of p2). Everything is divided by its power of q, so that dt V / L may go to 0.
"""

from __future__ import annotations

import math
from fractions import Fraction

from vr_envs.models.elementary import cos_sin, exp, power
from vr_envs.models.jit import kernel
from vr_envs.models.lanes import any_lane, floor, where
from vr_envs.models.noise import normal_pair

FOOT = 0.3048  # m
LOW = 1000.0 * FOOT  # m, below which the lengths and deviations of the low-altitude model hold
HIGH = 2000.0 * FOOT  # m, above which lengths and deviations are constant
LOWEST = 10.0 * FOOT  # m, where the low-altitude model ends
SCALE_LENGTH = 1750.0 * FOOT  # m, above HIGH
_SQRT3 = math.sqrt(3.0)
_PAIRS = 4  # of normal numbers, per control interval
_SMALL = 0.5  # below this q the covariance is taken from power series


def _series(terms: int) -> tuple[tuple[float, ...], ...]:
    """Taylor coefficients in q of k3 / q^2, G22 / q^3 and G33 / q^5, rows of an even and an odd one each.

    Highest orders first; `terms` is even.
    """
    k3 = [Fraction((-1) ** m * (m - 1), math.factorial(m)) for m in range(2, terms + 2)]
    k2_squared = [Fraction((-2) ** m, math.factorial(m)) for m in range(terms)]
    k3_squared = [sum((k3[i] * k3[m - i] for i in range(m + 1)), Fraction(0)) for m in range(terms)]
    g22 = [c / (m + 3) for m, c in enumerate(k2_squared)]
    g33 = [c / (m + 5) for m, c in enumerate(k3_squared)]
    rows = [[float(c) for series in (k3, g22, g33) for c in series[m : m + 2]] for m in range(0, terms, 2)]
    return tuple(tuple(row) for row in reversed(rows))


_SERIES = _series(16)


@kernel
def _power_series(q: float) -> tuple[float, float, float]:
    """k3 / q^2, G22 / q^3 and G33 / q^5 for small q; even and odd orders apart, for the processor's pipelines."""
    square = q * q
    zero = 0.0 * q
    even_3, odd_3, even_22, odd_22, even_33, odd_33 = zero, zero, zero, zero, zero, zero
    for a, b, c, d, e, f in _SERIES:
        even_3, odd_3 = even_3 * square + a, odd_3 * square + b
        even_22, odd_22 = even_22 * square + c, odd_22 * square + d
        even_33, odd_33 = even_33 * square + e, odd_33 * square + f
    return even_3 + q * odd_3, even_22 + q * odd_22, even_33 + q * odd_33


@kernel
def scales(altitude, turbulence):  # type: ignore[no-untyped-def]
    """Scale lengths [m] along (and across) and vertical, and the standard deviations [m/s], at an altitude [m]."""
    # from LOW to HIGH in proportion; above, share is 1
    low = 0.1 * turbulence.wind_20ft
    share = (min(altitude, HIGH) - LOW) / (HIGH - LOW)
    along = LOW + share * (SCALE_LENGTH - LOW)
    sigma_along = low + share * (turbulence.sigma - low)
    vertical, sigma_vertical = along, sigma_along
    lowest = altitude < LOW
    if any_lane(lowest):
        height = max(altitude, LOWEST)
        root = power(0.177 + 0.000823 / FOOT * height, 0.4)
        along, vertical = where(lowest, height / (root * root * root), along), where(lowest, height, vertical)
        sigma_along = where(lowest, low / root, sigma_along)
        sigma_vertical = where(lowest, low, sigma_vertical)
    return along, vertical, sigma_along, sigma_vertical


@kernel
def interval_law(q):  # type: ignore[no-untyped-def]
    """How p1 and p2 move over an interval of length q >= 0 in units of T.

    Returns:
        exp(-q), (1 - exp(-q)) / q and k3 / q^2, and the Cholesky factor l11, l21, l22, l31, l32, l33 of the
        covariance of the noise in p1, p2 and the integral of p2, divided by sqrt(q), q sqrt(q) and q^2 sqrt(q).
    """
    decay = exp(-q)
    square = decay * decay
    k3, g22, g33 = _power_series(q)
    large = q >= _SMALL
    if any_lane(large):
        per = 1.0 / q
        k3 = where(large, (1.0 - (1.0 + q) * decay) * per * per, k3)
        g22 = where(large, 0.25 * (1.0 - (1.0 + 2.0 * q * (1.0 + q)) * square) * per * per * per, g22)
        integral = (q - 2.0 + (2.0 + q) * decay) * per * per * per  # of k3, over q^3
        rest = integral - (decay * k3 + 0.5 * q * k3 * k3 - g22) - 0.5 * q * k3 * k3
        g33 = where(large, rest * per * per, g33)
    g13 = decay * k3 + 0.5 * q * k3 * k3 - g22
    g23 = 0.5 * k3 * k3
    g12 = q * g22 + 0.5 * square
    g11 = 2.0 * q * g12 + square
    l11 = math.sqrt(g11)
    l21, l31 = g12 / l11, g13 / l11
    l22 = math.sqrt(g22 - l21 * l21)
    l32 = (g23 - l31 * l21) / l22
    l33 = math.sqrt(g33 - l31 * l31 - l32 * l32)
    return decay, decay + q * k3, k3, l11, l21, l22, l31, l32, l33


@kernel
def cascade(first, second, q, law, noise_1, noise_2, noise_3):  # type: ignore[no-untyped-def]
    """p1 and p2 after an interval of length q, and the mean of w over it; `law` from `interval_law`, normal noises."""
    decay, closed, k3, l11, l21, l22, l31, l32, l33 = law
    root = math.sqrt(q)
    into_2 = root * (l21 * noise_1 + l22 * noise_2)
    into_integral = root * (l31 * noise_1 + l32 * noise_2 + l33 * noise_3)
    mean = first * (q * k3 + _SQRT3 * decay) + second * (1.0 - _SQRT3) * closed + _SQRT3 * into_2 + q * into_integral
    return decay * first + root * l11 * noise_1, decay * (second + q * first) + q * into_2, mean


@kernel
def start_gusts(state, counter, turbulence, track):  # type: ignore[no-untyped-def]
    """Draw the gusts from their stationary distribution, with 3 normal pairs of the state's key from `counter` on."""
    state.headwind, _ = normal_pair(state.key, counter)
    length, _, sigma, _ = scales(state.altitude, turbulence)
    state.gust_along = sigma * state.headwind
    state.updraught, state.updraught_lag = _stationary(state.key, counter + 1)
    if track is not None:
        state.crosswind, state.crosswind_lag = _stationary(state.key, counter + 2)


@kernel
def _stationary(key, counter):  # type: ignore[no-untyped-def]
    """p1 and p2 of variances 1/2 and 1/4 and covariance 1/4."""
    noise_1, noise_2 = normal_pair(key, counter)
    return math.sqrt(0.5) * noise_1, math.sqrt(0.125) * (noise_1 + noise_2)


@kernel
def blow(state, altitude, speed, heading, duration, turbulence, track):  # type: ignore[no-untyped-def]
    """Add what the gusts do in the control interval `state.steps` of `duration` [s] to a state moved in still air.

    Altitude, airspeed and heading are those of the beginning of the interval, the first two set the gusts' scales.
    The vertical gust carries the aircraft, the gust along the path adds to the airspeed (which does not fall below
    0), and the gust across it moves the ground track sideways, at right angles to the heading in between.
    """
    along, vertical, sigma_along, sigma_vertical = scales(altitude, turbulence)
    q_along, q_vertical = duration * speed / along, duration * speed / vertical
    counter = _PAIRS * state.steps
    noise_along, noise_1 = normal_pair(state.key, counter)
    noise_2, noise_3 = normal_pair(state.key, counter + 1)
    law = interval_law(q_vertical)
    state.updraught, state.updraught_lag, mean = cascade(
        state.updraught, state.updraught_lag, q_vertical, law, noise_1, noise_2, noise_3
    )
    state.altitude += sigma_vertical * duration * mean
    if any_lane(q_along != q_vertical):  # at low altitude
        law = interval_law(q_along)
    decay, l11 = law[0], law[3]
    state.headwind = decay * state.headwind + math.sqrt(2.0 * q_along) * l11 * noise_along
    gust = sigma_along * state.headwind
    state.speed = max(0.0, state.speed + gust - state.gust_along)
    state.gust_along = gust
    if track is not None:
        noise_1, noise_2 = normal_pair(state.key, counter + 2)
        noise_3, _ = normal_pair(state.key, counter + 3)
        state.crosswind, state.crosswind_lag, mean = cascade(
            state.crosswind, state.crosswind_lag, q_along, law, noise_1, noise_2, noise_3
        )
        turned = state.heading - heading
        middle = heading + 0.5 * (turned - 2.0 * math.pi * floor(turned / (2.0 * math.pi) + 0.5))
        cosine, sine = cos_sin(middle)
        state.x += sigma_along * duration * mean * cosine
        state.z -= sigma_along * duration * mean * sine
