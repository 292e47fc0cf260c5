"""Compiled loops of the simulation: runs with samples, and scans. The Python side is `simulation.py`."""

from __future__ import annotations

import math

import numpy as np

from vr_envs.models.ball_on_bar import LOGGED, MAX_EVENTS, interval
from vr_envs.models.ball_options import OPTIONS
from vr_envs.models.drive import bar_at, base_cycle
from vr_envs.models.jit import kernel
from vr_envs.models.phasor import angular
from vr_envs.models.surface import contact_at, gap_at

# columns of the model's log of impacts
_TIME, _X, _Z, _NORMAL_IN, _TANGENT_IN, _NORMAL_OUT, _TANGENT_OUT = (
    LOGGED.index(name) for name in ("time", "x", "z", "normal_in", "tangent_in", "normal_out", "tangent_out")
)

_CURVE, _FREQUENCIES, _RAMP = (list(OPTIONS).index(name) for name in ("curve", "frequencies", "ramp"))

ROOM = 4 * MAX_EVENTS  # impacts in one control interval at most
PATIENCE = 8  # control intervals per impact that a scan waits for

IMPACT = np.dtype(
    [
        ("cycle", "i8"),  # base cycle, counted from the start of the first run
        ("time", "f8"),  # s, in the cycle
        ("phase", "f8"),  # rad in [0, 2 pi): the bar's z is A sin(phase)
        ("x", "f8"),  # m, ball
        ("z", "f8"),
        ("u_out", "f8"),  # m/s, velocity of the ball's centre after the impact
        ("w_out", "f8"),
        ("normal_in", "f8"),  # m/s, relative to the bar's material, along its normal and tangent: approach, departure
        ("tangent_in", "f8"),
        ("normal_out", "f8"),
        ("tangent_out", "f8"),
    ]
)
"""One impact."""

SAMPLE = np.dtype(
    [
        ("cycle", "i8"),
        ("time", "f8"),  # s, in the cycle
        ("x", "f8"),  # m, ball
        ("z", "f8"),
        ("bar_x", "f8"),  # m
        ("bar_tilt", "f8"),  # rad
        ("bar_z", "f8"),  # m
    ]
)
"""Where ball and bar are at one instant."""


@kernel
def _turned(z, rate, w):
    """Phase in [0, 2 pi) of A sin(phase), from its value and rate."""
    phase = math.atan2(w * z, rate)
    return phase if phase >= 0.0 else phase + 2.0 * math.pi


@kernel
def _frame(s, begin, number, old, new, params, options):
    """The bar's frame at time s of base cycle `number`, in which it goes from `old` to `new` from `begin` on."""
    return bar_at(old, new, s, begin, number, params, options[_FREQUENCIES], options[_RAMP])


@kernel
def _store(impact, row, begin, number, old, new, params, options):
    """One row of the model's log as an `IMPACT`; the arguments are those of `_frame`."""
    frame = _frame(row[_TIME], begin, number, old, new, params, options)
    impact.cycle, impact.time = number, row[_TIME]
    impact.phase = _turned(frame.z[0], frame.z[1], angular(params.omega, options[_FREQUENCIES])[2])
    impact.x, impact.z = row[_X], row[_Z]
    impact.normal_in, impact.tangent_in = row[_NORMAL_IN], row[_TANGENT_IN]
    impact.normal_out, impact.tangent_out = row[_NORMAL_OUT], row[_TANGENT_OUT]
    # a ball without velocity sees the bar's material pass the other way
    still = contact_at(frame, row[_X], row[_Z], 0.0, 0.0, options[_CURVE])
    normal, tangent = row[_NORMAL_OUT] - still.normal, row[_TANGENT_OUT] - still.tangent
    impact.u_out = normal * still.sin + tangent * still.cos
    impact.w_out = normal * still.cos - tangent * still.sin


@kernel
def _phasors(motion):
    return motion[0], motion[1], motion[2], motion[3], motion[4], motion[5]


@kernel
def lowest_gap(states, params, options):
    """Smallest gap under the balls of `states`, m."""
    lowest = math.inf
    for i in range(states.shape[0]):
        motion = _phasors(states[i].motion)
        number, begin = base_cycle(states[i].steps, params)
        frame = _frame(begin, begin, number, motion, motion, params, options)
        lowest = min(lowest, gap_at(frame, states[i].x, states[i].z, options[_CURVE]))
    return lowest


@kernel
def _sample(state, spare, new, params, options, first, ratio, samples, filled):
    """Ball and bar at the sampling instants of the coming interval; returns the next instant's number and row.

    `ratio` is base cycles per sample; the interval is run again up to each instant.
    """
    old = _phasors(state[0].motion)
    number, begin = base_cycle(state[0].steps, params)
    end = begin + params.hold * params.period
    while True:
        s = max(begin, (first * ratio - number) * params.period)
        if s >= end:
            return first, filled
        spare[0] = state[0]
        interval(spare[0], new, params, *options, None, s - begin)
        frame = _frame(s, begin, number, old, new, params, options)
        row = samples[filled]
        row.cycle, row.time, row.x, row.z = number, s, spare[0].x, spare[0].z
        row.bar_x, row.bar_tilt, row.bar_z = frame.x[0], frame.tilt[0], frame.z[0]
        first += 1
        filled += 1


@kernel
def _advance(state, new, params, options, log, out, filled):
    """One control interval; its impacts go to `out` from row `filled` on as far as they fit. Returns the next row."""
    old = _phasors(state.motion)
    number, begin = base_cycle(state.steps, params)
    before = state.impacts
    interval(state, new, params, *options, log)
    for i in range(before, state.impacts):
        if filled < out.shape[0]:
            _store(out[filled], log[i % log.shape[0]], begin, number, old, new, params, options)
            filled += 1
    state.steps += 1
    return filled


@kernel
def run_intervals(state, motions, params, options, log, impacts, samples, ratio):
    """One interval per row of `motions` while there is room for its impacts: (intervals, impacts, samples) done."""
    hits, seen, number = 0, 0, 0
    spare = state.copy()
    if ratio > 0.0:
        cycle, begin = base_cycle(state[0].steps, params)
        number = int(math.ceil((cycle + begin / params.period) / ratio - 1e-9))
    for k in range(motions.shape[0]):
        if state[0].lost or state[0].fault or hits + ROOM > impacts.shape[0]:
            return k, hits, seen
        new = _phasors(motions[k])
        if ratio > 0.0:
            number, seen = _sample(state, spare, new, params, options, number, ratio, samples, seen)
        hits = _advance(state[0], new, params, options, log, impacts, hits)
    return motions.shape[0], hits, seen


@kernel
def run_scan(states, motions, params, options, log, skip, kept, counts, follow):
    """For each motion: `skip` intervals, then others until a row of `kept` is full, or the ball must be at rest."""
    for j in range(motions.shape[0]):
        if follow and j > 0:
            states[j] = states[j - 1]
        state, new = states[j], _phasors(motions[j])
        for _ in range(skip):
            interval(state, new, params, *options, None)
            state.steps += 1
        for _ in range(PATIENCE * kept.shape[1]):
            counts[j] = _advance(state, new, params, options, log, kept[j], counts[j])
            if counts[j] == kept.shape[1] or state.lost or state.fault:
                break
