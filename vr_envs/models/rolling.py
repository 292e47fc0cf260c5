"""Rolling and sliding on the moving bar: collocation of high order, and the certified moment at which the ball leaves.

A slip that begins or ends under a friction limit is looked for at the ends of steps, 64 of them in a base cycle, and
then located to rounding.
"""

from __future__ import annotations

import math

import numpy as np

from vr_envs.models.bar import frame_at
from vr_envs.models.jit import kernel
from vr_envs.models.root import MAX_MARCH, UNDECIDED, converged, free_step
from vr_envs.models.support import (
    Forces,
    forces_at,
    grip_force,
    gripping,
    normal_force,
    pull_bound,
    sliding,
    support,
    support_curvature,
)
from vr_envs.models.surface import steepness

_STAGES = 5  # Gauss-Legendre collocation of order 10
MAX_PICARD = 60
STILL = 1e-12  # m/s, velocity below which a supported ball is at rest, or a touching one does not slip
_PARTS = 32  # rolling steps per base cycle at least: 1e-15 relative for the third harmonic
_HALVINGS = 55  # of a step: below the resolution of time
_MOMENT = 1e-7  # of the longest step of a ball that grips and slides


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
def inertia_of(spin):
    """I/(m R^2) and R of the ball; both 0 without spin."""
    if spin is None:
        return 0.0, 0.0
    else:
        return spin.inertia_ratio, spin.radius


@kernel
def _pull(forces, d, rate, direction, spin, friction, curve):
    if friction is not None:
        if direction != 0.0:
            return sliding(forces, d, rate, direction, friction.coefficient, curve)
    inertia_ratio, radius = inertia_of(spin)
    return gripping(forces, d, rate, inertia_ratio, radius, curve)


@kernel
def _roll_step(piece, s, h, d, rate, rim, direction, gravity, spin, friction, curve):
    """One collocation step: (d, rate, rim) at s + h, `rim` being R times the spin of a sliding ball.

    The law is nearly a quadrature, so Picard's iteration converges: a round gains a factor of about (tilt' h)^2.
    """
    along, across, turn, turning = np.empty(_STAGES), np.empty(_STAGES), np.empty(_STAGES), np.empty(_STAGES)
    pulls = np.empty(_STAGES)
    for i in range(_STAGES):
        f = forces_at(frame_at(piece, s + _C[i] * h), gravity)
        along[i], across[i], turn[i], turning[i] = f
        pulls[i] = _pull(f, d, rate, direction, spin, friction, curve)
    rates, places = _stages(pulls, h, d, rate)
    for _ in range(MAX_PICARD):
        moved = 0.0
        for i in range(_STAGES):
            forces = Forces(along[i], across[i], turn[i], turning[i])
            pull = _pull(forces, places[i], rates[i], direction, spin, friction, curve)
            moved = max(moved, abs(pull - pulls[i]) - 1e-16 * abs(pull))
            pulls[i] = pull
        rates, places = _stages(pulls, h, d, rate)
        if moved <= 0.0:
            break
    if friction is not None and spin is not None:
        if direction != 0.0:
            for i in range(_STAGES):
                forces = Forces(along[i], across[i], turn[i], turning[i])
                force = normal_force(forces, places[i], rates[i], curve) / steepness(places[i], curve)
                rim += h * _B[i] * direction * friction.coefficient * force / spin.inertia_ratio
    new_d, new_rate = d + h * rate, rate
    for i in range(_STAGES):
        new_d += h * h * _B[i] * (1.0 - _C[i]) * pulls[i]
        new_rate += h * _B[i] * pulls[i]
    return new_d, new_rate, rim


@kernel
def _stages(pulls, h, d, rate):
    """Rates and places at the nodes of a step with the given accelerations there."""
    rates, places = np.empty(_STAGES), np.empty(_STAGES)
    for i in range(_STAGES):
        once, twice = 0.0, 0.0
        for j in range(_STAGES):
            once += _A[i, j] * pulls[j]
            twice += _A2[i, j] * pulls[j]
        rates[i] = rate + h * once
        places[i] = d + _C[i] * h * rate + h * h * twice
    return rates, places


@kernel
def _bounded_step(limits, longest, gravity, half_length, rate, arm, curve):
    """A step and bounds of |p'| and |p''| during it; on a curved bar each depends on the other."""
    pull = pull_bound(limits, gravity, half_length, abs(rate), arm, curve)
    if curve is not None:
        while True:
            fastest = abs(rate) + 2.0 * longest * pull
            larger = pull_bound(limits, gravity, half_length, fastest, arm, curve)
            if larger <= 2.0 * pull:
                return longest, fastest, larger
            longest *= 0.5
    return longest, abs(rate) + longest * pull, pull


@kernel
def roll(piece, limits, s, end, d, rate, gravity, half_length, spin, curve):
    """Roll, or slide without friction, until the ball leaves the surface, passes the bar's end, or `end`.

    Returns (s, d, rate, left); the time is UNDECIDED if the search does not end. The moment is certified.
    """
    inertia_ratio, radius = inertia_of(spin)
    longest = 2.0 * math.pi / piece.omega / _PARTS
    for _ in range(100 * MAX_MARCH):
        frame = frame_at(piece, s)
        pull = gripping(forces_at(frame, gravity), d, rate, inertia_ratio, radius, curve)
        force, slope = support(frame, gravity, d, rate, pull, curve)
        if force <= 0.0 or abs(d) > half_length or s >= end:
            return s, d, rate, force <= 0.0 and s < end
        h, fastest, pull = _bounded_step(limits, longest, gravity, half_length, rate, inertia_ratio * radius, curve)
        curvature = support_curvature(limits, gravity, half_length, fastest, pull, inertia_ratio * radius, curve)
        step = free_step(force, slope, curvature)
        done = converged(s, step)
        step = min(step, h, end - s)
        d, rate, _ = _roll_step(piece, s, step, d, rate, 0.0, 0.0, gravity, spin, None, curve)
        s = end if step == end - s else s + step
        if done:
            return s, d, rate, True
    return UNDECIDED, d, rate, True


@kernel
def slip_of(frame, d, rate, rim, spin, curve):
    """Velocity of the ball's surface over the bar's at the contact, m/s."""
    slip = steepness(d, curve) * rate
    if spin is not None:
        slip -= rim - spin.radius * frame.tilt[1]
    return slip


@kernel
def _go_on(piece, s, h, d, rate, rim, direction, gravity, sticks, spin, friction, curve):
    """A step of a ball that grips (direction 0) or slides: (d, rate, rim)."""
    if direction == 0.0 and sticks:
        return d, 0.0, rim
    d, rate, rim = _roll_step(piece, s, h, d, rate, rim, direction, gravity, spin, friction, curve)
    if spin is not None:
        if direction == 0.0:
            rim = steepness(d, curve) * rate + spin.radius * frame_at(piece, s + h).tilt[1]
    return d, rate, rim


@kernel
def _margin(frame, d, rate, rim, direction, gravity, sticks, spin, friction, curve):
    """A number that is positive as long as the ball goes on gripping, or sliding, on the bar."""
    forces = forces_at(frame, gravity)
    force = normal_force(forces, d, rate, curve)
    if direction != 0.0:
        return min(force, direction * slip_of(frame, d, rate, rim, spin, curve))
    inertia_ratio, radius = inertia_of(spin)
    need = grip_force(forces, d, rate, inertia_ratio, radius, sticks, curve)
    return min(force, friction.coefficient * force - abs(need))


@kernel
def grip_or_slip(piece, s, end, d, rate, rim, gravity, half_length, sticks, spin, friction, curve):
    """Roll (or stick) and slide by Coulomb's law until the ball leaves, passes the bar's end, or `end`.

    `rim` is R times the spin. Returns (s, d, rate, rim, left); the time is UNDECIDED if the search does not end.
    """
    inertia_ratio, radius = inertia_of(spin)
    longest = 2.0 * math.pi / piece.omega / (2 * _PARTS)
    slip = slip_of(frame_at(piece, s), d, rate, rim, spin, curve)
    direction = 0.0 if abs(slip) < STILL else math.copysign(1.0, slip)
    for _ in range(100 * MAX_MARCH):
        frame = frame_at(piece, s)
        forces = forces_at(frame, gravity)
        force = normal_force(forces, d, rate, curve)
        if direction == 0.0 and sticks:
            rate = 0.0
        if force <= 0.0 or abs(d) > half_length or s >= end:
            return s, d, rate, rim, force <= 0.0 and s < end
        if direction == 0.0:
            need = grip_force(forces, d, rate, inertia_ratio, radius, sticks, curve)
            if abs(need) > friction.coefficient * force:
                direction = -math.copysign(1.0, need)
        h = min(longest, end - s)
        after = _go_on(piece, s, h, d, rate, rim, direction, gravity, sticks, spin, friction, curve)
        margin = _margin(frame_at(piece, s + h), *after, direction, gravity, sticks, spin, friction, curve)
        if margin < 0.0:
            free = 0.0
            for _ in range(_HALVINGS):
                middle = 0.5 * (free + h)
                trial = _go_on(piece, s, middle, d, rate, rim, direction, gravity, sticks, spin, friction, curve)
                frame = frame_at(piece, s + middle)
                if _margin(frame, *trial, direction, gravity, sticks, spin, friction, curve) > 0.0:
                    free = middle
                else:
                    h, after = middle, trial
            if s + h == s:  # on the verge of gripping, or of leaving: which it is shows a moment later
                h = min(_MOMENT * longest, end - s)
                after = _go_on(piece, s, h, d, rate, rim, direction, gravity, sticks, spin, friction, curve)
            frame = frame_at(piece, s + h)
            if direction == 0.0:
                need = grip_force(forces_at(frame, gravity), after[0], after[1], inertia_ratio, radius, sticks, curve)
                direction = -math.copysign(1.0, need)
            elif direction * slip_of(frame, *after, spin, curve) <= 0.0:
                direction = 0.0
        s = end if h == end - s else s + h
        d, rate, rim = after
    return UNDECIDED, d, rate, rim, True
