"""What drives the bar in one control interval: the motion that an action asks for, frequencies of its own, a ramp."""

from __future__ import annotations

import math

from vr_envs.models.bar import Piece, Rates
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
def _rates(number, params, frequencies):
    """The `Rates` of base cycle `number`, or None."""
    if frequencies is None:
        return None
    else:
        f, w = frequencies, params.omega
        turns = (_turns(number, f.x), _turns(number, f.tilt), _turns(number, f.z))
        phase = (2.0 * math.pi * turns[0], 2.0 * math.pi * turns[1], 2.0 * math.pi * turns[2])
        return Rates((f.x * w, f.tilt * w, f.z * w), phase)


@kernel
def _drift(params, ramp):
    """Growth of the bar's phasors in m/s and rad/s, or None."""
    if ramp is None:
        return None
    else:
        a = 1.0 / (params.omega * params.omega)
        b = 0.25 * a
        return ramp.x_cos * a, ramp.x_sin * a, ramp.tilt_cos * a, ramp.tilt_sin * a, ramp.z_cos * b, ramp.z_sin * b


@kernel
def _grown(motion, drift, time):
    """`motion` after it has drifted for `time`."""
    if drift is None:
        return motion
    else:
        m, d, t = motion, drift, time
        return (
            m[0] + t * d[0], m[1] + t * d[1], m[2] + t * d[2], m[3] + t * d[3], m[4] + t * d[4], m[5] + t * d[5],
        )  # fmt: skip


@kernel
def piece_at(old, new, s, begin, number, params, frequencies, ramp):
    """The `Piece` of bar motion at time `s` of base cycle `number` that from time `begin` goes from `old` to `new`."""
    rates, drift = _rates(number, params, frequencies), _drift(params, ramp)
    blend = params.blend * params.period
    passed = number * params.period
    grown = _grown(new, drift, passed)
    if new == old or s >= begin + blend:
        return Piece(params.omega, 0.0, 0.0, grown, grown, rates, drift)
    change = (
        new[0] - old[0], new[1] - old[1], new[2] - old[2], new[3] - old[3], new[4] - old[4], new[5] - old[5],
    )  # fmt: skip
    return Piece(params.omega, begin, blend, _grown(old, drift, passed), change, rates, drift)
