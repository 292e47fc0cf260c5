"""What the ride must obey after a step, judged apart from the model: the contacts it reports, and its motion.

The motion is integrated again by the classical Runge-Kutta method with forces that follow from place alone: the rubber
pushes beyond the stop's travel, the tyre pushes as long as it is compressed. That finds a contact that was missed, of
which the difference is far above the error of small steps.
"""

from __future__ import annotations

import math

from vr_envs.envs.scene import Scene
from vr_envs.models.jit import kernel
from vr_envs.models.noise import uniform
from vr_envs.models.road_options import RING

REASONS = (
    "the tyre is off the ground and pressed, or on it and pulled",
    "a stop is said to be touched where it is not, or not where it is",
    "the motion is not that of an integration in small steps",
    "a smallest number has grown, or is gone",
)
_TYRE, _STOP, _MOTION, _GROWN = range(1, len(REASONS) + 1)
NEAR = 1e-12  # m
ALIKE = 1e-5  # of the largest number of the motion, far below what a missed contact makes of it
SMALLEST = 1e-290  # of the motion that begins with a number below the smallest normal one, on a level road
_STEP = 0.01  # of the integration, over the fastest motion's rate
_LONGEST = 5e-6  # s


def facts_of(scene: Scene, small: bool = False) -> tuple[float, ...]:
    """What the check needs to know of a scene: gravity's lift-off, tyre and wheel, stop, knots; 0 where absent."""
    tyre, stop, mass = scene.options["tyre"], scene.options["stop"], scene.params.mass
    wheel = (0.0, 0.0, 0.0)
    if tyre is not None:
        limit = (mass + tyre.unsprung_mass) * 9.80665 / tyre.rate
        wheel = (limit, tyre.rate / tyre.unsprung_mass, mass / tyre.unsprung_mass)
    rubber = (0.0, 0.0) if stop is None else (stop.travel, stop.rate / mass)
    return (*wheel, *rubber, scene.options["road"].knot_spacing, float(small))


@kernel
def denormal(state, settings, step):
    """Before the first step, put travel and velocities below the smallest normal numbers, where the facts say so."""
    if step == 0 and settings.facts[6] > 0.0:
        size = 10.0 ** (-320.0 + 20.0 * uniform(settings.key, 0))
        state.travel, state.velocity = size, -size
        if settings.facts[0] > 0.0:
            state.deflection, state.hub_velocity = -size, 0.5 * size


@kernel
def _rates(a, b, c, d, gamma, drag, w2, push, climb, facts):
    """Rates of travel, velocity, deflection and hub velocity; without a tyre the last two are 0."""
    limit, grip, ratio, travel, rubber, _, _ = facts
    below = climb if limit == 0.0 else d
    stop = 0.0
    if rubber > 0.0 and abs(a) > travel:
        stop = rubber * (a - math.copysign(travel, a))
    inner = w2 * a + stop
    up = push - inner - gamma * (b - drag * below)
    if limit == 0.0:
        return b - climb, up, 0.0, 0.0
    return b - d, up, d - climb, ratio * (inner + gamma * drag * (b - d) - push) - grip * min(c, limit)


@kernel
def _integrate(before, gamma, drag, w2, push, speed, duration, fine, facts):
    """Travel, velocity, deflection and hub velocity of `before` after `duration` (s), in steps `fine` times as long."""
    a, b, c, d = before.travel, before.velocity, before.deflection, before.hub_velocity
    fastest = math.sqrt((w2 + facts[4]) * (1.0 + facts[2]) + facts[1]) + gamma * (1.0 + facts[2])
    knot, ahead, left = before.knot, before.to_knot, duration
    while left > 0.0:
        piece = min(left, ahead / speed)
        height = before.knots[(knot + 1) % RING] - before.knots[knot % RING]
        climb = speed * height / facts[5]
        steps = 1 + int(piece / (fine * min(_LONGEST, _STEP / fastest)))
        h = piece / steps
        for _ in range(steps):
            k = _rates(a, b, c, d, gamma, drag, w2, push, climb, facts)
            m = 0.5 * h
            p = _rates(a + m * k[0], b + m * k[1], c + m * k[2], d + m * k[3], gamma, drag, w2, push, climb, facts)
            q = _rates(a + m * p[0], b + m * p[1], c + m * p[2], d + m * p[3], gamma, drag, w2, push, climb, facts)
            r = _rates(a + h * q[0], b + h * q[1], c + h * q[2], d + h * q[3], gamma, drag, w2, push, climb, facts)
            n = h / 6.0
            a, b = a + n * (k[0] + 2.0 * (p[0] + q[0]) + r[0]), b + n * (k[1] + 2.0 * (p[1] + q[1]) + r[1])
            c, d = c + n * (k[2] + 2.0 * (p[2] + q[2]) + r[2]), d + n * (k[3] + 2.0 * (p[3] + q[3]) + r[3])
        left, ahead, knot = left - piece, facts[5], knot + 1
    return a, b, c, d


@kernel
def _apart(state, there, before):
    """The largest difference of the motion from `there` over its largest number, lengths and velocities each."""
    a, b, c, d = there
    length = max(abs(a), abs(c), abs(before.travel), abs(before.deflection), 1e-6)
    speed = max(abs(b), abs(d), abs(before.velocity), abs(before.hub_velocity), 1e-5)
    lengths = max(abs(state.travel - a), abs(state.deflection - c)) / length
    return max(lengths, max(abs(state.velocity - b), abs(state.hub_velocity - d)) / speed)


@kernel
def check(before, state, action, params, facts):
    """(failure, difference of the motion from the integration, whether the wheel is off the ground).

    For actuators without a lag and a constant speed. Where the motion is of the smallest numbers, (failure, 0, whether
    all of them together are below the smallest normal one).
    """
    limit, _, _, travel, rubber, _, small = facts
    if limit > 0.0 and (state.deflection < limit - NEAR if state.airborne else state.deflection > limit + NEAR):
        return _TYRE, 0.0, False
    if rubber > 0.0:
        beyond = abs(state.travel) - travel
        if beyond > NEAR if state.side == 0.0 else state.side * state.travel < travel - NEAR:
            return _STOP, 0.0, False
    if small > 0.0:
        size = abs(state.travel) + abs(state.velocity) + abs(state.deflection) + abs(state.hub_velocity)
        return (0 if 0.0 < size <= SMALLEST else _GROWN), 0.0, size < 2.3e-308
    gamma = params.damping_low * (params.damping_high / params.damping_low) ** (0.5 + 0.5 * action[0])
    w2 = params.spring_rate / params.mass
    w2 *= params.modulus_low * (params.modulus_high / params.modulus_low) ** (0.5 + 0.5 * action[1])
    apart = math.inf
    for fine in (1.0, 0.1, 0.01, 0.001):  # a force that sets in makes an error of the second order in the steps
        if not apart <= ALIKE:
            there = _integrate(before, gamma, params.relative, w2, 0.0, params.speed, params.dt, fine, facts)
            apart = _apart(state, there, before)
    return (0 if apart <= ALIKE else _MOTION), apart, bool(state.airborne)
