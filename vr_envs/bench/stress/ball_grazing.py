"""Grazing launches: flights that begin hardly faster than the bar, and flights that hardly pass over its next crest.

Each contact that the model's search finds is judged by a search of another hand (`ball_gap`): before it the ball is
nowhere deeper than `DEEPEST` in the bar, and at it no further than that from the surface. Where two launches meet the
bar in different swings, a launch between them grazes a crest: it is closed in on by halving.
"""

from __future__ import annotations

import math

import numpy as np

from vr_envs.bench.stress.ball_gap import Course, deepest, gap, launched, place
from vr_envs.bench.stress.clock import thread_time
from vr_envs.bench.stress.trial import CASE, Outcome, note_time
from vr_envs.models.bar import Piece, bounds, frame_at
from vr_envs.models.flight import BOUNCED, flight
from vr_envs.models.jit import kernel
from vr_envs.models.noise import uniform
from vr_envs.models.root import UNDECIDED

DEEPEST = 1e-15  # m
LAUNCHES = 12  # launch velocities of a case, one decade after the other
_HALVINGS = 50
_GRAVITY = 9.81

REASONS = (
    "the model's search did not end",
    "an earlier contact was missed",
    "no contact is where one was found",
    "the search that judges did not end",
)
_UNDECIDED, _MISSED, _NO_CONTACT, _UNJUDGED = range(1, len(REASONS) + 1)


@kernel
def _launch(case, times, trace, course, piece, limits, s, end, x, z, normal, tangent, scratch):
    """Launch a ball from the bar, judge its contact and return the time of it, or `end`."""
    ball = launched(course, s, x, z, normal, tangent, _GRAVITY)
    tan = math.tan(limits[1].d0)
    frame = frame_at(piece, s)
    begin = thread_time(scratch)
    hit, ds = flight(
        piece, limits, tan, s, frame, end, ball.x, ball.z, ball.u, ball.w, _GRAVITY, BOUNCED, None, None
    )  # fmt: skip
    note_time(case, times, trace, thread_time(scratch) - begin)
    case.at = case.count
    case.count += 1
    case.judged += 1
    if ds == UNDECIDED:
        case.code = _UNDECIDED
        return end
    deep = deepest(course, ball, s, s + ds, DEEPEST)
    if deep == math.inf:
        case.code = _UNJUDGED
    elif deep > DEEPEST:
        case.code = _MISSED
    if hit:
        there = place(ball, s + ds)
        value, _, _ = gap(course, s + ds, there[0], there[1], there[2], there[3])
        deep = max(deep, abs(value))
        if abs(value) > DEEPEST and case.code == 0:
            case.code = _NO_CONTACT
    case.worst = max(case.worst, deep)
    return s + ds


@kernel
def graze(case, times, trace, seed, scratch):
    """One bar, one instant, launches of all velocities, and those that graze."""
    omega = 2.0 * math.pi * 10.0 ** (1.5 * uniform(seed, 0) + 0.5)  # 3 to 100 Hz
    period = 2.0 * math.pi / omega
    z = (5.0 + 95.0 * uniform(seed, 1)) / (4.0 * omega * omega)
    tilt = min(0.3, 200.0 / (omega * omega)) * (2.0 * uniform(seed, 2) - 1.0)
    x = 20.0 / (omega * omega) * (2.0 * uniform(seed, 3) - 1.0)
    turned = 2.0 * math.pi * uniform(seed, 4)
    new = (x, 0.5 * x, tilt, -0.7 * tilt, z * math.cos(turned), z * math.sin(turned))
    if uniform(seed, 5) < 0.3:  # a bar that moves up and down only
        new = (0.0, 0.0, 0.0, 0.0, new[4], new[5])
    old, blend = new, 0.0
    if uniform(seed, 6) < 0.3:
        old, blend = (-new[1], new[0], new[3], new[2], -new[4], new[5]), period
    course = Course(omega, 0.0, period, old, new, 0.0)
    change = (
        new[0] - old[0], new[1] - old[1], new[2] - old[2], new[3] - old[3], new[4] - old[4], new[5] - old[5],
    )  # fmt: skip
    piece = Piece(omega, 0.0, blend, old, change if blend > 0.0 else old, None, (0.0, 0.0, 0.0), None)
    limits = bounds(piece)
    s = 0.7 * period * uniform(seed, 7)
    frame = frame_at(piece, s)
    d = 0.02 * (2.0 * uniform(seed, 8) - 1.0)
    at_x, at_z = frame.x[0] + d * frame.cos, frame.z[0] - d * frame.sin
    tangent = 0.1 * (2.0 * uniform(seed, 9) - 1.0)
    slower, before = 0.0, -1.0
    for k in range(LAUNCHES):
        faster = 10.0 ** (-10.0 + k + uniform(seed, 10 + k))
        after = _launch(case, times, trace, course, piece, limits, s, period, at_x, at_z, faster, tangent, scratch)
        if case.code != 0:
            return
        if before >= 0.0 and after - before > 0.05 * period:
            low, high, time = slower, faster, before
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                found = _launch(
                    case, times, trace, course, piece, limits, s, period, at_x, at_z, middle, tangent, scratch
                )
                if case.code != 0:
                    return
                if found - time > 0.5 * (after - time):
                    high = middle
                else:
                    low, time = middle, found
        slower, before = faster, after


def run(first: int, number: int, trace: np.ndarray) -> Outcome:
    """Cases of grazing launches."""
    outcome = Outcome()
    for seed in range(first, first + number):
        case = np.zeros(1, CASE)
        graze(case[0], outcome.times, trace, seed, _SCRATCH)
        outcome.take(seed, case[0], REASONS)
    return outcome


_SCRATCH = np.zeros(2, np.int64)
