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
from vr_envs.models.spring import free_motion
from vr_envs.models.terrain import WAVES, wave
from vr_envs.models.travel_stop import move_with_stop


@kernel
def _answer(i, gamma, w2, params, undulation):
    """Transfer functions at the angular frequency W of sine i, times its amplitude, and W.

    From r to u = zeta - r and to zeta:
    (W^2 + [i gamma W] - i gamma W) / (w2 - W^2 + i gamma W)  and  (w2 + [i gamma W]) / (w2 - W^2 + i gamma W).

    Returns: real and imaginary part of the first one, of the second one, W.
    """
    amplitude, number = wave(i, undulation)
    frequency = number * params.speed
    square = frequency * frequency
    drag, spring = gamma * frequency, w2 - square
    share = amplitude / (spring * spring + drag * drag)
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
    """What `over_sines` needs to know of spring and damper."""
    return (
        _answer(0, gamma, w2, params, undulation),
        _answer(1, gamma, w2, params, undulation),
        _answer(2, gamma, w2, params, undulation),
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
def follow(state, t, gamma, w2, push, slope, speed, acceleration, params, stop, cruise):
    """Ride for the time t over ground of one slope, from `speed` [m/s] at a constant forward acceleration [m/s^2]."""
    climb = slope * speed
    if cruise is not None:
        push -= slope * acceleration
    push -= (1.0 - params.relative) * gamma * climb
    u, rate = state.travel, state.velocity - climb
    if stop is None:
        x, rate = free_motion(u - push / w2, rate, gamma, w2, t)
        u = x + push / w2
    else:
        u, rate, state.side, touches, fault = move_with_stop(
            u, rate, state.side, gamma, w2, push, stop.rate / params.mass, stop.travel, t
        )
        state.touches += touches
        if fault:
            state.fault = True
    if cruise is not None:
        climb += slope * acceleration * t
    state.travel, state.velocity = u, rate + climb
