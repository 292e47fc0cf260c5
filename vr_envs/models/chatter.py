"""The end of a chatter: infinitely many impacts in a finite time, summed once the supporting force hardly changes."""

from __future__ import annotations

import math

from vr_envs.models.bar import frame_at
from vr_envs.models.impact import collide
from vr_envs.models.jit import kernel
from vr_envs.models.rolling import STILL, inertia_of
from vr_envs.models.support import flight_support, forces_at, gripping, normal_force, pull_bound, support_curvature
from vr_envs.models.surface import steepness

STEADY = 1e-3  # share by which the supporting force may change during a chatter that is summed in closed form
_EVEN = 1e-6  # share by which a restitution that depends on the speed may differ from its limit in such a chatter
_BLUR = 1e-12  # m, how far a ball may slip in a chatter whose slip is not summed


@kernel
def _positive_part(mean, deviation):
    """Expectation of max(0, mean + deviation N), N standard normal."""
    t = mean / deviation
    return mean * 0.5 * math.erfc(-t / math.sqrt(2.0)) + deviation * math.exp(-0.5 * t * t) / math.sqrt(2.0 * math.pi)


@kernel
def mean_restitution(restitution, scatter):
    """Mean of the restitution over its scatter, which is clipped to [0, 1]."""
    if scatter is not None:
        deviation = scatter.restitution
        if 9.0 * deviation > min(restitution, 1.0 - restitution):  # else the clipping is below rounding
            return _positive_part(restitution, deviation) - _positive_part(restitution - 1.0, deviation)
    return restitution


@kernel
def settle(
    state, piece, frame, limits, s, end, contact, normal, tangent, params, scatter, spin, friction, softening, curve
):
    """After an impact: put the ball to rest if, in the time that the chatter will take, the force hardly changes.

    `contact` is where it was, `normal` and `tangent` the velocities with which the ball leaves it. The bound on the
    change is certified, so the bar cannot fall away during the chatter. With scatter the sum has the mean restitution
    and the smooth normal; a deviated one would keep a ball that moves along the bar bouncing a little longer. Returns
    the time, which has moved on if the ball has come to rest.
    """
    d = contact.d
    opening, rate = normal * steepness(d, curve), tangent / steepness(d, curve)
    forces = forces_at(frame, params.gravity)
    force = normal_force(forces, d, rate, curve)
    alpha = mean_restitution(params.restitution, scatter)
    lost = 1.0 - alpha
    if force <= 0.0:
        return s
    if normal > STILL and 1.8 * opening > (end - s) * force * lost:  # most impacts: the chatter would not end in time
        return s
    _, jerk = flight_support(frame, params.gravity, d, tangent, curve)
    inertia_ratio, radius = inertia_of(spin)
    wait = 0.0
    if normal > STILL:
        wait = 2.0 * opening / (force * lost)
        if not abs(jerk) * wait < STEADY * force:  # nan without losses
            return s
        if spin is None and params.tangential_loss > 0.0:
            # the force changes with the velocity along the bar, which the impacts take away
            if not abs(force - normal_force(forces, d, 0.0, curve)) < STEADY * force:
                return s
        arm = inertia_ratio * radius
        pull = pull_bound(limits, params.gravity, params.half_length, abs(rate), arm, curve)
        fastest = abs(rate) + wait * pull
        curvature = support_curvature(limits, params.gravity, abs(d) + wait * fastest, fastest, pull, arm, curve)
        if not (abs(jerk) + 0.5 * curvature * wait) * wait < STEADY * force:
            return s
        if softening is not None:
            even = _EVEN if scatter is None else STEADY
            if softening.exponent * normal > even * lost * softening.speed:
                return s
        if friction is not None:
            if scatter is None and wait * (abs(tangent) + abs(state.spin)) > _BLUR:
                return s
        # accumulation time, with the first correction for a changing effective gravity
        wait *= 1.0 - 2.0 / 3.0 * jerk * opening / (lost * force * force)
        if s + wait >= end:
            return s
    state.resting = True
    middle = forces_at(frame_at(piece, s + 0.5 * wait), params.gravity)
    if friction is not None:
        after = rate
        if scatter is not None:
            # roughness keeps a ball that moves along the bar bouncing: what is left acts as one impact of its impulse
            sigma, surface_spin = steepness(d, curve), 0.0
            if spin is not None:
                surface_spin = state.spin - radius * frame.tilt[1]
            impulse = force * wait / sigma - normal
            pulled = tangent + sigma * gripping(middle, d, rate, 0.0, 0.0, curve) * wait
            _, tangent, surface_spin = collide(
                -impulse / (1.0 + alpha), pulled, surface_spin, alpha, params.tangential_loss, spin, friction
            )
            if spin is not None:
                state.spin = surface_spin + radius * frame.tilt[1]
            after = tangent / sigma
        state.d, state.rate = d + 0.5 * (rate + after) * wait, after
        return s + wait
    # between impacts the ball is pulled along the bar as a free, or in the mean a rolling, one
    pull = gripping(middle, d, rate, inertia_ratio, radius, curve)
    if spin is None and params.tangential_loss > 0.0:
        # flights of 2 W alpha^k / M, and (1 - c) of the velocity kept at each of infinitely many impacts
        first = 2.0 * opening / force
        kept = alpha * (1.0 - params.tangential_loss)
        drift = rate / (1.0 - kept) + pull * wait / (1.0 + alpha) * (0.5 + kept / (1.0 - kept))
        state.d, state.rate = d + drift * first, 0.0
    else:
        state.d, state.rate = d + (rate + 0.5 * pull * wait) * wait, rate + pull * wait
    return s + wait
