"""A compiled walk of one ball over many control intervals, in which every flight between two impacts is judged.

What the model says of an interval is the log of its impacts and the ball at its end. From them the flights are built
anew and searched for a passage through the bar (`ball_gap`). Where the ball rests in between, which the log does not
show, the model is asked for the ball at instants on the way.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any, NamedTuple

import numpy as np

from vr_envs.bench.stress.ball_gap import Flight, course_of, deepest, gap, launched, place
from vr_envs.bench.stress.clock import thread_time
from vr_envs.bench.stress.trial import CASE, Outcome, note_time
from vr_envs.envs.ball_on_bar import TASK
from vr_envs.envs.scene import resolve
from vr_envs.models.ball_on_bar import LOGGED, MAX_EVENTS, advance, interval
from vr_envs.models.drive import demanded
from vr_envs.models.jit import kernel
from vr_envs.models.noise import uniform
from vr_envs.models.record import dtype_of

DEEPEST = 1e-12  # m, a passage that is deeper is a failure
SAME = 1e-12  # m, m/s: a flight that ends where the model says
_ON = 1e-12  # of place and velocity, in m, m/s and 0.1 more: from a flight on which the ball still is
_GAP = 1e-15  # m, rounding of a gap: over the speed of an impact, by how much its time is uncertain
_GRAZED = 1e-7  # in place of _ON after an impact without speed, of which the time is that of a double root
LOG = 1 << 16  # rows of the log, more than the impacts of any interval: it has two pieces at most
SAMPLES = 8  # instants of a rest at which it is judged
_HALVINGS = 40  # of a stretch in which a flight ends in a rest, or begins from one
RESTS = 32  # one interval in so many has its rests judged, which takes long
CONSTANT, UNIFORM, CORNERS = 0, 1, 2  # kinds of actions: none, drawn anew in every interval, drawn from {-1, 1}

REASONS = (
    "the model gave up (fault)",
    "a number is not finite",
    "the ball went through the bar",
    "an impact of a ball that moves away from the bar",
    "lost, but over the bar",
    "a flight does not end where the model has the ball",
    "a search for a passage did not end",
)
_FAULT, _NOT_FINITE, _THROUGH, _AWAY, _NOT_LOST, _ELSEWHERE, _UNJUDGED = range(1, len(REASONS) + 1)


class Settings(NamedTuple):
    """How a ball is walked."""

    key: int  # of the draws
    intervals: int
    impacts: int  # the walk ends after so many
    actions: int  # CONSTANT, UNIFORM or CORNERS
    every: int  # one interval in so many is judged and timed
    height: float  # m, of the ball over the bar at the start
    speed: float  # m/s, along the bar at the start, either way at most
    reach: float  # m, place along the bar at the start, either way at most
    curvature: float = 0.0  # 1/m, of the scene's bar


@kernel
def _begin(states, settings, params, episode, curvature):
    """A ball at rest, or moving along, over a bar in its motion at action 0."""
    states[0] = states[2]
    state = states[0]
    state.key = (settings.key << 20) + episode
    draw = 4 * episode
    state.x = settings.reach * (2.0 * uniform(settings.key, draw) - 1.0)
    state.u = settings.speed * (2.0 * uniform(settings.key, draw + 1) - 1.0)
    state.motion[4] = params.z_acceleration / (2.0 * params.omega) ** 2
    state.z = settings.height + state.motion[4] + 0.5 * curvature * state.x * state.x


@kernel
def _act(action, settings, step):
    """Draw the action of a step; the counters of a walk are apart from those of its starts."""
    for i in range(action.shape[0]):
        if settings.actions != CONSTANT:
            action[i] = 2.0 * uniform(settings.key, (1 << 40) + 6 * step + i) - 1.0
        if settings.actions == CORNERS:
            action[i] = math.copysign(1.0, action[i])


@kernel
def _at(states, motion, course, s, options, log):
    """Put into states[3] the ball of states[1] at the time s of the interval."""
    params, scatter, spin, friction, softening, curve, frequencies, ramp, sensing, camera, textbook = options
    states[3] = states[1]
    interval(
        states[3], motion, params, scatter, spin, friction, softening, curve, frequencies, ramp, sensing, camera,
        textbook, log, s - course.begin,
    )  # fmt: skip


@kernel
def _leaves(states, motion, course, flight, on, off, options, log, slack):
    """The last time from `on` towards `off` (s) at which the ball is on the flight, and whether it touches the bar."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (on + off)
        _at(states, motion, course, middle, options, log)
        x, z, u, w = place(flight, middle)
        if abs(x - states[3].x) + abs(z - states[3].z) <= slack * (0.1 + abs(x) + abs(z) + abs(u) + abs(w)):
            on = middle
        else:
            off = middle
    x, z, u, w = place(flight, on)
    value, rate, _ = gap(course, on, x, z, u, w)
    near = 3.0 * slack * (0.1 + abs(x) + abs(z) + abs(u) + abs(w)) + 2.0 * abs(rate) * abs(on - off)
    return on, value <= near


@kernel
def _released(states, motion, course, begin, end, options, log):
    """The last time from `begin` to `end` (s) at which the ball rests, or `begin` if it does not rest then."""
    low, high = begin, end
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        _at(states, motion, course, middle, options, log)
        if states[3].resting:
            low = middle
        else:
            high = middle
    return low


@kernel
def _judge_rest(states, motion, course, flight, arrival, options, log, at_rest, slack):
    """Judge a stretch in which the ball rests, or chatters to its end: (failure, deepest passage).

    It begins with a `flight` and ends with another, the `arrival`, of which place and velocity at the end are given;
    `at_rest` says whether it begins and ends with a rest instead; `slack` is in place of `_ON`.
    """
    begin, end, deep, left, came = flight.start, arrival.start, 0.0, True, True
    if not at_rest[0]:
        begin, left = _leaves(states, motion, course, flight, begin, end, options, log, slack)
    if not at_rest[1]:
        end, came = _leaves(states, motion, course, arrival, end, flight.start, options, log, slack)
        s = _released(states, motion, course, end, arrival.start, options, log)
        x, z, u, w = place(arrival, s)
        deep = deepest(course, Flight(s, x, z, u, w, flight.gravity), s, arrival.start, DEEPEST)
        if deep == math.inf:
            return _UNJUDGED, deep
    # two flights that are not one have a contact between them, however short: then they may be one to within the slack
    if not (left and came) if begin < end else not (left or came):
        return _ELSEWHERE, deep
    for k in range(1, SAMPLES + 1):
        s = begin + (end - begin) * k / (SAMPLES + 1)
        _at(states, motion, course, s, options, log)
        ball = states[3]
        value, _, _ = gap(course, s, ball.x, ball.z, ball.u, ball.w)
        deep = max(deep, abs(value) if ball.resting else -value)
    return (_THROUGH if deep > DEEPEST else 0), deep


@kernel
def _judge_loss(states, motion, course, flight, end, options, log, rested):
    """Judge how a ball was lost, a moment that the model is asked for again and again: (failure, deepest passage)."""
    begin = flight.start
    for _ in range(60):
        middle = 0.5 * (begin + end)
        _at(states, motion, course, middle, options, log)
        if states[3].lost:
            end = middle
        else:
            begin = middle
    _at(states, motion, course, end, options, log)
    ball = states[3]
    _, _, p = gap(course, end, ball.x, ball.z, ball.u, ball.w)
    if abs(p) < options[0].half_length - 1e-9:
        return _NOT_LOST, 0.0
    x, z, _, _ = place(flight, end)
    if rested or not abs(x - ball.x) + abs(z - ball.z) <= SAME * (1.0 + abs(x) + abs(z)):
        return 0, 0.0  # it has rested on its way
    deep = deepest(course, flight, flight.start, begin, DEEPEST)
    return (_UNJUDGED if deep == math.inf else (_THROUGH if deep > DEEPEST else 0)), deep


@kernel
def _judge(states, motion, course, options, log, spare, rests):
    """Judge one interval, from the ball before it (states[1]) to the one after (states[0]): (failure, deepest)."""
    params = options[0]
    before, after = states[1], states[0]
    flight = Flight(course.begin, before.x, before.z, before.u, before.w, params.gravity)
    rested, deep, end = before.resting != 0, 0.0, course.begin + params.hold * params.period
    slack = _ON
    for i in range(before.impacts, after.impacts + 1):
        row, last = log[i % log.shape[0]], i == after.impacts
        if last and after.lost:
            failure, found = _judge_loss(states, motion, course, flight, end, options, spare, rested)
            return failure, max(deep, found)
        if last:
            arrival = Flight(end, after.x, after.z, after.u, after.w, params.gravity)
        else:
            arrival = launched(course, row[0], row[1], row[2], row[3], row[4], params.gravity)
        x, z, u, w = place(flight, arrival.start)
        apart, size = abs(x - arrival.x) + abs(z - arrival.z), 1.0 + abs(x) + abs(z)
        if last:
            apart, size = apart + abs(u - arrival.u) + abs(w - arrival.w), size + abs(u) + abs(w)
        rests_now, failure, found = last and after.resting != 0, 0, 0.0
        if rested or rests_now or not apart <= SAME * size:
            if rests:
                failure, found = _judge_rest(
                    states, motion, course, flight, arrival, options, spare, (rested, rests_now), slack
                )  # fmt: skip
            rested = False
        else:
            found = deepest(course, flight, flight.start, arrival.start, DEEPEST)
            failure = _UNJUDGED if found == math.inf else (_THROUGH if found > DEEPEST else 0)
        deep = max(deep, found)
        if failure != 0:
            return failure, deep
        if not last:
            if row[3] > SAME:
                return _AWAY, deep
            flight = launched(course, row[0], row[1], row[2], row[5], row[6], params.gravity)
            slack = min(_GRAZED, _ON + _GAP / max(-row[3], _GAP))
    return 0, deep


@kernel
def walk(case, times, trace, states, action, settings, options, log, spare, scratch):
    """Walk a ball as the `Settings` say and write the record `CASE`; a ball that is lost is started anew.

    The walk ends where the model says that it gives up, in an interval of too many impacts.

    `states`: four records of the task's state: the ball, what it was before the interval, what it starts from, and one
    to work with.
    """
    params, scatter, spin, friction, softening, curve, frequencies, ramp, sensing, camera, textbook = options
    episode, curvature = 0, settings.curvature
    _begin(states, settings, params, episode, curvature)
    for step in range(settings.intervals):
        _act(action, settings, step)
        judged = step % settings.every == 0
        states[1] = states[0]
        state = states[0]
        begin = thread_time(scratch) if judged else 0
        advance(
            state, action, params, scatter, spin, friction, softening, curve, frequencies, ramp, sensing, camera,
            textbook, log,
        )  # fmt: skip
        if judged:
            note_time(case, times, trace, thread_time(scratch) - begin)
        case.at = step
        fresh = state.impacts - states[1].impacts
        case.count += fresh
        if not math.isfinite(state.x + state.z + state.u + state.w + state.spin + state.d + state.rate):
            case.code = _NOT_FINITE
        elif state.fault:
            if fresh < MAX_EVENTS:
                case.code = _FAULT
            else:
                case.told += 1
        else:
            course = course_of(states[1], action, states[1].steps, params, curvature)
            if judged:
                case.code, deep = _judge(
                    states, demanded(action, params), course, options, log, spare, step % RESTS == 0
                )
                case.worst = max(case.worst, deep)
                case.judged += fresh
                case.met += state.resting
            elif not state.lost:
                end = course.begin + params.hold * params.period
                value, _, _ = gap(course, end, state.x, state.z, state.u, state.w)
                if value < -DEEPEST * (1.0 + abs(state.z)):
                    case.code = _THROUGH
        if case.code != 0 or case.told > 0 or case.count >= settings.impacts:
            return
        state.steps += 1
        if state.lost:
            episode += 1
            _begin(states, settings, params, episode, curvature)


@dataclasses.dataclass(frozen=True)
class Walk:
    """One case: the scene (laid over the task's default, without scatter) and the walk."""

    scene: dict[str, Any]
    settings: Settings


def judge(seed: int, walk_of_case: Walk, outcome: Outcome, trace: np.ndarray, motions: bool = False) -> None:
    """Walk one case and add what happened to `outcome`; with `motions` the intervals are counted, not the impacts."""
    params, rest = resolve(TASK, {"scatter": None, **walk_of_case.scene}).records()
    case, states = np.zeros(1, CASE), np.zeros(4, dtype_of(TASK.state))
    log, spare = _LOGS
    walk(
        case[0], outcome.times, trace, states, np.zeros(6), walk_of_case.settings, (params, *rest), log, spare, _SCRATCH
    )  # fmt: skip
    if motions:
        case["count"] = case["at"] + 1
        case["judged"] = -(-case["count"] // walk_of_case.settings.every)
    outcome.take(seed, case[0], REASONS)


_LOGS = (np.zeros((LOG, len(LOGGED))), np.zeros((LOG, len(LOGGED))))
_SCRATCH = np.zeros(2, np.int64)
