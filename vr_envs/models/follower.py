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
def over_sines(state, gamma, w2, params, undulation):
    """Height r of the sines under the wheel, and the steady ride over them: its height and velocity.

    The transfer function from r to zeta at the angular frequency W is
    (w2 + [i gamma W]) / (w2 - W^2 + i gamma W).
    """
    terrain, height, velocity = 0.0, 0.0, 0.0
    for i in range(WAVES):
        amplitude, number = wave(i, undulation)
        frequency = number * params.speed
        sine, cosine = amplitude * state.wave_sin[i], amplitude * state.wave_cos[i]
        drag, spring = gamma * frequency, w2 - frequency * frequency
        size = spring * spring + drag * drag
        real = (w2 * spring + params.relative * drag * drag) / size
        imaginary = drag * (params.relative * spring - w2) / size
        terrain += sine
        height += real * sine + imaginary * cosine
        velocity += frequency * (real * cosine - imaginary * sine)
    return terrain, height, velocity


@kernel
def enter_sines(state, gamma, w2, params, undulation):
    """Measure travel and velocity from the steady ride over the sines, until `leave_sines`."""
    terrain, height, velocity = over_sines(state, gamma, w2, params, undulation)
    state.travel = state.travel + terrain - height
    state.velocity -= velocity


@kernel
def leave_sines(state, gamma, w2, params, undulation):
    """Undo `enter_sines`, at the place where the wheel is now."""
    terrain, height, velocity = over_sines(state, gamma, w2, params, undulation)
    state.travel = state.travel - terrain + height
    state.velocity += velocity


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
