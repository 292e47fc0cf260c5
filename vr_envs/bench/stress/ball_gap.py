"""The gap between ball and bar, judged apart from the model: where the bar is, and how deep a flight goes into it.

Written from the equations of motion alone, and shares nothing with the kernels that it judges. The bar's pose is
evaluated at an instant, the gap is q - kappa p^2/2 in the bar's axes, on a flat bar too, and a flight is searched with
D(s + h) >= D(s) + D'(s) h - K h^2/2, K a bound of |D''| over the flight: steps over which the gap is certainly above
minus a tolerance.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from vr_envs.models.jit import kernel

MOST_STEPS = 1_000_000  # of one search; a flight that needs more has not been judged


class Course(NamedTuple):
    """What the bar does in a base cycle, and its shape."""

    omega: float  # rad/s
    begin: float  # s, when it begins to go from `old` to `new`
    blend: float  # s, for how long
    old: tuple[float, float, float, float, float, float]  # m, rad, m: cosine and sine parts of x, tilt and z
    new: tuple[float, float, float, float, float, float]
    curvature: float  # 1/m


class Flight(NamedTuple):
    """A ball in free flight from the time `start` (s) of the cycle on."""

    start: float
    x: float  # m
    z: float
    u: float  # m/s
    w: float
    gravity: float  # m/s^2


@kernel
def course_of(old, action, number, params, curvature):
    """The `Course` of the base cycle in which an action is taken, whose interval has this number; for `hold` <= 1."""
    x, tilt = params.x_acceleration / params.omega**2, params.tilt_acceleration / params.omega**2
    z, span = params.z_acceleration / (2.0 * params.omega) ** 2, params.z_acceleration_span / (2.0 * params.omega) ** 2
    new = (
        x * action[0], x * action[1], tilt * action[2], tilt * action[3], z + span * action[4], span * action[5],
    )  # fmt: skip
    m = old.motion
    begin = 0.0 if params.hold == 1.0 or number % 2 == 0 else 0.5 * params.period
    return Course(
        params.omega, begin, params.blend * params.period, (m[0], m[1], m[2], m[3], m[4], m[5]), new, curvature
    )


@kernel
def _axis(course, k, share, growth, frequency, cos, sin):
    """Value and rate of the axis whose phasor is number k and k + 1, a `share` of the way to its new motion."""
    change_c, change_s = course.new[k] - course.old[k], course.new[k + 1] - course.old[k + 1]
    c, d = course.old[k] + share * change_c, course.old[k + 1] + share * change_s
    rate = frequency * (d * cos - c * sin) + growth * (change_c * cos + change_s * sin)
    return c * cos + d * sin, rate


@kernel
def pose(course, s):
    """(x, tilt, z) of the bar and their rates at the time s."""
    since = min(1.0, max(0.0, (s - course.begin) / course.blend))
    share, growth = since * since * (3.0 - 2.0 * since), 6.0 * since * (1.0 - since) / course.blend
    cos, sin = math.cos(course.omega * s), math.sin(course.omega * s)
    x, u = _axis(course, 0, share, growth, course.omega, cos, sin)
    tilt, turn = _axis(course, 2, share, growth, course.omega, cos, sin)
    z, w = _axis(course, 4, share, growth, 2.0 * course.omega, cos * cos - sin * sin, 2.0 * sin * cos)
    return x, tilt, z, u, turn, w


@kernel
def place(flight, s):
    """Place and velocity (x, z, u, w) of a flying ball at the time s."""
    t = s - flight.start
    x, z = flight.x + flight.u * t, flight.z + (flight.w - 0.5 * flight.gravity * t) * t
    return x, z, flight.u, flight.w - flight.gravity * t


@kernel
def gap(course, s, x, z, u, w):
    """The gap (m) under a ball at (x, z) with velocity (u, w), and its rate; also p along the bar."""
    bar_x, tilt, bar_z, bar_u, turn, bar_w = pose(course, s)
    cos, sin = math.cos(tilt), math.sin(tilt)
    x, z, u, w = x - bar_x, z - bar_z, u - bar_u, w - bar_w
    p, q = x * cos - z * sin, x * sin + z * cos
    along, across = u * cos - w * sin - turn * q, u * sin + w * cos + turn * p
    return q - 0.5 * course.curvature * p * p, across - course.curvature * p * along, p


@kernel
def launched(course, s, x, z, normal, tangent, gravity):
    """The `Flight` of a ball that leaves (x, z) on the bar with these velocities (m/s) over the bar's material."""
    bar_x, tilt, bar_z, bar_u, turn, bar_w = pose(course, s)
    rx, rz = x - bar_x, z - bar_z
    slope = tilt - math.atan(course.curvature * (rx * math.cos(tilt) - rz * math.sin(tilt)))
    cos, sin = math.cos(slope), math.sin(slope)
    u = bar_u + turn * rz + normal * sin + tangent * cos
    return Flight(s, x, z, u, bar_w - turn * rx + normal * cos - tangent * sin, gravity)


@kernel
def _sizes(course, k, frequency, begin):
    """Bounds of the first and second derivative of an axis from the time `begin` on."""
    size = math.hypot(course.new[k], course.new[k + 1])
    if begin >= course.begin + course.blend:
        return frequency * size, frequency * frequency * size
    size = max(size, math.hypot(course.old[k], course.old[k + 1]))
    change = math.hypot(course.new[k] - course.old[k], course.new[k + 1] - course.old[k + 1])
    growth = 1.5 / course.blend
    first = frequency * size + growth * change
    bent = 6.0 / (course.blend * course.blend)
    return first, frequency * frequency * size + 2.0 * growth * frequency * change + bent * change


@kernel
def bend_bound(course, flight, end):
    """Bound of |D''| until the time `end`, from bounds of place, velocity and acceleration relative to the bar."""
    span = end - flight.start
    x_1, x_2 = _sizes(course, 0, course.omega, flight.start)
    turn, turning = _sizes(course, 2, course.omega, flight.start)
    z_1, z_2 = _sizes(course, 4, 2.0 * course.omega, flight.start)
    bar_x, _, bar_z, _, _, _ = pose(course, flight.start)
    speed = abs(flight.u) + x_1 + max(abs(flight.w), abs(flight.w - flight.gravity * span)) + z_1
    reach = abs(flight.x - bar_x) + abs(flight.z - bar_z) + speed * span
    along = speed + turn * reach
    bend = flight.gravity + x_2 + z_2 + 2.0 * turn * speed + (turning + turn * turn) * reach
    return bend + abs(course.curvature) * (along * along + reach * bend)


@kernel
def deepest(course, flight, begin, end, tolerance):
    """How deep (m) the flight is in the bar from `begin` to `end` (s) at most, at the places that the search visits.

    Nowhere is it more than `tolerance` deeper than what is returned. The search ends at the first gap below minus the
    tolerance, or without a result, which is infinite.
    """
    bend = bend_bound(course, flight, end)
    s, deep = begin, 0.0
    for _ in range(MOST_STEPS):
        x, z, u, w = place(flight, s)
        value, rate, _ = gap(course, s, x, z, u, w)
        deep = max(deep, -value)
        if deep > tolerance or s >= end:
            return deep
        step = (rate + math.sqrt(rate * rate + 2.0 * bend * (value + tolerance))) / bend
        if s + step == s:
            return math.inf
        s = min(end, s + step)
    return math.inf
