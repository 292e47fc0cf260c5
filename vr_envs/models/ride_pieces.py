"""The ride over any time with actuators and commanded speed held: from piece to piece of the road and of the speed."""

from __future__ import annotations

from vr_envs.models.cruise import acceleration_to, time_to_cover
from vr_envs.models.follower import follow, over_sines, steady_answers
from vr_envs.models.jit import kernel
from vr_envs.models.lanes import any_lane, where
from vr_envs.models.quarter_car import drive
from vr_envs.models.road import pass_knot, slope_of_road
from vr_envs.models.terrain import roll_undulation


@kernel
def ride(
    state, t, gamma, w2, force, target, params, undulation, road, profile, bumps, obstacle, wheel, tyre, stop, cruise
):
    """Ride for the time t [s] with constant damping, spring, force and `target` of the speed [m/s], exactly.

    The road's knots and the instant at which the speed is reached divide it. Without a tyre, sines exclude a stop,
    and a change of speed excludes sines and absolute damping.
    """
    answers = None
    if tyre is None:
        if undulation is not None:  # travel and velocity are from here on those beside the steady ride
            answers = steady_answers(gamma, w2, params, undulation)
            travel, velocity = over_sines(state, answers)
            state.travel -= travel
            state.velocity -= velocity
    left, speed, acceleration = t, params.speed, 0.0
    while any_lane(left > 0.0):
        moves, piece, slope, passes, arrives = left > 0.0, left, 0.0, False, False
        if cruise is not None:
            speed = state.speed
            acceleration, time = acceleration_to(speed, target, cruise)
            if time <= piece:
                piece, arrives = time, True
        if road is not None:
            slope, time = slope_of_road(state, road), state.to_knot / speed
            if cruise is not None:
                time = time_to_cover(state.to_knot, speed, acceleration)
            passes = moves & (time <= piece)
            if cruise is not None:
                arrives = arrives and (not passes or time == piece)
            piece = where(passes, time, piece)
        way = speed * piece
        if cruise is not None:
            way += 0.5 * acceleration * piece * piece
            state.speed = target if arrives else speed + acceleration * piece
        if tyre is None:
            follow(
                state, moves, piece, gamma, w2, force + state.payload,
                slope, speed, acceleration, params, stop, cruise,
            )  # fmt: skip
            if undulation is not None:
                roll_undulation(state, way, undulation)
        else:
            drive(state, piece, gamma, w2, force, slope, speed, acceleration, params, undulation, tyre, stop)
        if road is not None:
            state.to_knot = max(0.0, state.to_knot - way)
            if any_lane(passes):
                pass_knot(state, passes, road, profile, bumps, obstacle, wheel)
        state.distance += way
        left -= piece
    if tyre is None:
        if undulation is not None:
            travel, velocity = over_sines(state, answers)
            state.travel += travel
            state.velocity += velocity
