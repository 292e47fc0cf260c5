"""Motion of a bar with three degrees of freedom: x(t), tilt theta(t) and z(t), and the height of its surface.

Frame (Bell's): x to the right along the bar, y away from the camera, z up. theta is the right-handed rotation
about +y, so a positive tilt lowers the right end: the surface is z_bar - (x - x_bar) tan(theta).

A motion is six phasor components (x_cos, x_sin, tilt_cos, tilt_sin, z_cos, z_sin):
x = x_cos cos(omega s) + x_sin sin(omega s), tilt alike, z alike at 2 omega (Bell section IV: a parabolic path).
Time s runs from the start of the base cycle. A `Piece` goes from one motion to another by the cubic
S(u) = u^2 (3 - 2u), u = s / blend (continuous position and velocity), or keeps one motion (blend = 0).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from vr_envs.models.jit import kernel

Motion = tuple[float, float, float, float, float, float]


class Piece(NamedTuple):
    """A stretch of bar motion: `base + S(s / blend) change`, or `base` alone when blend is 0 s."""

    omega: float  # rad/s, base frequency
    blend: float  # s, duration of the blend
    base: Motion  # m, rad, m
    change: Motion  # m, rad, m


class Frame(NamedTuple):
    """The bar at one instant: (value, first, second, third derivative) of each degree of freedom."""

    x: tuple[float, float, float, float]  # m, m/s, m/s^2, m/s^3
    tilt: tuple[float, float, float, float]  # rad, ...
    z: tuple[float, float, float, float]  # m, ...
    cos: float  # of the tilt
    sin: float
    wave_cos: float  # of omega s
    wave_sin: float


class Bounds(NamedTuple):
    """Bounds over a whole piece of the absolute value of derivative `k` of one degree of freedom."""

    d0: float
    d1: float
    d2: float
    d3: float
    d4: float


@kernel
def cos_sin(angle):
    """Cosine and sine of an angle; small ones, as in a chatter or of a tilt, by Taylor's series to rounding."""
    if abs(angle) > 0.1:
        return math.cos(angle), math.sin(angle)
    q = angle * angle
    cos = 1.0 + q * (-1 / 2 + q * (1 / 24 + q * (-1 / 720 + q * (1 / 40320 - q * (1 / 3628800)))))
    sin = angle + angle * q * (-1 / 6 + q * (1 / 120 + q * (-1 / 5040 + q * (1 / 362880))))
    return cos, sin


@kernel
def _phasor(c, s, w, cos, sin):
    """Value and three derivatives of c cos(w s) + s sin(w s)."""
    q0 = c * cos + s * sin
    q1 = w * (s * cos - c * sin)
    return q0, q1, -w * w * q0, -w * w * q1


@kernel
def _blended(base, change, s0, s1, s2, s3):
    """Leibniz rule for base + S change; `s0..s3` are S and its derivatives."""
    b0, b1, b2, b3 = base
    c0, c1, c2, c3 = change
    return (
        b0 + s0 * c0,
        b1 + s0 * c1 + s1 * c0,
        b2 + s0 * c2 + 2.0 * s1 * c1 + s2 * c0,
        b3 + s0 * c3 + 3.0 * s1 * c2 + 3.0 * s2 * c1 + s3 * c0,
    )


@kernel
def _change(c, s, w, cos, sin, d_cos, d_sin):
    """Change of a phasor's value, and its first and second derivative at the end of the change."""
    return c * d_cos + s * d_sin, w * (s * cos - c * sin), -w * w * (c * cos + s * sin)


@kernel
def _blended_change(base, value, change, blend):
    """The same for base + S change; `value` is that of the change at the end."""
    s0, s1, s2, d_s = blend
    return (
        base[0] + s0 * change[0] + d_s * (value - change[0]),
        base[1] + s0 * change[1] + s1 * value,
        base[2] + s0 * change[2] + 2.0 * s1 * change[1] + s2 * value,
    )


@kernel
def frame_at(piece, s):
    """The `Frame` of the bar at time s."""
    w = piece.omega
    cos, sin = math.cos(w * s), math.sin(w * s)
    cos2, sin2 = cos * cos - sin * sin, 2.0 * sin * cos
    b = piece.base
    x = _phasor(b[0], b[1], w, cos, sin)
    tilt = _phasor(b[2], b[3], w, cos, sin)
    z = _phasor(b[4], b[5], 2.0 * w, cos2, sin2)
    if piece.blend > 0.0:
        c = piece.change
        t = piece.blend
        u = s / t
        s0, s1, s2, s3 = (
            u * u * (3.0 - 2.0 * u),
            6.0 * u * (1.0 - u) / t,
            (6.0 - 12.0 * u) / (t * t),
            -12.0 / (t * t * t),
        )
        x = _blended(x, _phasor(c[0], c[1], w, cos, sin), s0, s1, s2, s3)
        tilt = _blended(tilt, _phasor(c[2], c[3], w, cos, sin), s0, s1, s2, s3)
        z = _blended(z, _phasor(c[4], c[5], 2.0 * w, cos2, sin2), s0, s1, s2, s3)
    tilt_cos, tilt_sin = cos_sin(tilt[0])
    return Frame(x, tilt, z, tilt_cos, tilt_sin, cos, sin)


@kernel
def increments(piece, frame, s, ds):
    """Changes of (x, tilt, z) from s, where the bar is at `frame`, to s + ds, without cancellation as ds -> 0.

    cos(b) - cos(a) = -2 sin((a+b)/2) sin((b-a)/2), so a flight of nanometres keeps its relative accuracy.

    Returns:
        (x, tilt, z), each as (change, rate at s + ds, second derivative at s + ds).
    """
    w = piece.omega
    ch, sh = cos_sin(0.5 * w * ds)
    cm, sm = frame.wave_cos * ch - frame.wave_sin * sh, frame.wave_sin * ch + frame.wave_cos * sh
    cos, sin = cm * ch - sm * sh, sm * ch + cm * sh
    cos2, sin2 = cos * cos - sin * sin, 2.0 * sin * cos
    d_cos, d_sin = -2.0 * sm * sh, 2.0 * cm * sh
    s_2mid, c_2mid, s_2half = 2.0 * sm * cm, cm * cm - sm * sm, 2.0 * sh * ch
    d_cos2, d_sin2 = -2.0 * s_2mid * s_2half, 2.0 * c_2mid * s_2half
    b = piece.base
    x = _change(b[0], b[1], w, cos, sin, d_cos, d_sin)
    tilt = _change(b[2], b[3], w, cos, sin, d_cos, d_sin)
    z = _change(b[4], b[5], 2.0 * w, cos2, sin2, d_cos2, d_sin2)
    if piece.blend > 0.0:
        c, t = piece.change, piece.blend
        u, u1 = s / t, (s + ds) / t
        d_s = ds / t * (3.0 * (u1 + u) - 2.0 * (u1 * u1 + u1 * u + u * u))
        blend = (u1 * u1 * (3.0 - 2.0 * u1), 6.0 * u1 * (1.0 - u1) / t, (6.0 - 12.0 * u1) / (t * t), d_s)
        x = _blended_change(x, c[0] * cos + c[1] * sin, _change(c[0], c[1], w, cos, sin, d_cos, d_sin), blend)
        tilt = _blended_change(tilt, c[2] * cos + c[3] * sin, _change(c[2], c[3], w, cos, sin, d_cos, d_sin), blend)
        c_z = _change(c[4], c[5], 2.0 * w, cos2, sin2, d_cos2, d_sin2)
        z = _blended_change(z, c[4] * cos2 + c[5] * sin2, c_z, blend)
    return x, tilt, z


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
def bounds(piece):
    """Bounds of the derivatives 0 to 4 of x, tilt and z over the piece."""
    w, b, c = piece.omega, piece.base, piece.change
    return (
        _bound(w, piece.blend, b[0], b[1], c[0], c[1]),
        _bound(w, piece.blend, b[2], b[3], c[2], c[3]),
        _bound(2.0 * w, piece.blend, b[4], b[5], c[4], c[5]),
    )
