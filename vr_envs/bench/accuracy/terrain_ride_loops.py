"""What else moves the ride: compiled loops of steps, with the equations of motion written out anew in heights.

They share with the exact model what is not integrated: the road, the actuators and the meter. All are restarted
where the ground's slope, the damping or the spring jumps, so that a rule keeps its order there. A contact of the
tyre or a stop is another matter: it falls into a step, where the force bends. A loop with `located` looks for the
place, takes the step as far as that, and goes on under the other law; a contact that comes and goes within one step
is not seen.
"""

from __future__ import annotations

import math

from vr_envs.models.clock import equal_steps
from vr_envs.models.constants import G
from vr_envs.models.jit import kernel
from vr_envs.models.road import pass_knot, slope_of_road
from vr_envs.models.terrain import roll_undulation, undulation_ahead
from vr_envs.models.terrain_ride import actuate, begin_tick, end_tick, suspension

SEARCH = 60  # steps of one search for a contact
CLOSE = 1e-15  # m: a gap that is smaller is closed


@kernel
def free_deflection(params, tyre):
    """Height of the hub over the ground, from static, at which the tyre carries nothing [m]."""
    return (params.mass + tyre.unsprung_mass) * G / tyre.rate


@kernel
def contacts_of(y, ground, params, tyre, stop):
    """Whether the tyre is off the ground (0 or 1), and the side of the stop that is touched (-1, 0, 1)."""
    off, side = 0.0, 0.0
    hub = ground
    if tyre is not None:
        hub = y[2]
        off = 1.0 if hub - ground > free_deflection(params, tyre) else 0.0
    if stop is not None:
        travel = y[0] - hub
        side = math.copysign(1.0, travel) if abs(travel) > stop.travel else 0.0
    return off, side


@kernel
def slopes(y, ground, climb, contacts, gamma, w2, params, tyre, stop):
    """Time derivatives of y: height and velocity of the body, then of the hub, which is on the ground without a tyre.

    `ground` and `climb`: its height and rate; `contacts`: as `contacts_of` gives them.
    """
    hub, hub_rate, hub_acceleration = ground, climb, 0.0
    if tyre is not None:
        hub, hub_rate = y[2], y[3]
    inner = w2 * (hub - y[0])
    if params.relative > 0.0:
        inner += gamma * (hub_rate - y[1])
    if stop is not None:
        inner -= stop.rate / params.mass * contacts[1] * contacts[1] * (y[0] - hub - contacts[1] * stop.travel)
    if tyre is not None:
        push = -tyre.rate * (hub - ground)
        if contacts[0] > 0.0:
            push = -(params.mass + tyre.unsprung_mass) * G
        hub_acceleration = (push - params.mass * inner) / tyre.unsprung_mass
    if params.relative == 0.0:
        inner -= gamma * y[1]
    return y[1], inner, y[3], hub_acceleration


@kernel
def _moved(y, h, k):
    """y + h k."""
    return y[0] + h * k[0], y[1] + h * k[1], y[2] + h * k[2], y[3] + h * k[3]


@kernel
def euler(y, h, ground, climb, gamma, w2, params, tyre, stop):
    """One step of the semi-implicit Euler rule: the forces give new velocities, and these move body and hub."""
    contacts = contacts_of(y, ground, params, tyre, stop)
    k = slopes(y, ground, climb, contacts, gamma, w2, params, tyre, stop)
    velocity, hub_velocity = y[1] + h * k[1], y[3] + h * k[3]
    return y[0] + h * velocity, velocity, y[2] + h * hub_velocity, hub_velocity


@kernel
def runge_kutta(y, h, grounds, climb, contacts, located, gamma, w2, params, tyre, stop):
    """One step of the classical Runge-Kutta rule; `grounds`: heights at its begin, middle and end."""
    if not located:
        contacts = contacts_of(y, grounds[0], params, tyre, stop)
    a = slopes(y, grounds[0], climb, contacts, gamma, w2, params, tyre, stop)
    at = _moved(y, 0.5 * h, a)
    if not located:
        contacts = contacts_of(at, grounds[1], params, tyre, stop)
    b = slopes(at, grounds[1], climb, contacts, gamma, w2, params, tyre, stop)
    at = _moved(y, 0.5 * h, b)
    if not located:
        contacts = contacts_of(at, grounds[1], params, tyre, stop)
    c = slopes(at, grounds[1], climb, contacts, gamma, w2, params, tyre, stop)
    at = _moved(y, h, c)
    if not located:
        contacts = contacts_of(at, grounds[2], params, tyre, stop)
    d = slopes(at, grounds[2], climb, contacts, gamma, w2, params, tyre, stop)
    y = _moved(_moved(y, h / 6.0, a), h / 3.0, b)
    return _moved(_moved(y, h / 3.0, c), h / 6.0, d)


@kernel
def gap_of(y, ground, contacts, params, tyre, stop):
    """The smallest margin [m] by which the contacts stay as they are, and whether it is the tyre's."""
    gap, is_tyre, hub = math.inf, True, ground
    if tyre is not None:
        hub = y[2]
        gap = (2.0 * contacts[0] - 1.0) * (hub - ground - free_deflection(params, tyre))
    if stop is not None:
        margin = stop.travel - abs(y[0] - hub)
        if contacts[1] != 0.0:
            margin = contacts[1] * (y[0] - hub) - stop.travel
        if margin < gap:
            gap, is_tyre = margin, False
    return gap, is_tyre


@kernel
def switched(y, ground, contacts, params, tyre, stop):
    """The contacts after that with the smallest margin has changed."""
    _, is_tyre = gap_of(y, ground, contacts, params, tyre, stop)
    if is_tyre:
        return 1.0 - contacts[0], contacts[1]
    if contacts[1] != 0.0:
        return contacts[0], 0.0
    hub = ground
    if tyre is not None:
        hub = y[2]
    return contacts[0], math.copysign(1.0, y[0] - hub)


@kernel
def located_step(y, h, ground, climb, contacts, gamma, w2, params, tyre, stop):
    """One Runge-Kutta step over even ground, in parts that end at contacts; the contacts, and the time off the ground.

    A contact is found by the regula falsi of Illinois on the length of the step.
    """
    off, left = 0.0, h
    while left > 0.0:
        part, low, high = left, 0.0, left
        grounds = ground, ground + 0.5 * climb * part, ground + climb * part
        after = runge_kutta(y, part, grounds, climb, contacts, True, gamma, w2, params, tyre, stop)
        after_gap, _ = gap_of(after, grounds[2], contacts, params, tyre, stop)
        met = after_gap < 0.0
        if met:
            low_gap, high_gap = max(CLOSE, gap_of(y, ground, contacts, params, tyre, stop)[0]), after_gap
            for _ in range(SEARCH):
                part = (low * high_gap - high * low_gap) / (high_gap - low_gap)
                grounds = ground, ground + 0.5 * climb * part, ground + climb * part
                after = runge_kutta(y, part, grounds, climb, contacts, True, gamma, w2, params, tyre, stop)
                gap, _ = gap_of(after, grounds[2], contacts, params, tyre, stop)
                if abs(gap) < CLOSE:
                    break
                if gap < 0.0:
                    high, high_gap, low_gap = part, gap, 0.5 * low_gap
                else:
                    low, low_gap, high_gap = part, gap, 0.5 * high_gap
        y, ground, left = after, grounds[2], left - part
        off += part * contacts[0]
        if met:
            contacts = switched(y, ground, contacts, params, tyre, stop)
    return y, contacts, off


@kernel
def _time_off(before, after, h):
    """Part [s] of a step h in which a gap that runs straight from `before` to `after` is above 0."""
    if before > 0.0:
        return h if after > 0.0 else h * before / (before - after)
    return h * after / (after - before) if after > 0.0 else 0.0


@kernel
def advance_in_steps(state, action, params, undulation, road, tyre, stop, order, step, located):
    """Move a state over one tick in equal steps of at most `step` [s]; `order` 1 is Euler's rule, else Runge-Kutta's.

    `located`: contacts are found within steps; not over sines, and of order 4 only.
    """
    actuate(state, action, None, None)
    begin_tick(state, action, None, None)
    gamma, w2, _ = suspension(state, params)
    speed, ground, left = params.speed, 0.0, params.dt
    y = state.deflection + state.travel, state.velocity, state.deflection, state.hub_velocity
    contacts, limit = contacts_of(y, 0.0, params, tyre, stop), 0.0
    if located:
        contacts = float(state.airborne), state.side
    if tyre is not None:
        limit = free_deflection(params, tyre)
    while left > 0.0:
        piece, climb, passes, base = left, 0.0, False, 0.0
        if road is not None:
            climb = slope_of_road(state, road) * speed
            if state.to_knot / speed <= piece:
                piece, passes = state.to_knot / speed, True
        if undulation is not None:
            base = undulation_ahead(state, 0.0, undulation)
        steps, begin = equal_steps(piece, step), ground
        h = piece / steps
        for k in range(steps):
            if located:
                y, contacts, off = located_step(
                    y, h, begin + climb * h * k, climb, contacts, gamma, w2, params, tyre, stop
                )
                state.airborne_time += off
                ground = begin + climb * h * (k + 1)
                continue
            end = begin + climb * h * (k + 1)
            if undulation is not None:
                end = begin + undulation_ahead(state, speed * h * (k + 1), undulation) - base
            before = y[2] - ground - limit
            if order == 1:
                y = euler(y, h, ground, climb, gamma, w2, params, tyre, stop)
            else:
                middle = begin + climb * h * (k + 0.5)
                if undulation is not None:
                    middle = begin + undulation_ahead(state, speed * h * (k + 0.5), undulation) - base
                y = runge_kutta(y, h, (ground, middle, end), climb, contacts, False, gamma, w2, params, tyre, stop)
            ground = end
            if tyre is not None:
                state.airborne_time += _time_off(before, y[2] - ground - limit, h)
        if undulation is not None:
            roll_undulation(state, speed * piece, undulation)
        if road is not None:
            if passes:
                pass_knot(state, True, road, None, None, None, None)
            else:
                state.to_knot = max(0.0, state.to_knot - speed * piece)
        left -= piece
    hub = ground
    if tyre is not None:
        hub = y[2]
        state.deflection, state.hub_velocity = hub - ground, y[3]
    state.travel, state.velocity = y[0] - hub, y[1]
    state.airborne, state.side = contacts[0] > 0.0, contacts[1]
    end_tick(state, gamma, params, tyre, None)
