"""A ball resting on the bar: stuck, rolling or sliding, until the bar falls away from under it.

It leaves where the supporting force (`support.py`) falls to zero: at the phase arcsin(g / peak acceleration) of a bar
that moves up and down only.
"""

from __future__ import annotations

from vr_envs.models.bar import frame_at
from vr_envs.models.jit import kernel
from vr_envs.models.rolling import grip_or_slip, inertia_of, roll
from vr_envs.models.root import MAX_MARCH, UNDECIDED, converged, free_step
from vr_envs.models.support import support, support_curvature
from vr_envs.models.surface import steepness


@kernel
def carry(piece, limits, s, end, gravity, d, curve):
    """Time at which a ball that sticks at `d` leaves, or `end` if it stays: certified first root of the force.

    Returns UNDECIDED if the search does not end.
    """
    curvature = support_curvature(limits, gravity, abs(d), 0.0, 0.0, 0.0, curve)
    for _ in range(100 * MAX_MARCH):  # steps are short where a motion has a high frequency of its own
        force, slope = support(frame_at(piece, s), gravity, d, 0.0, 0.0, curve)
        if force <= 0.0:
            return s
        step = free_step(force, slope, curvature)
        if s + step >= end:
            return end
        if converged(s, step):
            return s
        s += step
    return UNDECIDED


@kernel
def _place(state, frame, curve):
    """World position and velocity of a resting ball."""
    d, rate, turn = state.d, state.rate, frame.tilt[1]
    across, rising = 0.0, 0.0
    if curve is not None:
        across, rising = 0.5 * curve.curvature * d * d, curve.curvature * d * rate
    p_1, q_1 = rate + turn * across, rising - turn * d
    state.x = frame.x[0] + d * frame.cos + across * frame.sin
    state.z = frame.z[0] - d * frame.sin + across * frame.cos
    state.u = frame.x[1] + q_1 * frame.sin + p_1 * frame.cos
    state.w = frame.z[1] + q_1 * frame.cos - p_1 * frame.sin


@kernel
def rest(state, piece, limits, s, end, params, spin, friction, curve):
    """Keep the resting ball on the bar until it leaves, passes the bar's end, or `end`; returns (time, frame)."""
    sticks = spin is None and params.tangential_loss > 0.0
    limited = friction is not None and (sticks or inertia_of(spin)[0] > 0.0)
    if friction is not None and limited:
        s, state.d, state.rate, state.spin, left = grip_or_slip(
            piece,
            s,
            end,
            state.d,
            state.rate,
            state.spin,
            params.gravity,
            params.half_length,
            sticks,
            spin,
            friction,
            curve,
        )
    elif sticks:
        s = carry(piece, limits, s, end, params.gravity, state.d, curve)
        left = s < end
    else:
        s, state.d, state.rate, left = roll(
            piece, limits, s, end, state.d, state.rate, params.gravity, params.half_length, spin, curve
        )
    if s == UNDECIDED:
        state.fault = True
        s = end
    frame = frame_at(piece, s)
    _place(state, frame, curve)
    if spin is not None:
        if not limited:
            state.spin = steepness(state.d, curve) * state.rate + spin.radius * frame.tilt[1]
    state.lost = abs(state.d) > params.half_length
    state.resting = not left
    return s, frame
