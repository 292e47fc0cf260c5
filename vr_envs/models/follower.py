"""The lecture's wheel (equations 3.89 and 3.90): a point that follows the ground and never leaves it.

With u = zeta - r the travel of the spring, gamma = c/m, w2 = k/m and the acceleration `push` that payload and force
give,

    zeta'' + gamma zeta' + w2 zeta = w2 r + [gamma r'] + push                               (3.90, exact in time)

The term in brackets is there for a damper between mass and wheel ("relative"), and not for the lecture's factor k_d,
which damps the mass's own velocity ("absolute"). h of 3.89 is read as the height of the terrain since the start, the
only reading that does not depend on the step.

On a straight piece of road u obeys a free damped spring with a constant push, with a relative damper also while the
speed changes evenly; over sines at constant speed the particular solution is a phasor. Both are exact over any time.
"""

from __future__ import annotations

from vr_envs.models.jit import kernel
from vr_envs.models.lane_records import lane, lane_count
from vr_envs.models.lanes import any_lane, negate, where
from vr_envs.models.spring import free_motion
from vr_envs.models.terrain import WAVES, wave
from vr_envs.models.travel_stop import move_with_stop, stays_free


@kernel
def _impedance(i, gamma, w2, params, undulation):
    """Of sine i: its angular frequency W, w2 - W^2 and gamma W, and the sum of the squares of these two."""
    frequency = wave(i, undulation)[1] * params.speed
    spring, drag = w2 - frequency * frequency, gamma * frequency
    return frequency, spring, drag, spring * spring + drag * drag


@kernel
def _answer(impedance, share, w2, params):
    """What follows from an impedance, times the sine's amplitude, where `share` is that over the sum of squares.

    Returns: real and imaginary part of the transfer function from r to u = zeta - r, and from r to zeta, and W.
    """
    frequency, spring, drag, _ = impedance
    square = frequency * frequency
    passed, held = params.relative * drag, (params.relative - 1.0) * drag
    return (
        (square * spring + held * drag) * share,
        (held * spring - square * drag) * share,
        (w2 * spring + passed * drag) * share,
        (passed * spring - w2 * drag) * share,
        frequency,
    )


@kernel
def steady_answers(gamma, w2, params, undulation):
    """Transfer functions for `over_sines`, at the angular frequencies W of the sines.

    From r to u = zeta - r and to zeta they are
    (W^2 + [i gamma W] - i gamma W) / (w2 - W^2 + i gamma W)  and  (w2 + [i gamma W]) / (w2 - W^2 + i gamma W).
    """
    a = _impedance(0, gamma, w2, params, undulation)
    b = _impedance(1, gamma, w2, params, undulation)
    c = _impedance(2, gamma, w2, params, undulation)
    inverse = 1.0 / (a[3] * b[3] * c[3])  # a division takes as long as all the rest
    return (
        _answer(a, wave(0, undulation)[0] * (inverse * (b[3] * c[3])), w2, params),
        _answer(b, wave(1, undulation)[0] * (inverse * (a[3] * c[3])), w2, params),
        _answer(c, wave(2, undulation)[0] * (inverse * (a[3] * b[3])), w2, params),
    )


@kernel
def over_sines(state, answers):
    """The steady ride over the sines: the travel of the spring and the velocity of the mass where the wheel is."""
    travel, velocity = 0.0, 0.0
    for i in range(WAVES):
        u_real, u_imaginary, real, imaginary, frequency = answers[i]
        sine, cosine = state.wave_sin[i], state.wave_cos[i]
        travel += u_real * sine + u_imaginary * cosine
        velocity += frequency * (real * cosine - imaginary * sine)
    return travel, velocity


@kernel
def _follow_to_stop(state, t, u, rate, climb, gamma, w2, push, params, stop):
    """`follow` of one record that may touch or leave a stop; `climb`: r' at the end."""
    u, rate, state.side, touches, fault = move_with_stop(
        u, rate, state.side, gamma, w2, push, stop.rate / params.mass, stop.travel, t
    )
    state.touches += touches
    if fault:
        state.fault = True
    state.travel, state.velocity = u, rate + climb


@kernel
def follow(state, moves, t, gamma, w2, push, slope, speed, acceleration, params, stop, cruise):
    """Ride for the time t over ground of one slope, from `speed` [m/s] at a constant forward acceleration [m/s^2].

    Records that `moves` does not hold for stay as they are.
    """
    climb = slope * speed
    if cruise is not None:
        push -= slope * acceleration
    push -= (1.0 - params.relative) * gamma * climb
    u, velocity = state.travel, state.velocity
    rate, centre = velocity - climb, push / w2
    if cruise is not None:
        climb += slope * acceleration * t
    x, end_rate = free_motion(u - centre, rate, gamma, w2, t)
    state.travel, state.velocity = where(moves, x + centre, u), where(moves, end_rate + climb, velocity)
    if stop is not None:
        near = moves & negate(stays_free(u, rate, state.side, w2, centre, stop.travel, t))
        if any_lane(near):
            for k in range(lane_count(near)):
                if lane(near, k):
                    _follow_to_stop(
                        lane(state, k), lane(t, k), lane(u, k), lane(rate, k), lane(climb, k), lane(gamma, k),
                        lane(w2, k), lane(push, k), params, stop,
                    )  # fmt: skip
