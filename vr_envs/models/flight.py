"""Flight of a ball over a moving bar, from one contact to the next: the certified first root of the gap."""

from __future__ import annotations

import math

from vr_envs.models.bar import cos_sin, increments
from vr_envs.models.jit import kernel
from vr_envs.models.rest import UNDECIDED, flight_support
from vr_envs.models.root import MAX_MARCH, TIME_RESOLUTION, certified_step, converged

AIRBORNE, BOUNCED, RELEASED = 0, 1, 2  # how a flight begins


@kernel
def contact_at(frame, x, u, w):
    """What a ball at `x` with velocity (u, w) meets: (height, normal and tangential velocity, place on the bar)."""
    rx = x - frame.x[0]
    rz = -rx * frame.sin / frame.cos
    # the bar's material at the contact point moves with the centre's velocity + tilt rate y x r
    ru, rw = u - frame.x[1] - frame.tilt[1] * rz, w - frame.z[1] + frame.tilt[1] * rx
    normal, tangent = ru * frame.sin + rw * frame.cos, ru * frame.cos - rw * frame.sin
    return frame.z[0] + rz, normal, tangent, rx / frame.cos


@kernel
def _bend(gravity, ax, at, az, speed, vt, reach, tan):
    """Second derivative of the vertical gap: z - z_bar + (x - x_bar) tan(tilt), twice."""
    sec2 = 1.0 + tan * tan
    return -gravity - az - ax * tan + (2.0 * speed * vt + reach * (at + 2.0 * vt * vt * tan)) * sec2


@kernel
def _gap(piece, start, frame, ds, gap, rx, u, w, gravity):
    """Vertical gap between ball and surface a time `ds` into a flight that began with `gap`, and two derivatives.

    Everything is a difference from the start of the flight, so a gap of 1e-17 m keeps its digits.
    """
    (dx, vx, ax), (dt, vt, at), (dz, vz, az) = increments(piece, frame, start, ds)
    cos_d, sin_d = cos_sin(dt)
    cos = frame.cos * cos_d - frame.sin * sin_d
    tan = (frame.sin * cos_d + frame.cos * sin_d) / cos
    sec2 = 1.0 + tan * tan
    moved = u * ds - dx
    value = gap + (w - 0.5 * gravity * ds) * ds - dz + moved * tan + rx * sin_d / (cos * frame.cos)
    rate = w - gravity * ds - vz + (u - vx) * tan + (rx + moved) * vt * sec2
    return value, rate, _bend(gravity, ax, at, az, u - vx, vt, rx + moved, tan)


@kernel
def _gap_bounds(limits, tan, rx, u, remaining, gravity):
    """Bounds on the absolute second and third derivative of the vertical gap over the rest of a flight.

    `limits` and `tan` bound the bar's motion and the slope of its surface.
    """
    x, t, z = limits
    sec2 = 1.0 + tan * tan
    reach = abs(rx) + abs(u) * remaining + 2.0 * x.d0
    speed = abs(u) + x.d1
    turn = t.d1 * sec2
    turning = (t.d2 + 2.0 * t.d1 * t.d1 * tan) * sec2
    turning_rate = (t.d3 + 6.0 * t.d1 * t.d2 * tan + 2.0 * t.d1 * t.d1 * t.d1 * (sec2 + 2.0 * tan * tan)) * sec2
    curvature = gravity + z.d2 + x.d2 * tan + 2.0 * speed * turn + reach * turning
    return curvature, z.d3 + x.d3 * tan + 3.0 * (x.d2 * turn + speed * turning) + reach * turning_rate


@kernel
def flight(piece, limits, tan, s, frame, end, x, z, u, w, gravity, contact):
    """First contact of a flight from time s: (hit, duration), the duration UNDECIDED if the search does not end.

    `contact`: AIRBORNE, BOUNCED (leaving the surface with a velocity) or RELEASED (leaving it without).
    """
    height, normal, tangent, d = contact_at(frame, x, u, w)
    rx = x - frame.x[0]
    curvature, jerk = _gap_bounds(limits, tan, rx, u, end - s, gravity)
    gap = 0.0 if contact != AIRBORNE else z - height
    ds = 0.0
    if contact == RELEASED:
        # gap = -N s^2/2 - N' s^3/6 with N <= 0: begin where it has grown above rounding
        force, slope = flight_support(frame, gravity, d, tangent)
        ds = min(1e-3 / piece.omega, math.sqrt(2e-14 / max(-force, 1e-12)))
        if slope < 0.0:
            ds = min(ds, (6e-14 / -slope) ** (1.0 / 3.0))
    elif gap <= 0.0:
        if normal <= 0.0:
            return True, 0.0
        f = frame
        second = _bend(gravity, f.x[2], f.tilt[2], f.z[2], u - f.x[1], f.tilt[1], rx, f.sin / f.cos)
        gap, ds = 0.0, certified_step(0.0, normal / f.cos, second, jerk, curvature)
    for _ in range(MAX_MARCH):
        if s + ds >= end:
            return False, end - s
        value, slope, second = _gap(piece, s, frame, ds, gap, rx, u, w, gravity)
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
