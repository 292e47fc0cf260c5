"""First contact of a ball with a bar that moves up and down only, by brackets: it shares no formula with the model.

The gap under the ball is gap(t) = v t - g t^2/2 - (z(t) - z(0)), z a sinusoid of angular frequency w and peak
acceleration A w^2. Its second derivative is zero where sin(angle) = g / (A w^2). Between two such times the gap is
convex or concave, so it has at most two roots there: those of a convex stretch lie on either side of its minimum, a
concave stretch that begins above the bar has one at most, and each is bracketed and bisected. Nothing is sampled.
"""

from __future__ import annotations

import math

import numpy as np

from vr_envs.models.jit import kernel

CONTACT = np.dtype(
    [
        ("time", "f8"),  # s, from the launch
        ("slope", "f8"),  # m/s, rate of the gap there
        ("closest", "f8"),  # m, smallest absolute minimum of the gap up to there; infinite without one
        ("scale", "f8"),  # m, sum of the sizes of the terms whose difference is the gap there
    ]
)
"""The first contact of one launch."""

_HALVINGS = 200  # at most: a bracket has shrunk to neighbouring numbers long before


@kernel
def _gap(order, t, cos, sin, v, gravity, w):
    """The gap (order 0) or its rate (order 1)."""
    if order == 0:
        return v * t - 0.5 * gravity * t * t - (cos * math.cos(w * t) + sin * math.sin(w * t) - cos)
    return v - gravity * t - w * (sin * math.cos(w * t) - cos * math.sin(w * t))


@kernel
def _bisect(order, low, high, rising, launch):
    """Where the gap, or its rate, changes sign between two times, upwards if `rising`, to neighbouring numbers."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            break
        if (_gap(order, middle, *launch) < 0.0) == rising:
            low = middle
        else:
            high = middle
    return high


@kernel
def first_contact(cos, sin, v, gravity, w):
    """The first contact after a launch from the surface: the four numbers of `CONTACT`.

    Args:
        cos, sin: z of the bar is cos * cos(w t) + sin * sin(w t), m.
        v: velocity of the ball, m/s, above that of the bar.
        gravity: m/s^2.
        w: rad/s.
    """
    launch = (cos, sin, v, gravity, w)
    size = math.hypot(cos, sin)
    ratio = gravity / (size * w * w)
    turn = 2.0 * math.pi
    begin, closest = 0.0, math.inf
    # the angle of z = size sin(angle), and those angles in a turn from which the gap is convex and concave
    angle = math.atan2(cos, sin)
    bends = math.asin(min(1.0, ratio))
    convex_from, concave_from = (bends - angle) % turn, (math.pi - bends - angle) % turn
    convex = ratio < 1.0 and concave_from < convex_from
    turns = 0
    while True:
        if ratio >= 1.0:  # never convex: all of the flight is one stretch
            end = 2.0 * (v + w * size) / gravity + math.sqrt(8.0 * size / gravity)
        elif convex:
            end = (concave_from + turn * turns) / w
        else:
            end = (convex_from + turn * turns) / w
        if convex:
            if _gap(1, begin, *launch) < 0.0 and _gap(1, end, *launch) > 0.0:
                lowest = _bisect(1, begin, end, True, launch)
                closest = min(closest, abs(_gap(0, lowest, *launch)))
                if _gap(0, lowest, *launch) <= 0.0:
                    time = _bisect(0, begin, lowest, False, launch)
                    break
            elif _gap(0, end, *launch) <= 0.0:
                time = _bisect(0, begin, end, False, launch)
                break
        elif _gap(0, end, *launch) <= 0.0:
            if begin == 0.0:  # the gap is zero here too: the contact is beyond the highest point
                begin = _bisect(1, begin, end, False, launch)
            time = _bisect(0, begin, end, False, launch)
            break
        begin = end
        if convex == (concave_from > convex_from):
            turns += 1
        convex = not convex
    scale = size * (2.0 + w * time) + abs(v) * time + 0.5 * gravity * time * time
    return time, _gap(1, time, *launch), closest, scale


@kernel
def first_contacts(motions, velocities, gravity, w, found):
    """`first_contact` for the motions (n, 6) of a bar, of which z alone moves, into `found` (n,) of dtype `CONTACT`."""
    for i in range(motions.shape[0]):
        row = found[i]
        row.time, row.slope, row.closest, row.scale = first_contact(
            motions[i, 4], motions[i, 5], velocities[i], gravity, w
        )
