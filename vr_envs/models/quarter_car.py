"""Quarter car: the wheel has a mass of its own and a tyre that pushes but does not pull.

Heights are up, from static equilibrium without payload: zs of the sprung mass ms, zu of the hub of the unsprung mass
mu, r of the ground. Per sprung mass, with the actuator's force a between body and hub and the payload's p,

    zs'' = -w2 (zs - zu) - gamma (zs' - zu') - stop(zs - zu) + a + p
    zu'' = (ms/mu) [w2 (zs - zu) + gamma (zs' - zu') + stop(zs - zu) - a] - (kt/mu) (zu - r)      on the ground
                                                                         - (1 + ms/mu) g            off the ground

The tyre carries (ms + mu) g - kt (zu - r) and leaves the ground where that comes to nothing, at zu - r =
(ms + mu) g/kt. An absolute damper (the lecture's k_d) acts on zs' alone and has no reaction on the hub. stop() is
the rubber of `travel_stop`.

Tyre on or off the ground, times no stop or either one: six regimes, linear each in x = (zs - zu, zs', zu - r, zu'),
and the forces are continuous from one to the next. Within a regime x is the sum of its Taylor series, whose terms
follow from one another; a step is so short, by the norm of the system, that some twenty terms leave less than
rounding. The same terms bound x and its derivatives over the step, so that most steps are seen to be free of contacts
at once; in the others the first one is found by the certified march of `root.certified_step`.
"""

from __future__ import annotations

import math
from typing import Any

from vr_envs.models.constants import G
from vr_envs.models.jit import kernel
from vr_envs.models.root import certified_step
from vr_envs.models.terrain import roll_undulation, wave
from vr_envs.models.travel_stop import MAX_CONTACTS, RESOLUTION

LONGEST = 1.5  # longest step, in units of 1 over the norm of the system
REST = 2.0**-60  # what the terms left out come to, against those kept
MAX_MARCH = 1000  # steps of one search
STIFFEST = 1e5  # 1/s, largest norm of a scene's system
STILL = 1e-13  # m/s: a slower passage of a limit lasts less than rounding shows
NOTHING, TYRE, STOP = 0, 1, 2  # kinds of contact


@kernel
def lift_off(params, tyre):
    """Deflection [m] at which the tyre carries nothing."""
    return (params.mass + tyre.unsprung_mass) * G / tyre.rate


@kernel
def settle(state, params, tyre):
    """Put the tyre where it carries the payload."""
    state.deflection = state.payload * params.mass / tyre.rate


@kernel
def norm_of(gamma, w2, ratio, grip):
    """Bound of the norm of the system [1/s] where that of x is the energy.

    The springs are skew there, a matrix with these squares summed, and the damper has one eigenvalue.
    """
    return math.sqrt(w2 * (1.0 + ratio) + grip) + gamma * (1.0 + ratio)


def check_stiffness(params: Any, tyre: Any, stop: Any) -> None:
    """Refuse a vehicle so stiff that its ride would take more than some hundred steps in a tick.

    Args: the records' dataclasses; `stop` may be None.

    Raises:
        ValueError: its fastest motion, at the ends of the actuators' ranges, is beyond `STIFFEST`.
    """
    gamma, modulus = (params.passive_damping, 1.0) if params.active else (params.damping_high, params.modulus_high)
    w2 = params.w2 * modulus + (0.0 if stop is None else stop.rate / params.mass)
    norm = norm_of.py_func(gamma, w2, params.mass / tyre.unsprung_mass, tyre.rate / tyre.unsprung_mass)
    if norm > STIFFEST:
        raise ValueError(
            f"tyre.unsprung_mass = {tyre.unsprung_mass:g} is not allowed with these springs and dampers: they move it "
            f"at up to {norm:.3g} 1/s, and at most {STIFFEST:g} 1/s is; give a heavier wheel, less damping_high, or "
            "softer springs"
        )


@kernel
def _regime(state, gamma, w2, force, params, tyre, stop):
    """Coefficients of the present regime, and the norm of the system [1/s]."""
    ratio, grip = params.mass / tyre.unsprung_mass, tyre.rate / tyre.unsprung_mass
    if stop is not None:
        rubber = stop.rate / params.mass
        w2 += rubber * abs(state.side)
        force += rubber * state.side * stop.travel
    norm = norm_of(gamma, w2, ratio, grip)
    weight = 0.0
    if state.airborne:
        grip, weight = 0.0, (1.0 + ratio) * G
    return (w2, gamma, params.relative * gamma, ratio, grip, force + state.payload, -ratio * force - weight), norm


@kernel
def _waves(state, undulation):
    """Amplitudes and wave numbers of the sines, and their phases as complex numbers."""
    (a, k), (b, n), (c, o) = wave(0, undulation), wave(1, undulation), wave(2, undulation)
    cosine, sine = state.wave_cos, state.wave_sin
    return (
        (a, b, c),
        (k, n, o),
        (complex(cosine[0], sine[0]), complex(cosine[1], sine[1]), complex(cosine[2], sine[2])),
    )


@kernel
def _road_rates(state, t, slope, speed, acceleration, undulation):
    """r' [m/s] and r'' [m/s^2] after the time t."""
    rate, second = slope * (speed + acceleration * t), slope * acceleration
    if undulation is not None:
        way, now = (speed + 0.5 * acceleration * t) * t, speed + acceleration * t
        amplitudes, numbers, phases = _waves(state, undulation)
        for i in range(3):
            height = amplitudes[i] * phases[i] * complex(math.cos(numbers[i] * way), math.sin(numbers[i] * way))
            rate += numbers[i] * now * height.real
            second += numbers[i] * (acceleration * height.real - numbers[i] * now * now * height.imag)
    return rate, second


@kernel
def _next_waves(part, now, before, numbers, speed, change):
    """Terms of exp(i phase) one order on, and the present ones times the rate of the phase, all per wave."""
    a = numbers[0] * (speed * now[0] + change * before[0])
    b = numbers[1] * (speed * now[1] + change * before[1])
    c = numbers[2] * (speed * now[2] + change * before[2])
    return (
        (
            complex(-part * a.imag, part * a.real),
            complex(-part * b.imag, part * b.real),
            complex(-part * c.imag, part * c.real),
        ),
        (a.real, b.real, c.real),
    )


@kernel
def flow(state, h, norm, system, slope, speed, acceleration, undulation):
    """x after the time h [s] in one regime, and what its terms say of travel and deflection on the way there.

    The latter is, of each of the two: the lowest and highest value, the lowest and highest second derivative, the
    largest third one; all are bounds.
    """
    w2, gamma, pull, ratio, grip, push, lift = system
    a, b, c, d = state.travel, state.velocity, state.deflection, state.hub_velocity
    travel, velocity, deflection, hub_velocity = a, b, c, d
    low_a, high_a, fall_a, rise_a, jerk_a = a, a, 0.0, 0.0, 0.0
    low_c, high_c, fall_c, rise_c, jerk_c = c, c, 0.0, 0.0, 0.0
    climb, change = slope * speed, slope * acceleration * h
    amplitudes = numbers = (0.0, 0.0, 0.0)
    now = before = (0j, 0j, 0j)
    if undulation is not None:
        amplitudes, numbers, now = _waves(state, undulation)
    rest, order = 1.0, 0.0
    while rest > REST:
        order += 1.0
        part = h / order
        rest *= norm * part
        if undulation is not None:
            after, rates = _next_waves(part, now, before, numbers, speed, acceleration * h)
            climb += amplitudes[0] * rates[0] + amplitudes[1] * rates[1] + amplitudes[2] * rates[2]
            now, before = after, now
        a, b, c, d = (
            part * (b - d),
            part * ((push - w2 * a) - (gamma * b - pull * d)),
            part * (d - climb),
            part * ((lift + ratio * (w2 * a)) + (ratio * pull * (b - d) - grip * c)),
        )
        push, lift, climb, change = 0.0, 0.0, change, 0.0
        travel, velocity, deflection, hub_velocity = travel + a, velocity + b, deflection + c, hub_velocity + d
        below_a, above_a, below_c, above_c = min(a, 0.0), max(a, 0.0), min(c, 0.0), max(c, 0.0)
        low_a, high_a, low_c, high_c = low_a + below_a, high_a + above_a, low_c + below_c, high_c + above_c
        two = order * (order - 1.0)
        fall_a, rise_a, fall_c, rise_c = (
            fall_a + two * below_a,
            rise_a + two * above_a,
            fall_c + two * below_c,
            rise_c + two * above_c,
        )
        three = two * (order - 2.0)
        jerk_a, jerk_c = jerk_a + three * abs(a), jerk_c + three * abs(c)
    two, three = 1.0 / (h * h), 1.0 / (h * h * h)
    return (
        (travel, velocity, deflection, hub_velocity),
        (low_a, high_a, fall_a * two, rise_a * two, jerk_a * three),
        (low_c, high_c, fall_c * two, rise_c * two, jerk_c * three),
    )


@kernel
def _free_of_contact(state, travels, deflections, limit, stop):
    """Whether the bounds of a step say that neither the tyre's nor a stop's contact changes in it."""
    free = deflections[0] > limit if state.airborne else deflections[1] < limit
    if stop is not None:
        if state.side == 0.0:
            free = free and travels[1] < stop.travel and travels[0] > -stop.travel
        elif state.side > 0.0:
            free = free and travels[0] > stop.travel
        else:
            free = free and travels[1] < -stop.travel
    return free


@kernel
def _step_to(side, value, slope, second, bounds):
    """A step over which side times a quantity stays positive: from its value, its derivatives and their bounds."""
    value, slope, second = max(0.0, side * value), side * slope, side * second
    if value == 0.0 and abs(slope) < STILL:
        # it touches the limit: the acceleration, which is the same on both sides, decides
        if second <= 0.0:
            return 0.0 if second < 0.0 else math.inf
        return 3.0 * second / bounds[4]
    return certified_step(value, slope, second, bounds[4], abs(bounds[2] if side > 0.0 else bounds[3]))


@kernel
def _first_contact(state, h, norm, system, slope, speed, acceleration, travels, deflections, limit, undulation, stop):
    """Time [s] until the tyre's or a stop's contact changes, if before h, and its kind; negative if undecided."""
    w2, gamma, pull, ratio, grip, push, lift = system
    a, b, c, d = state.travel, state.velocity, state.deflection, state.hub_velocity
    elapsed = 0.0
    for _ in range(MAX_MARCH):
        climb, steepening = _road_rates(state, elapsed, slope, speed, acceleration, undulation)
        lifting = lift + ratio * (w2 * a + pull * (b - d)) - grip * c
        step = _step_to(1.0 if state.airborne else -1.0, c - limit, d - climb, lifting - steepening, deflections)
        kind = TYRE
        if stop is not None:
            second = push - w2 * a - gamma * b + pull * d - lifting
            if state.side == 0.0:
                below = _step_to(-1.0, a - stop.travel, b - d, second, travels)
                other = min(below, _step_to(1.0, a + stop.travel, b - d, second, travels))
            else:
                other = _step_to(state.side, a - state.side * stop.travel, b - d, second, travels)
            if other < step:
                step, kind = other, STOP
        if step <= RESOLUTION:
            return elapsed, kind
        elapsed += step
        if elapsed >= h:
            return h, NOTHING
        (a, b, c, d), _, _ = flow(state, elapsed, norm, system, slope, speed, acceleration, undulation)
    return -1.0, NOTHING


@kernel
def _switch(state, kind, limit, stop):
    """The contact of that kind has changed."""
    if kind == TYRE:
        state.deflection = limit
        state.airborne = not state.airborne
        state.liftoffs += state.airborne
    if stop is not None and kind == STOP:
        if state.side == 0.0:
            state.side = math.copysign(1.0, state.travel)
            state.touches += 1
        else:
            state.side = 0.0
        state.travel = math.copysign(stop.travel, state.travel)


@kernel
def drive(state, t, gamma, w2, force, slope, speed, acceleration, params, undulation, tyre, stop):
    """Ride for the time t over ground of one slope, from `speed` [m/s] at a constant forward acceleration [m/s^2].

    `force` [m/s^2] is the actuator's, per sprung mass.
    """
    left, contacts = t, 0
    limit = lift_off(params, tyre)
    while left > 0.0:
        system, norm = _regime(state, gamma, w2, force, params, tyre, stop)
        if undulation is not None:
            norm = max(norm, wave(2, undulation)[1] * (speed + abs(acceleration) * left))
        h, kind = min(left, LONGEST / norm), NOTHING
        x, travels, deflections = flow(state, h, norm, system, slope, speed, acceleration, undulation)
        if not _free_of_contact(state, travels, deflections, limit, stop):
            until, kind = _first_contact(
                state, h, norm, system, slope, speed, acceleration, travels, deflections, limit, undulation, stop
            )
            if until < 0.0 or contacts == MAX_CONTACTS:
                state.fault, kind = True, NOTHING
            if kind != NOTHING:
                h = until
                contacts += 1
                x, _, _ = flow(state, h, norm, system, slope, speed, acceleration, undulation)
        state.travel, state.velocity, state.deflection, state.hub_velocity = x
        if state.airborne:
            state.airborne_time += h
        if kind != NOTHING:
            _switch(state, kind, limit, stop)
        if undulation is not None:
            roll_undulation(state, (speed + 0.5 * acceleration * h) * h, undulation)
        speed += acceleration * h
        left -= h
