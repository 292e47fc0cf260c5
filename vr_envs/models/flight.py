"""Flight of a ball over a moving bar, from one contact to the next: the certified first root of the gap."""

from __future__ import annotations

import math

from vr_envs.models.jit import kernel
from vr_envs.models.rolling import STILL
from vr_envs.models.root import MAX_MARCH, TIME_RESOLUTION, UNDECIDED, certified_step, converged
from vr_envs.models.support import flight_support, forces_at, normal_force
from vr_envs.models.surface import (
    bend,
    clear_level,
    contact_at,
    gap,
    gap_at,
    gap_bounds,
    high_flight,
    opening,
    steepness,
)

AIRBORNE, BOUNCED, RELEASED = 0, 1, 2  # how a flight begins
_HALVINGS = 60  # of a sampling interval: below the resolution of time


@kernel
def _sampled(piece, s, frame, end, gap_0, rx, rz, u, w, gravity, curve, textbook):
    """First contact as Bell's simulator finds it: samples of the gap, then a binary search. Returns (hit, duration).

    Two contacts between samples are missed, and the ball passes through the bar's crest: that is the method.
    """
    interval = math.pi / piece.omega / textbook.samples
    before = 0.0
    while True:
        after = min(before + interval, end - s)
        value, _, _ = gap(piece, s, frame, after, gap_0, rx, rz, u, w, gravity, curve)
        if value <= 0.0:
            break
        if after == end - s:  # s + (end - s) may be rounded to less than the end
            return False, after
        before = after
    for _ in range(_HALVINGS):
        middle = 0.5 * (before + after)
        value, _, _ = gap(piece, s, frame, middle, gap_0, rx, rz, u, w, gravity, curve)
        if value > 0.0:
            before = middle
        else:
            after = middle
    return s + after < end, after


@kernel
def bend_at(frame, gravity, at, rx, u, curve):
    """Second derivative of the gap of a ball that leaves the surface at the `Contact` `at`."""
    if curve is None:
        f = frame
        return bend(gravity, f.x[2], f.tilt[2], f.z[2], u - f.x[1], f.tilt[1], rx, f.sin / f.cos)
    else:
        # -M for a ball with this p' (support.py), and the turn of the velocity with which the gap opens
        slope, sigma = curve.curvature * at.d, steepness(at.d, curve)
        rate = (at.tangent - slope * at.normal) / sigma
        force = normal_force(forces_at(frame, gravity), at.d, rate, curve)
        return 2.0 * slope * frame.tilt[1] * at.normal * sigma - force


@kernel
def flight(piece, limits, tan, s, frame, end, x, z, u, w, gravity, contact, curve, textbook):
    """First contact of a flight from time s: (hit, duration), the duration UNDECIDED if the search does not end.

    `contact`: AIRBORNE, BOUNCED (leaving the surface with a velocity) or RELEASED (leaving it without). `limits` and
    `tan` bound the bar's motion and its slope.
    """
    at = contact_at(frame, x, z, u, w, curve)
    rx, rz = x - frame.x[0], z - frame.z[0]
    gap_0, slowest = 0.0, 0.0
    if contact == AIRBORNE:  # cut off by the end of a piece: where it hardly leaves the bar it begins as if released
        gap_0, slowest = gap_at(frame, x, z, curve), STILL
    elif contact == RELEASED:
        slowest = -math.inf
    if gap_0 <= 0.0 and at.normal <= slowest:
        return True, 0.0
    if textbook is not None:
        return _sampled(piece, s, frame, end, gap_0, rx, rz, u, w, gravity, curve, textbook)
    curvature, jerk = gap_bounds(limits, tan, rx, rz, u, w, end - s, gravity, curve)
    ds = 0.0
    if contact == RELEASED:
        # gap = -N s^2/2 - N' s^3/6 with N <= 0: begin where it has grown above rounding
        force, slope = flight_support(frame, gravity, at.d, at.tangent, curve)
        ds = min(1e-3 / piece.omega, math.sqrt(2e-14 / max(-force, 1e-12)))
        if slope < 0.0:
            ds = min(ds, (6e-14 / -slope) ** (1.0 / 3.0))
        elif slope > 0.0:  # the bar comes back at -3 N/N': begin before, or where it is not yet in the ball
            ds = min(ds, max(-force / slope, (6e-18 / slope) ** (1.0 / 3.0)))
    elif gap_0 <= 0.0:
        second = bend_at(frame, gravity, at, rx, u, curve)
        gap_0, ds = 0.0, certified_step(0.0, opening(at, frame, curve), second, jerk, curvature)
    if contact != RELEASED:
        level = clear_level(limits, tan, rx, rz, u, w, end - s, gravity, curve)
        above, below = high_flight(z, w, level, gravity)
        if above <= ds < below:
            ds = below
    for _ in range(MAX_MARCH):
        if s + ds >= end:
            return False, end - s
        value, slope, second = gap(piece, s, frame, ds, gap_0, rx, rz, u, w, gravity, curve)
        if value <= 0.0:
            return True, ds
        step = certified_step(value, slope, second, jerk, curvature)
        if converged(s + ds, step):
            return True, ds
        ds += step
        # over a falling away gap the step left out a cubic term alone: it is below the resolution of time
        if second < 0.0 and slope < 0.0 and jerk * step * step * step < -TIME_RESOLUTION * slope:
            return s + ds < end, min(ds, end - s)
    return False, UNDECIDED
