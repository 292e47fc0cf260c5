"""The bar's surface as a ball meets it: place and velocities of a contact, and the gap under a ball in flight.

In the bar's axes e_x = (cos, -sin) along it and e_z = (sin, cos) across it, with the tilt's cosine and sine, the
centre of the ball is at p e_x + q e_z from the bar's centre. The surface is q = 0, or on a curved bar, for the path of
the ball's centre, q = kappa p^2/2 (the option `curve`). On a flat bar the gap is measured vertically, q / cos(tilt):
x then moves without the tilt. On a curved one it is q - kappa p^2/2.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from vr_envs.models.bar import increments
from vr_envs.models.jit import kernel
from vr_envs.models.phasor import cos_sin


class Contact(NamedTuple):
    """What a ball on the surface meets: the tangent there is (cos, -sin), the normal (sin, cos)."""

    x: float  # m, place of the ball
    z: float
    d: float  # m, place p along the bar
    normal: float  # m/s, velocity of the ball's centre relative to the bar's material
    tangent: float
    cos: float  # of the surface's slope
    sin: float


@kernel
def steepness(d, curve):
    """Length of the surface per length of the bar at the place d: sqrt(1 + kappa^2 d^2)."""
    if curve is None:
        return 1.0
    else:
        slope = curve.curvature * d
        return math.sqrt(1.0 + slope * slope)


@kernel
def contact_at(frame, x, z, u, w, curve):
    """The `Contact` of a ball at (x, z) with velocity (u, w); a flat bar takes x as given, z from its surface."""
    rx = x - frame.x[0]
    if curve is None:
        rz = -rx * frame.sin / frame.cos
        d, cos, sin = rx / frame.cos, frame.cos, frame.sin
    else:
        rz = z - frame.z[0]
        d = rx * frame.cos - rz * frame.sin
        slope = curve.curvature * d
        q = 0.5 * slope * d
        rx, rz = d * frame.cos + q * frame.sin, q * frame.cos - d * frame.sin
        rise = 1.0 / math.sqrt(1.0 + slope * slope)
        cos, sin = (frame.cos + slope * frame.sin) * rise, (frame.sin - slope * frame.cos) * rise
    # the bar's material at the contact point moves with the centre's velocity + tilt rate y x r
    ru, rw = u - frame.x[1] - frame.tilt[1] * rz, w - frame.z[1] + frame.tilt[1] * rx
    return Contact(frame.x[0] + rx, frame.z[0] + rz, d, ru * sin + rw * cos, ru * cos - rw * sin, cos, sin)


@kernel
def gap_at(frame, x, z, curve):
    """Gap under a ball at (x, z)."""
    rx, rz = x - frame.x[0], z - frame.z[0]
    if curve is None:
        return z - (frame.z[0] - rx * frame.sin / frame.cos)
    else:
        p, q = rx * frame.cos - rz * frame.sin, rx * frame.sin + rz * frame.cos
        return q - 0.5 * curve.curvature * p * p


@kernel
def past_end(frame, x, z, half_length, curve):
    """Whether a ball at (x, z) is beyond an end of a curved bar, below the tangent there."""
    rx, rz = x - frame.x[0], z - frame.z[0]
    p, q = abs(rx * frame.cos - rz * frame.sin), rx * frame.sin + rz * frame.cos
    return p > half_length and q < curve.curvature * half_length * (p - 0.5 * half_length)


@kernel
def opening(contact, frame, curve):
    """Rate of the gap at a contact, m/s."""
    if curve is None:
        return contact.normal / frame.cos
    else:
        return contact.normal * steepness(contact.d, curve)


@kernel
def bend(gravity, ax, at, az, speed, vt, reach, tan):
    """Second derivative of the vertical gap over a flat bar: z - z_bar + (x - x_bar) tan(tilt), twice."""
    sec2 = 1.0 + tan * tan
    return -gravity - az - ax * tan + (2.0 * speed * vt + reach * (at + 2.0 * vt * vt * tan)) * sec2


@kernel
def gap(piece, start, frame, ds, gap_0, rx, rz, u, w, gravity, curve):
    """Gap a time `ds` into a flight that began at `start` with `gap_0`, and its first and second derivative.

    `rx`, `rz`: place from the bar's centre at the start. Everything is a difference from the start of the flight, so
    a gap of 1e-17 m keeps its digits.
    """
    x, tilt, z = increments(piece, frame, start, ds)
    dx, vx, ax = x
    dt, vt, at = tilt
    dz, vz, az = z
    if curve is None:
        cos_d, sin_d = cos_sin(dt)
        cos = frame.cos * cos_d - frame.sin * sin_d
        tan = (frame.sin * cos_d + frame.cos * sin_d) / cos
        sec2 = 1.0 + tan * tan
        moved = u * ds - dx
        value = gap_0 + (w - 0.5 * gravity * ds) * ds - dz + moved * tan + rx * sin_d / (cos * frame.cos)
        rate = w - gravity * ds - vz + (u - vx) * tan + (rx + moved) * vt * sec2
        return value, rate, bend(gravity, ax, at, az, u - vx, vt, rx + moved, tan)
    else:
        half_cos, half_sin = cos_sin(0.5 * dt)
        less, sin_d = -2.0 * half_sin * half_sin, 2.0 * half_sin * half_cos  # cos(dt) - 1, sin(dt)
        d_cos, d_sin = frame.cos * less - frame.sin * sin_d, frame.sin * less + frame.cos * sin_d
        cos, sin = frame.cos + d_cos, frame.sin + d_sin
        p_0 = rx * frame.cos - rz * frame.sin
        right, up = u * ds - dx, (w - 0.5 * gravity * ds) * ds - dz
        d_p = right * cos - up * sin + rx * d_cos - rz * d_sin
        d_q = right * sin + up * cos + rx * d_sin + rz * d_cos
        p, q = p_0 + d_p, rx * frame.sin + rz * frame.cos + d_q
        v_x, v_z = u - vx, w - gravity * ds - vz
        along, across = v_x * cos - v_z * sin, v_x * sin + v_z * cos
        p_1, q_1 = along - vt * q, across + vt * p
        p_2 = -ax * cos + (gravity + az) * sin - vt * (across + q_1) - at * q
        q_2 = -ax * sin - (gravity + az) * cos + vt * (along + p_1) + at * p
        k = curve.curvature
        return gap_0 + d_q - k * (p_0 + 0.5 * d_p) * d_p, q_1 - k * p * p_1, q_2 - k * (p_1 * p_1 + p * p_2)


@kernel
def gap_bounds(limits, tan, rx, rz, u, w, remaining, gravity, curve):
    """Bounds on the absolute second and third derivative of the gap over the rest of a flight.

    `limits` bound the bar's motion, `tan` the slope of a flat bar.
    """
    x, t, z = limits
    if curve is None:
        sec2 = 1.0 + tan * tan
        reach = abs(rx) + abs(u) * remaining + 2.0 * x.d0
        speed = abs(u) + x.d1
        turn = t.d1 * sec2
        turning = (t.d2 + 2.0 * t.d1 * t.d1 * tan) * sec2
        turning_rate = (t.d3 + 6.0 * t.d1 * t.d2 * tan + 2.0 * t.d1 * t.d1 * t.d1 * (sec2 + 2.0 * tan * tan)) * sec2
        curvature = gravity + z.d2 + x.d2 * tan + 2.0 * speed * turn + reach * turning
        return curvature, z.d3 + x.d3 * tan + 3.0 * (x.d2 * turn + speed * turning) + reach * turning_rate
    else:
        # p and q are products of a place from the bar's centre with axes that turn, |sin(tilt)| <= tan
        right_1, up_1 = abs(u) + x.d1, abs(w) + gravity * remaining + z.d1
        right, up = abs(rx) + right_1 * remaining, abs(rz) + up_1 * remaining
        right_2, up_2 = x.d2, gravity + z.d2
        axis_2, axis_3 = t.d2 + t.d1 * t.d1, t.d3 + 3.0 * t.d1 * t.d2 + t.d1 * t.d1 * t.d1
        p = right + up * tan
        p_1 = right_1 + up_1 * tan + (up + right * tan) * t.d1
        turned_2 = 2.0 * (right_1 + up_1) * t.d1 + (right + up) * axis_2
        turned_3 = 3.0 * ((right_2 + up_2) * t.d1 + (right_1 + up_1) * axis_2) + (right + up) * axis_3
        p_2, q_2 = right_2 + up_2 * tan + turned_2, up_2 + right_2 * tan + turned_2
        p_3, q_3 = x.d3 + z.d3 * tan + turned_3, z.d3 + x.d3 * tan + turned_3
        k = abs(curve.curvature)
        return q_2 + k * (p_1 * p_1 + p * p_2), q_3 + k * (3.0 * p_1 * p_2 + p * p_3)


@kernel
def clear_level(limits, tan, rx, rz, u, w, remaining, gravity, curve):
    """Height over the bar's mean height, m, above which no ball of this flight can touch the bar."""
    x, _, z = limits
    reach = abs(rx) + abs(u) * remaining + 2.0 * x.d0
    if curve is None:
        return z.d0 + reach * tan
    else:
        p = reach + (abs(rz) + (abs(w) + gravity * remaining) * remaining + 2.0 * z.d0) * tan
        return z.d0 + (reach * tan + max(0.0, 0.5 * curve.curvature) * p * p) * (1.0 + tan * tan)


@kernel
def high_flight(z, w, level, gravity):
    """The times between which a ball flies above a height, s; the first is infinite if it never does."""
    room = w * w - 2.0 * gravity * (level - z)
    if room <= 0.0:
        return math.inf, math.inf
    root = math.sqrt(room)
    return (w - root) / gravity, (w + root) / gravity
