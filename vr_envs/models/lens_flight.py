"""Flight of a ball above a moving spherical lens, up to the next impact: the certified first root of the gap.

With (x, y) the place of the ball's centre and h its height above the lowest (or highest) point of its path, a sphere
of curvature kappa,
    D = h - kappa (x^2 + y^2 + h^2) / 2
is positive off the glass and zero on it, and its gradient n = (-kappa x, -kappa y, 1 - kappa h) is there the unit
normal, for a concave (kappa > 0), a flat and a convex lens alike. D' is then the normal velocity.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from vr_envs.models.jit import kernel
from vr_envs.models.phasor import cos_sin
from vr_envs.models.root import MAX_MARCH, TIME_RESOLUTION, UNDECIDED, certified_step, converged


class _Flight(NamedTuple):
    """What the gap of one flight follows from, at its start."""

    gap: float  # m
    rate: float  # m/s, of the gap; the normal velocity if the ball has just left the lens
    up: float  # 1 - kappa h
    u: float  # m/s
    v: float  # m/s
    rise: float  # m/s, of h
    wave_cos: float  # of omega s + phase
    wave_sin: float


@kernel
def surface_height(distance, curvature):
    """Height (m) of a sphere of `curvature` (1/m) above its lowest point, at a `distance` (m) from the axis."""
    slope = curvature * distance
    return slope * distance / (1.0 + math.sqrt(1.0 - slope * slope))


@kernel
def lens_at(params, s):
    """The lens at time s of a cycle: (height, velocity, cosine and sine of omega s + phase)."""
    angle = params.omega * s + params.phase
    cos, sin = math.cos(angle), math.sin(angle)
    return params.amplitude * sin, params.omega * params.amplitude * cos, cos, sin


@kernel
def gap_at(state, s, params):
    """The gap D (m) of a ball at time s of a cycle, and its rate (m/s)."""
    kappa = params.path_curvature
    height, climb, _, _ = lens_at(params, s)
    h = state.z - height
    gap = h - 0.5 * kappa * (state.x * state.x + state.y * state.y + h * h)
    return gap, (state.w - climb) * (1.0 - kappa * h) - kappa * (state.x * state.u + state.y * state.v)


@kernel
def _gap(f, ds, params):
    """The gap D a time `ds` into a flight, and its two derivatives.

    Everything is a difference from the start of the flight, so a gap of 1e-17 m keeps its digits.
    """
    omega, kappa = params.omega, params.path_curvature
    a = params.amplitude
    angle = omega * ds
    cos, sin = cos_sin(angle)
    half = cos_sin(0.5 * angle)[1]
    versed = -2.0 * half * half  # cos - 1
    # h and h' without their values at the start of the flight, h also without h' ds
    bend = -0.5 * params.gravity * ds * ds - a * (f.wave_sin * versed + f.wave_cos * (sin - angle))
    rise = -params.gravity * ds - omega * a * (f.wave_cos * versed - f.wave_sin * sin)
    pull = -params.gravity + omega * omega * a * (f.wave_sin * cos + f.wave_cos * sin)
    moved, speed = f.rise * ds + bend, f.rise + rise
    across = f.u * f.u + f.v * f.v
    value = f.gap + f.rate * ds + f.up * bend - 0.5 * kappa * (across * ds * ds + moved * moved)
    slope = f.rate + f.up * rise - kappa * (across * ds + moved * speed)
    return value, slope, (f.up - kappa * moved) * pull - kappa * (across + speed * speed)


@kernel
def _gap_bounds(f, h, w, remaining, params):
    """Bounds on the absolute second and third derivative of the gap over the rest of a flight, up to its first root.

    D'' = (1 - kappa h) h'' - kappa (u^2 + v^2 + h'^2), D''' = (1 - kappa h) h''' - 3 kappa h' h''. Above a concave
    path the ball is inside its sphere, where |1 - kappa h| <= 1.
    """
    omega = params.omega
    rate = omega * params.amplitude
    kappa = abs(params.path_curvature)
    speed = abs(w) + params.gravity * remaining + rate
    pull = params.gravity + omega * rate
    up = 1.0
    if params.path_curvature < 0.0:
        up += kappa * (abs(h) + speed * remaining)
    curvature = up * pull + kappa * (f.u * f.u + f.v * f.v + speed * speed)
    return curvature, up * omega * omega * rate + 3.0 * kappa * speed * pull


@kernel
def flight(state, s, gap, rate, params):
    """First impact of a flight from time s: (hit, duration), the duration UNDECIDED if the search does not end.

    `gap` and `rate` are those of D at the start: the flight of a ball that has just left the lens has gap 0 and its
    normal velocity. The search ends with the cycle.
    """
    height, climb, cos, sin = lens_at(params, s)
    h = state.z - height
    f = _Flight(gap, rate, 1.0 - params.path_curvature * h, state.u, state.v, state.w - climb, cos, sin)
    end = params.period
    if gap <= 0.0 and rate <= 0.0:
        return True, 0.0
    curvature, jerk = _gap_bounds(f, h, state.w, end - s, params)
    value, slope, second = _gap(f, 0.0, params)
    ds = 0.0
    if value <= 0.0:
        ds = certified_step(0.0, slope, second, jerk, curvature)
    for _ in range(MAX_MARCH):
        if s + ds >= end:
            return False, end - s
        value, slope, second = _gap(f, ds, params)
        if value <= 0.0:
            return True, ds
        step = certified_step(value, slope, second, jerk, curvature)
        if converged(s + ds, step):
            return True, ds
        ds += step
        # what the certified step left out of the cubic term is below the resolution of time
        if slope < 0.0 and jerk * step * step * step < -TIME_RESOLUTION * slope:
            return s + ds < end, min(ds, end - s)
    return False, UNDECIDED
