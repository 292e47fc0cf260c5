"""Motion of a bar with three degrees of freedom: x(t), tilt theta(t) and z(t).

Frame (Bell's): x to the right along the bar, y away from the camera, z up. theta is the right-handed rotation
about +y, so a positive tilt lowers the right end: the surface is z_bar - (x - x_bar) tan(theta).

A motion is six phasor components (x_cos, x_sin, tilt_cos, tilt_sin, z_cos, z_sin):
x = x_cos cos(omega s) + x_sin sin(omega s), tilt alike, z alike at 2 omega (Bell section IV: a parabolic path).
Time s runs from the start of the base cycle. A `Piece` goes from one motion to another by the cubic
S(u) = u^2 (3 - 2u), u = (s - begin) / blend (continuous position and velocity), or keeps one motion (blend = 0).
Two things are compiled in only where a scene has them: frequencies of their own for x, tilt and z, and a ramp, by which
the phasors drift in time.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from vr_envs.models.jit import kernel
from vr_envs.models.phasor import (
    angular,
    cos_sin,
    phasor,
    phasor_change,
    plus_blend,
    plus_blend_change,
    turned_waves,
    waves_at,
)

Motion = tuple[float, float, float, float, float, float]
Wave = tuple[float, float]


class Piece(NamedTuple):
    """A stretch of bar motion: base + S change (+ s drift); without a change when `blend` is 0 s."""

    omega: float  # rad/s, base frequency
    begin: float  # s, start of the blend
    blend: float  # s, duration of the blend
    base: Motion  # m, rad, m
    change: Motion  # m, rad, m
    frequencies: Any  # record of ball_options.Frequencies, or None
    phase: tuple[float, float, float]  # rad, of x, tilt and z at s = 0, used with these frequencies
    ramp: Any  # record of ball_options.Ramp, or None


class Frame(NamedTuple):
    """The bar at one instant: (value, first, second, third derivative) of each degree of freedom."""

    x: tuple[float, float, float, float]  # m, m/s, m/s^2, m/s^3
    tilt: tuple[float, float, float, float]  # rad, ...
    z: tuple[float, float, float, float]  # m, ...
    cos: float  # of the tilt
    sin: float
    waves: tuple[Wave, Wave, Wave]  # of the angles of x, tilt and z


class Bounds(NamedTuple):
    """Bounds over a whole piece of the absolute value of derivative `k` of one degree of freedom."""

    d0: float
    d1: float
    d2: float
    d3: float
    d4: float


@kernel
def drift_of(omega, ramp):
    """Growth of the six phasors, in m/s, rad/s and m/s, of a ramp of the peak accelerations."""
    a = 1.0 / (omega * omega)
    b = 0.25 * a
    return ramp.x_cos * a, ramp.x_sin * a, ramp.tilt_cos * a, ramp.tilt_sin * a, ramp.z_cos * b, ramp.z_sin * b


@kernel
def _blend(piece, s):
    """S and its three derivatives at time s."""
    t = piece.blend
    u = (s - piece.begin) / t
    return u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u) / t, (6.0 - 12.0 * u) / (t * t), -12.0 / (t * t * t)


@kernel
def _plus_drift(axes, omega, w, waves, s, ramp):
    """Add the drift to (x, tilt, z), each as value and three derivatives."""
    if ramp is None:
        return axes
    else:
        d = drift_of(omega, ramp)
        return (
            plus_blend(axes[0], phasor(d[0], d[1], w[0], waves[0]), s, 1.0, 0.0, 0.0),
            plus_blend(axes[1], phasor(d[2], d[3], w[1], waves[1]), s, 1.0, 0.0, 0.0),
            plus_blend(axes[2], phasor(d[4], d[5], w[2], waves[2]), s, 1.0, 0.0, 0.0),
        )


@kernel
def frame_at(piece, s):
    """The `Frame` of the bar at time s."""
    w = angular(piece.omega, piece.frequencies)
    waves = waves_at(piece.omega, s, piece.frequencies, piece.phase)
    b = piece.base
    x = phasor(b[0], b[1], w[0], waves[0])
    tilt = phasor(b[2], b[3], w[1], waves[1])
    z = phasor(b[4], b[5], w[2], waves[2])
    if piece.blend > 0.0:
        c = piece.change
        s0, s1, s2, s3 = _blend(piece, s)
        x = plus_blend(x, phasor(c[0], c[1], w[0], waves[0]), s0, s1, s2, s3)
        tilt = plus_blend(tilt, phasor(c[2], c[3], w[1], waves[1]), s0, s1, s2, s3)
        z = plus_blend(z, phasor(c[4], c[5], w[2], waves[2]), s0, s1, s2, s3)
    x, tilt, z = _plus_drift((x, tilt, z), piece.omega, w, waves, s, piece.ramp)
    tilt_cos, tilt_sin = cos_sin(tilt[0])
    return Frame(x, tilt, z, tilt_cos, tilt_sin, waves)


@kernel
def _plus_drift_change(axes, omega, w, end, change, s1, ds, ramp):
    """Add the drift to the changes of (x, tilt, z); `s1` is the time at the end of the change."""
    if ramp is None:
        return axes
    else:
        d, blend = drift_of(omega, ramp), (s1, 1.0, 0.0, ds)
        return (
            plus_blend_change(axes[0], d[0], d[1], w[0], end[0], change[0], blend),
            plus_blend_change(axes[1], d[2], d[3], w[1], end[1], change[1], blend),
            plus_blend_change(axes[2], d[4], d[5], w[2], end[2], change[2], blend),
        )


@kernel
def increments(piece, frame, s, ds):
    """Changes of (x, tilt, z) from s, where the bar is at `frame`, to s + ds, without cancellation as ds -> 0.

    A flight of nanometres keeps its relative accuracy.

    Returns:
        (x, tilt, z), each as (change, rate at s + ds, second derivative at s + ds).
    """
    w = angular(piece.omega, piece.frequencies)
    end, change = turned_waves(piece.omega, frame.waves, ds, piece.frequencies)
    b = piece.base
    x = phasor_change(b[0], b[1], w[0], end[0], change[0])
    tilt = phasor_change(b[2], b[3], w[1], end[1], change[1])
    z = phasor_change(b[4], b[5], w[2], end[2], change[2])
    if piece.blend > 0.0:
        c, t = piece.change, piece.blend
        u, u1 = (s - piece.begin) / t, (s - piece.begin + ds) / t
        d_s = ds / t * (3.0 * (u1 + u) - 2.0 * (u1 * u1 + u1 * u + u * u))
        s0, s1, s2, _ = _blend(piece, s + ds)
        blend = (s0, s1, s2, d_s)
        x = plus_blend_change(x, c[0], c[1], w[0], end[0], change[0], blend)
        tilt = plus_blend_change(tilt, c[2], c[3], w[1], end[1], change[1], blend)
        z = plus_blend_change(z, c[4], c[5], w[2], end[2], change[2], blend)
    return _plus_drift_change((x, tilt, z), piece.omega, w, end, change, s + ds, ds, piece.ramp)


@kernel
def _bound(w, blend, bc, bs, cc, cs):
    size = math.hypot(bc, bs)
    d0, d1, d2, d3, d4 = size, w * size, w * w * size, w * w * w * size, w * w * w * w * size
    if blend > 0.0:
        # base + S change is a convex combination of the two motions; |S'| <= 3/2, |S''| <= 6, |S'''| = 12 in u
        size = max(size, math.hypot(bc + cc, bs + cs))
        c = math.hypot(cc, cs)
        r = 1.0 / blend
        s1, s2, s3 = 1.5 * r, 6.0 * r * r, 12.0 * r * r * r
        d0, d1 = size, w * size + s1 * c
        d2 = w * w * size + (2.0 * s1 * w + s2) * c
        d3 = w * w * w * size + (3.0 * s1 * w * w + 3.0 * s2 * w + s3) * c
        d4 = w * w * w * w * size + (4.0 * s1 * w * w * w + 6.0 * s2 * w * w + 4.0 * s3 * w) * c
    return Bounds(d0, d1, d2, d3, d4)


@kernel
def _plus_drift_bound(bound, w, t, dc, ds):
    """A bound with a drift of the phasor for at most the time t added."""
    d = math.hypot(dc, ds)
    return Bounds(
        bound.d0 + t * d,
        bound.d1 + (w * t + 1.0) * d,
        bound.d2 + w * (w * t + 2.0) * d,
        bound.d3 + w * w * (w * t + 3.0) * d,
        bound.d4 + w * w * w * (w * t + 4.0) * d,
    )


@kernel
def _plus_drift_bounds(limits, omega, w, ramp):
    """Add the drift within one base cycle."""
    if ramp is None:
        return limits
    else:
        d, t = drift_of(omega, ramp), 2.0 * math.pi / omega
        return (
            _plus_drift_bound(limits[0], w[0], t, d[0], d[1]),
            _plus_drift_bound(limits[1], w[1], t, d[2], d[3]),
            _plus_drift_bound(limits[2], w[2], t, d[4], d[5]),
        )


@kernel
def bounds(piece):
    """Bounds of the derivatives 0 to 4 of x, tilt and z over the piece, for times within one base cycle."""
    w, b, c = angular(piece.omega, piece.frequencies), piece.base, piece.change
    limits = (
        _bound(w[0], piece.blend, b[0], b[1], c[0], c[1]),
        _bound(w[1], piece.blend, b[2], b[3], c[2], c[3]),
        _bound(w[2], piece.blend, b[4], b[5], c[4], c[5]),
    )
    return _plus_drift_bounds(limits, piece.omega, w, piece.ramp)
