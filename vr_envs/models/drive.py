"""What drives the bar in one control interval: the motion that an action asks for, frequencies of its own, a ramp."""

from __future__ import annotations

import math

from vr_envs.models.bar import Piece, drift_of, frame_at
from vr_envs.models.jit import kernel


@kernel
def demanded(action, params):
    """The bar motion that an action asks for: in-phase and quadrature parts of x, tilt and z."""
    return (
        params.x_span * action[0],
        params.x_span * action[1],
        params.tilt_span * action[2],
        params.tilt_span * action[3],
        params.z_centre + params.z_span * action[4],
        params.z_span * action[5],
    )


@kernel
def base_cycle(steps, params):
    """The base cycle in which control interval number `steps` begins: its number, and the time (s) in it."""
    if params.hold < 1.0:
        return steps // 2, 0.5 * params.period * (steps % 2)
    return steps * int(params.hold), 0.0


@kernel
def _turns(number, ratio):
    """Fraction of a turn after `number` base cycles at `ratio` turns each, to rounding for numbers below 2^32."""
    coarse = math.floor(ratio * 2.0**20) * 2.0**-20  # its product with the number is exact
    whole = number * coarse
    turns = whole - math.floor(whole) + number * (ratio - coarse)
    return turns - math.floor(turns)


@kernel
def _grown(motion, time, params, ramp):
    """`motion` after it has drifted for `time`."""
    if ramp is None:
        return motion
    else:
        m, d, t = motion, drift_of(params.omega, ramp), time
        return (
            m[0] + t * d[0], m[1] + t * d[1], m[2] + t * d[2], m[3] + t * d[3], m[4] + t * d[4], m[5] + t * d[5],
        )  # fmt: skip


@kernel
def phase_at(number, frequencies):
    """Angles of x, tilt and z at the start of base cycle `number`, rad; not used without frequencies of their own."""
    if frequencies is None:
        return 0.0, 0.0, 0.0
    else:
        f, turn = frequencies, 2.0 * math.pi
        return turn * _turns(number, f.x), turn * _turns(number, f.tilt), turn * _turns(number, f.z)


@kernel
def phasors_at(old, new, s, begin, number, params, ramp):
    """The phasors of a `Piece`, (blend, base, change), at time `s` of base cycle `number`.

    From time `begin` of the cycle the bar goes from the motion `old` to `new`. (No kernel returns a piece, since Numba
    cannot return the records in it.)
    """
    passed = number * params.period
    if new == old or s >= begin + params.blend * params.period:
        grown = _grown(new, passed, params, ramp)
        return 0.0, grown, grown
    change = (
        new[0] - old[0], new[1] - old[1], new[2] - old[2], new[3] - old[3], new[4] - old[4], new[5] - old[5],
    )  # fmt: skip
    return params.blend * params.period, _grown(old, passed, params, ramp), change


@kernel
def bar_at(old, new, s, begin, number, params, frequencies, ramp):
    """The bar's `Frame` at time `s` of base cycle `number`; see `phasors_at`."""
    blend, base, change = phasors_at(old, new, s, begin, number, params, ramp)
    phase = phase_at(number, frequencies)
    return frame_at(Piece(params.omega, begin, blend, base, change, frequencies, phase, ramp), s)
