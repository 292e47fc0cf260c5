"""A ball resting on the bar: carried (it sticks) or rolling, until the bar falls away from under it.

Along the bar, with tangent t = (cos, -sin) and normal n = (sin, cos) of the tilt, the ball's centre is at
c + d t. In the rotating frame
    N/m = c'' . n + g cos(tilt) - 2 d' tilt' - d tilt''                       (normal force per mass)
    (1 + k) d'' = g sin(tilt) - c'' . t + d tilt'^2 - k R tilt''              (rolling, k = I/(m R^2))
and the ball leaves where N falls to zero: at the phase arcsin(g / peak acceleration) of a bar that moves up and
down only.
"""

from __future__ import annotations

import math

import numpy as np

from vr_envs.models.bar import frame_at
from vr_envs.models.jit import kernel
from vr_envs.models.root import MAX_MARCH, TIME_RESOLUTION, free_step

_STAGES = 5  # Gauss-Legendre collocation of order 10
_PARTS = 32  # rolling steps per base cycle at least: 1e-15 relative for the third harmonic


def _collocation() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes c on [0, 1], weights b, and the matrix A of the collocation method."""
    nodes, weights = np.polynomial.legendre.leggauss(_STAGES)
    c = 0.5 * (nodes + 1.0)
    powers = np.arange(_STAGES)
    integrals = c[:, None] ** (powers + 1) / (powers + 1)
    return c, 0.5 * weights, integrals @ np.linalg.inv(c[:, None] ** powers)


_C, _B, _A = _collocation()
_A2 = _A @ _A


@kernel
def support(frame, gravity, d, rate, pull):
    """Normal force per mass (m/s^2) on a ball at d with d' = `rate` and d'' = `pull`, and its time derivative.

    For a ball in flight that touches the bar they are minus the second and third derivative of the gap.
    """
    x, tilt, z, cos, sin, _, _ = frame
    normal_2, tangent_2 = x[2] * sin + z[2] * cos, x[2] * cos - z[2] * sin
    normal_3 = x[3] * sin + z[3] * cos
    force = normal_2 + gravity * cos - 2.0 * rate * tilt[1] - d * tilt[2]
    slope = normal_3 + tilt[1] * tangent_2 - gravity * sin * tilt[1]
    slope -= 2.0 * pull * tilt[1] + 3.0 * rate * tilt[2] + d * tilt[3]
    return force, slope


@kernel
def _support_curvature(limits, gravity, d, rate, pull, arm):
    """Bound on the absolute second derivative of the normal force; `pull` bounds |d''|, `arm` is k R."""
    x, t, z = limits
    c2, c3, c4 = x.d2 + z.d2, x.d3 + z.d3, x.d4 + z.d4
    fixed = c4 + 2.0 * t.d1 * c3 + t.d2 * c2 + t.d1 * t.d1 * c2 + gravity * (t.d2 + t.d1 * t.d1)
    # d''' is the derivative of the rolling law
    jerk = gravity * t.d1 + c3 + t.d1 * c2 + rate * t.d1 * t.d1 + 2.0 * d * t.d1 * t.d2 + arm * t.d3
    return fixed + 2.0 * (jerk * t.d1 + 2.0 * pull * t.d2 + rate * t.d3) + pull * t.d2 + 2.0 * rate * t.d3 + d * t.d4


@kernel
def carry(piece, limits, s, end, gravity, d):
    """Time at which a ball that sticks at `d` leaves, or `end` if it stays; certified first root of N."""
    curvature = _support_curvature(limits, gravity, abs(d), 0.0, 0.0, 0.0)
    for _ in range(MAX_MARCH):
        force, slope = support(frame_at(piece, s), gravity, d, 0.0, 0.0)
        if force <= 0.0:
            return s
        step = free_step(force, slope, curvature)
        if s + step >= end:
            return end
        s += step
        if step < TIME_RESOLUTION:
            return s
    return s


@kernel
def rolling_law(frame, gravity, inertia_ratio, radius):
    """d'' = forcing + stiffness d of a rolling ball (a frictionless one with inertia_ratio 0): the two numbers."""
    x, tilt, z, cos, sin, _, _ = frame
    forcing = gravity * sin - (x[2] * cos - z[2] * sin) - inertia_ratio * radius * tilt[2]
    return forcing / (1.0 + inertia_ratio), tilt[1] * tilt[1] / (1.0 + inertia_ratio)


@kernel
def _roll_step(piece, s, h, gravity, inertia_ratio, radius, d, rate):
    """One collocation step of the rolling law, which is linear in d and nearly a quadrature: Picard converges."""
    forcing, stiffness = np.empty(_STAGES), np.empty(_STAGES)
    pulls = np.empty(_STAGES)
    for i in range(_STAGES):
        forcing[i], stiffness[i] = rolling_law(frame_at(piece, s + _C[i] * h), gravity, inertia_ratio, radius)
        pulls[i] = forcing[i] + stiffness[i] * d
    for _ in range(4):  # each round gains stiffness h^2 < 1e-3
        stage = np.empty(_STAGES)
        for i in range(_STAGES):
            value = 0.0
            for j in range(_STAGES):
                value += _A2[i, j] * pulls[j]
            stage[i] = d + _C[i] * h * rate + h * h * value
        for i in range(_STAGES):
            pulls[i] = forcing[i] + stiffness[i] * stage[i]
    new_d, new_rate = d + h * rate, rate
    for i in range(_STAGES):
        new_d += h * h * _B[i] * (1.0 - _C[i]) * pulls[i]
        new_rate += h * _B[i] * pulls[i]
    return new_d, new_rate


@kernel
def roll(piece, limits, s, end, gravity, inertia_ratio, radius, half_length, d, rate):
    """Roll until the ball leaves the bar's surface, passes its end, or `end`; returns (s, d, rate, left)."""
    x, t, z = limits
    longest = 2.0 * math.pi / piece.omega / _PARTS
    for _ in range(100 * MAX_MARCH):
        frame = frame_at(piece, s)
        forcing, stiffness = rolling_law(frame, gravity, inertia_ratio, radius)
        force, slope = support(frame, gravity, d, rate, forcing + stiffness * d)
        if force <= 0.0 or abs(d) > half_length or s >= end:
            return s, d, rate, force <= 0.0 and s < end
        pull = gravity + x.d2 + z.d2 + half_length * t.d1 * t.d1 + radius * t.d2
        curvature = _support_curvature(
            limits, gravity, half_length, abs(rate) + longest * pull, pull, inertia_ratio * radius
        )
        step = free_step(force, slope, curvature)
        done = step < TIME_RESOLUTION
        step = min(step, longest, end - s)
        d, rate = _roll_step(piece, s, step, gravity, inertia_ratio, radius, d, rate)
        s = end if step == end - s else s + step
        if done:
            return s, d, rate, True
    return s, d, rate, True
