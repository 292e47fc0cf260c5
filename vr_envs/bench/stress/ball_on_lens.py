"""Trial of the ball on a lens in three dimensions: glass nearly as wide as its sphere, balls nearly as large as it.

Every flight of the log is searched for a passage through the glass by a routine of its own, with the sphere's equation
h - kappa (x^2 + y^2 + h^2)/2 = 0 for the ball's centre and steps bounded as in `ball_gap`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vr_envs.bench.stress.clock import thread_time
from vr_envs.bench.stress.trial import CASE, Outcome, note_time
from vr_envs.models.ball_on_lens import LOGGED, MAX_IMPACTS, Params, State, cycle
from vr_envs.models.ball_options import Friction, Spin
from vr_envs.models.jit import kernel
from vr_envs.models.record import dtype_of, pack

DEEPEST = 1e-12  # m
CYCLES = 200
MOST_STEPS = 1_000_000

REASONS = (
    "the model gave up (fault) without a chatter",
    "a number is not finite",
    "the ball went through the lens",
    "a flight does not end where the model has the ball",
    "a search for a passage did not end",
    "lost, but over the lens",
)
_FAULT, _NOT_FINITE, _THROUGH, _ELSEWHERE, _UNJUDGED, _NOT_LOST = range(1, len(REASONS) + 1)


class _Flight(NamedTuple):
    start: float  # s
    x: float  # m
    y: float
    z: float
    u: float  # m/s
    v: float
    w: float


@kernel
def _gap(flight, s, params):
    """The gap (m) at the time s and its rate."""
    t = s - flight.start
    lift = params.acceleration / params.omega**2
    x, y = flight.x + flight.u * t, flight.y + flight.v * t
    h = flight.z + (flight.w - 0.5 * params.gravity * t) * t - lift * math.sin(params.omega * s + params.phase)
    climb = flight.w - params.gravity * t - lift * params.omega * math.cos(params.omega * s + params.phase)
    curvature = params.curvature / (1.0 - params.curvature * params.ball_radius)
    value = h - 0.5 * curvature * (x * x + y * y + h * h)
    return value, climb - curvature * (x * flight.u + y * flight.v + h * climb)


@kernel
def _deepest(flight, end, params):
    """How deep (m) the flight is in the glass until `end` at most, at the places that the search visits."""
    span, lift = end - flight.start, params.acceleration / params.omega
    curvature = abs(params.curvature / (1.0 - params.curvature * params.ball_radius))
    speed = abs(flight.u) + abs(flight.v) + abs(flight.w) + params.gravity * span + lift
    reach = abs(flight.z) + params.acceleration / params.omega**2 + speed * span
    bend = (1.0 + curvature * reach) * (params.gravity + params.acceleration) + curvature * speed * speed
    s, deep = flight.start, 0.0
    for _ in range(MOST_STEPS):
        value, rate = _gap(flight, s, params)
        deep = max(deep, -value)
        if deep > DEEPEST or s >= end:
            return deep
        step = (rate + math.sqrt(rate * rate + 2.0 * bend * (value + DEEPEST))) / bend
        if s + step == s:
            return math.inf
        s = min(end, s + step)
    return math.inf


@kernel
def _leaving(flight, edge):
    """The time (s) from the start after which the flight is no longer within a distance of the axis."""
    square = flight.u * flight.u + flight.v * flight.v
    along = flight.x * flight.u + flight.y * flight.v
    inside = edge * edge - flight.x * flight.x - flight.y * flight.y
    return (math.sqrt(along * along + square * inside) - along) / square if inside > 0.0 else 0.0


@kernel
def _judge(before, after, params, log):
    """Judge one cycle: (failure, deepest passage)."""
    flight = _Flight(0.0, before.x, before.y, before.z, before.u, before.v, before.w)
    deep = 0.0
    for i in range(before.impacts, after.impacts + 1):
        last = i == after.impacts
        row = log[i % log.shape[0]]
        s, x, y, z = (params.period, after.x, after.y, after.z) if last else (row[0], row[1], row[2], row[3])
        if last and after.lost:
            if math.hypot(after.x, after.y) < params.path_edge * (1.0 - 1e-12):
                return _NOT_LOST, deep
            found = _deepest(flight, min(s, flight.start + _leaving(flight, params.path_edge)), params)
            failure = _UNJUDGED if found == math.inf else (_THROUGH if found > DEEPEST else 0)
            return failure, max(deep, found)
        t = s - flight.start
        apart = abs(flight.x + flight.u * t - x) + abs(flight.y + flight.v * t - y)
        apart += abs(flight.z + (flight.w - 0.5 * params.gravity * t) * t - z)
        if apart > DEEPEST * (1.0 + abs(x) + abs(y) + abs(z)):
            return _ELSEWHERE, deep
        found = _deepest(flight, s, params)
        if found == math.inf:
            return _UNJUDGED, deep
        deep = max(deep, found)
        if found > DEEPEST:
            return _THROUGH, deep
        flight = _Flight(s, x, y, z, row[4], row[5], row[6])
    return 0, deep


@kernel
def walk(case, times, trace, states, params, spin, friction, log, scratch):
    """A ball for `CYCLES` cycles, or until it is lost or rests; `states` are two records, before and after a cycle."""
    for step in range(CYCLES):
        states[1] = states[0]
        ball = states[0]
        begin = thread_time(scratch)
        cycle(ball, params, spin, friction, log)
        note_time(case, times, trace, thread_time(scratch) - begin)
        case.at = step
        fresh = ball.impacts - states[1].impacts
        case.count += fresh
        if not math.isfinite(ball.x + ball.y + ball.z + ball.u + ball.v + ball.w):
            case.code = _NOT_FINITE
        elif ball.fault:
            highest = ball.z + params.acceleration / params.omega**2
            if fresh > MAX_IMPACTS or highest * params.curvature > 1.0 - params.curvature * params.ball_radius:
                case.told += 1
            else:
                case.code = _FAULT
        else:
            case.code, deep = _judge(states[1], ball, params, log)
            case.worst = max(case.worst, deep)
            case.judged += fresh
        if case.code != 0 or ball.lost or ball.fault:
            return


def _draw(seed: int) -> tuple[Params, Spin, Friction, np.ndarray]:
    """Lens, ball and where it begins."""
    draw = np.random.default_rng(seed)
    half = float(np.exp(draw.uniform(np.log(0.003), np.log(0.3))))
    curvature = float(draw.choice([-1.0, 1.0], p=[0.2, 0.8]) * min(1e3, (1.0 - 10.0 ** draw.uniform(-6, 0)) / half))
    largest = 1.0 if curvature <= 0.0 else min(1.0, (1.0 - 10.0 ** draw.uniform(-4, 0)) / curvature)
    params = Params(
        curvature=curvature,
        half_aperture=half,
        ball_radius=max(1e-4, largest * draw.uniform(0.001, 1.0)) if curvature > 0.0 else 0.002,
        restitution=draw.uniform(0.5, 1.0),
        frequency=float(np.exp(draw.uniform(np.log(5.0), np.log(200.0)))),
        acceleration=draw.uniform(5.0, 100.0),
        phase=draw.uniform(-3.0, 3.0),
    )
    state = np.zeros(2, dtype_of(State))
    ball = state[0]
    angle, distance = draw.uniform(0.0, 2.0 * np.pi), 0.8 * params.path_edge * draw.uniform()
    ball["x"], ball["y"] = distance * np.cos(angle), distance * np.sin(angle)
    slope = params.path_curvature * distance
    ball["z"] = slope * distance / (1.0 + math.sqrt(1.0 - slope * slope)) + params.amplitude * math.sin(params.phase)
    ball["z"] += 0.02 * min(0.01, 1.0 / abs(params.path_curvature))
    ball["u"], ball["v"] = draw.uniform(-0.1, 0.1, 2)
    spin = Spin(inertia_ratio=draw.uniform(0.0, 1.0), radius=params.ball_radius)
    return params, spin, Friction(coefficient=draw.uniform(0.0, 1.0), restitution=draw.uniform(0.0, 1.0)), state


def run(first: int, number: int, trace: np.ndarray) -> Outcome:
    """Cases of a ball on a lens."""
    outcome = Outcome()
    for seed in range(first, first + number):
        params, spin, friction, states = _draw(seed)
        case = np.zeros(1, CASE)
        walk(case[0], outcome.times, trace, states, pack(params), pack(spin), pack(friction), _LOG, _SCRATCH)
        outcome.take(seed, case[0], REASONS)
    return outcome


_LOG = np.zeros((MAX_IMPACTS + 1, len(LOGGED)))
_SCRATCH = np.zeros(2, np.int64)
