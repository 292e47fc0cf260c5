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
from vr_envs.models.root import MAX_MARCH, converged, free_step

_STAGES = 5  # Gauss-Legendre collocation of order 10
MAX_PICARD = 60
STEADY = 1e-3  # share by which the supporting force may change during a chatter that is summed in closed form
STILL = 1e-12  # m/s, normal velocity below which a supported ball is at rest
UNDECIDED = -1.0  # s, in place of a time
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
def flight_support(frame, gravity, d, rate):
    """`support` for a ball that touches the bar in free flight."""
    forcing, stiffness = rolling_law(frame, gravity, 0.0, 0.0)
    return support(frame, gravity, d, rate, forcing + stiffness * d)


@kernel
def pull_bound(limits, gravity, reach, radius):
    """Bound on |d''| of a ball in flight or rolling, within `reach` of the bar's centre."""
    x, t, z = limits
    return gravity + x.d2 + z.d2 + reach * t.d1 * t.d1 + radius * t.d2


@kernel
def support_curvature(limits, gravity, d, rate, pull, arm):
    """Bound on the absolute second derivative of the normal force; `pull` bounds |d''|, `arm` is k R."""
    x, t, z = limits
    c2, c3, c4 = x.d2 + z.d2, x.d3 + z.d3, x.d4 + z.d4
    fixed = c4 + 2.0 * t.d1 * c3 + t.d2 * c2 + t.d1 * t.d1 * c2 + gravity * (t.d2 + t.d1 * t.d1)
    # d''' is the derivative of the rolling law
    jerk = gravity * t.d1 + c3 + t.d1 * c2 + rate * t.d1 * t.d1 + 2.0 * d * t.d1 * t.d2 + arm * t.d3
    return fixed + 2.0 * (jerk * t.d1 + 2.0 * pull * t.d2 + rate * t.d3) + pull * t.d2 + 2.0 * rate * t.d3 + d * t.d4


@kernel
def carry(piece, limits, s, end, gravity, d):
    """Time at which a ball that sticks at `d` leaves, or `end` if it stays: certified first root of N.

    Returns UNDECIDED if the search does not end.
    """
    curvature = support_curvature(limits, gravity, abs(d), 0.0, 0.0, 0.0)
    for _ in range(MAX_MARCH):
        force, slope = support(frame_at(piece, s), gravity, d, 0.0, 0.0)
        if force <= 0.0:
            return s
        step = free_step(force, slope, curvature)
        if s + step >= end:
            return end
        if converged(s, step):
            return s
        s += step
    return UNDECIDED


@kernel
def rolling_law(frame, gravity, inertia_ratio, radius):
    """d'' = forcing + stiffness d of a rolling ball (a frictionless one with inertia_ratio 0): the two numbers."""
    x, tilt, z, cos, sin, _, _ = frame
    forcing = gravity * sin - (x[2] * cos - z[2] * sin) - inertia_ratio * radius * tilt[2]
    return forcing / (1.0 + inertia_ratio), tilt[1] * tilt[1] / (1.0 + inertia_ratio)


@kernel
def _roll_step(piece, s, h, gravity, inertia_ratio, radius, d, rate):
    """One collocation step of the rolling law, which is linear in d and nearly a quadrature: Picard converges.

    A round gains a factor of stiffness h^2, which is below 1e-2 for tilts of a degree and below 1 for any allowed.
    """
    forcing, stiffness = np.empty(_STAGES), np.empty(_STAGES)
    pulls = np.empty(_STAGES)
    for i in range(_STAGES):
        forcing[i], stiffness[i] = rolling_law(frame_at(piece, s + _C[i] * h), gravity, inertia_ratio, radius)
        pulls[i] = forcing[i] + stiffness[i] * d
    stage = np.empty(_STAGES)
    for _ in range(MAX_PICARD):
        moved = 0.0
        for i in range(_STAGES):
            value = 0.0
            for j in range(_STAGES):
                value += _A2[i, j] * pulls[j]
            stage[i] = d + _C[i] * h * rate + h * h * value
        for i in range(_STAGES):
            pull = forcing[i] + stiffness[i] * stage[i]
            moved = max(moved, abs(pull - pulls[i]) - 1e-16 * abs(pull))
            pulls[i] = pull
        if moved <= 0.0:
            break
    new_d, new_rate = d + h * rate, rate
    for i in range(_STAGES):
        new_d += h * h * _B[i] * (1.0 - _C[i]) * pulls[i]
        new_rate += h * _B[i] * pulls[i]
    return new_d, new_rate


@kernel
def roll(piece, limits, s, end, gravity, inertia_ratio, radius, half_length, d, rate):
    """Roll until the ball leaves the bar's surface, passes its end, or `end`; returns (s, d, rate, left).

    The time is UNDECIDED if the search does not end.
    """
    longest = 2.0 * math.pi / piece.omega / _PARTS
    for _ in range(100 * MAX_MARCH):
        frame = frame_at(piece, s)
        forcing, stiffness = rolling_law(frame, gravity, inertia_ratio, radius)
        force, slope = support(frame, gravity, d, rate, forcing + stiffness * d)
        if force <= 0.0 or abs(d) > half_length or s >= end:
            return s, d, rate, force <= 0.0 and s < end
        pull = pull_bound(limits, gravity, half_length, radius)
        curvature = support_curvature(
            limits, gravity, half_length, abs(rate) + longest * pull, pull, inertia_ratio * radius
        )
        step = free_step(force, slope, curvature)
        done = converged(s, step)
        step = min(step, longest, end - s)
        d, rate = _roll_step(piece, s, step, gravity, inertia_ratio, radius, d, rate)
        s = end if step == end - s else s + step
        if done:
            return s, d, rate, True
    return UNDECIDED, d, rate, True


@kernel
def _place(state, frame, spin):
    """World position and velocity of a resting ball."""
    bx, tilt, bz, cos, sin, _, _ = frame
    turn = -tilt[1] * state.d
    state.x, state.z = bx[0] + state.d * cos, bz[0] - state.d * sin
    state.u = bx[1] + turn * sin + state.rate * cos
    state.w = bz[1] + turn * cos - state.rate * sin
    if spin is not None:
        state.spin = state.rate + spin.radius * tilt[1]


@kernel
def rest(state, piece, limits, s, end, params, spin):
    """Carry or roll the resting ball until it leaves the surface, the bar's end, or `end`; returns (time, frame)."""
    if spin is not None:
        s, state.d, state.rate, left = roll(
            piece,
            limits,
            s,
            end,
            params.gravity,
            spin.inertia_ratio,
            spin.radius,
            params.half_length,
            state.d,
            state.rate,
        )
    elif params.tangential_loss > 0.0:
        s = carry(piece, limits, s, end, params.gravity, state.d)
        left = s < end
    else:
        s, state.d, state.rate, left = roll(
            piece, limits, s, end, params.gravity, 0.0, 0.0, params.half_length, state.d, state.rate
        )
    if s == UNDECIDED:
        state.fault = True
        s = end
    frame = frame_at(piece, s)
    _place(state, frame, spin)
    state.lost = abs(state.d) > params.half_length
    state.resting = not left
    return s, frame


@kernel
def settle(state, piece, frame, limits, s, end, normal, tangent, d, params, spin):
    """After an impact: put the ball to rest if, in the time that the chatter will take, the force hardly changes.

    The bound on the change is certified, so the bar cannot fall away during the chatter. Returns the time, which has
    moved on if the ball has come to rest.
    """
    force, jerk = flight_support(frame, params.gravity, d, tangent)
    if force <= 0.0:
        return s
    ratio, radius = 0.0, 0.0
    if spin is not None:
        ratio, radius = spin.inertia_ratio, spin.radius
    wait = 0.0
    if normal > STILL:
        lost = 1.0 - params.restitution
        wait = 2.0 * normal / (force * lost)
        pull = pull_bound(limits, params.gravity, params.half_length, radius)
        curvature = support_curvature(limits, params.gravity, abs(d), abs(tangent), pull, ratio * radius)
        if not (abs(jerk) + 0.5 * curvature * wait) * wait < STEADY * force:  # nan without losses
            return s
        # accumulation time, with the first correction for a changing effective gravity
        wait *= 1.0 - 2.0 / 3.0 * jerk * normal / (lost * force * force)
        if s + wait >= end:
            return s
    state.resting = True
    # between impacts the ball is pulled along the bar as a free, or in the mean a rolling, one
    halfway = frame_at(piece, s + 0.5 * wait)
    forcing, stiffness = rolling_law(halfway, params.gravity, ratio, radius)
    pull = forcing + stiffness * d
    if spin is None and params.tangential_loss > 0.0:
        # flights of 2 W alpha^k / N, and (1 - c) of the velocity kept at each of infinitely many impacts
        first, alpha = 2.0 * normal / force, params.restitution
        kept = alpha * (1.0 - params.tangential_loss)
        drift = tangent / (1.0 - kept) + pull * first / (1.0 - alpha * alpha) * (0.5 + kept / (1.0 - kept))
        state.d, state.rate = d + drift * first, 0.0
    else:
        state.d, state.rate = d + (tangent + 0.5 * pull * wait) * wait, tangent + pull * wait
    return s + wait
