"""Travel stop: an elastic rubber that acts beyond a given travel, with both its contacts located to rounding.

The travel u = zeta - r [m] is the height of the mass over the wheel from the levelled equilibrium. While the road's
slope, the damping and the spring stay as they are,

    u'' + gamma u' + w2 u + stop(u) = push,    stop(u) = w2_stop (u - side travel) beyond side travel, else 0,

with side = +1 or -1, so between contacts the motion is the free motion of a damped spring about an equilibrium. The
rubber's force is continuous and never pulls. Its contacts are found by the certified march of `root.free_step`.
A search that does not end, or more than `MAX_CONTACTS` contacts in one piece of road, is a fault that the caller is
told.
"""

from __future__ import annotations

import dataclasses
import math

from vr_envs.models.jit import kernel
from vr_envs.models.record import quantity
from vr_envs.models.root import free_step
from vr_envs.models.spring import free_motion

RESOLUTION = 1e-16  # s: a smaller step of the march no longer moves the mass
# in one piece of road, of a tick at most: at 1e5 1/s, the fastest motion of any scene, 160 swings of four contacts each
MAX_CONTACTS = 1024
MAX_MARCH = 10_000  # steps of one search; linear where the mass grazes: 1802 in the longest of 6000 such swings


@dataclasses.dataclass(frozen=True)
class TravelStop:
    """Rubber stops at both ends of the spring's travel; the episode ends when one is crushed."""

    travel: float = quantity(0.08, "m", "travel at which a stop is touched, either way", low=1e-3, high=10.0)
    rate: float = quantity(250e3, "N/m", "spring rate of the rubber", low=1.0, high=1e7)
    crush: float = quantity(
        0.015, "m", "compression of the rubber, at a control instant, that ends the episode", low=1e-4, high=10.0
    )


@kernel
def _phase(side, w2, push, w2_stop, travel):
    """Stiffness over mass, and the equilibrium, free (side = 0) or against the stop `side`."""
    stiff = w2 + w2_stop * abs(side)
    return stiff, (push + side * w2_stop * travel) / stiff


@kernel
def _move(u, rate, side, gamma, w2, push, w2_stop, travel, t):
    """Travel and its rate after a time t in which the mass neither touches nor leaves a stop."""
    stiff, centre = _phase(side, w2, push, w2_stop, travel)
    x, rate = free_motion(u - centre, rate, gamma, stiff, t)
    return x + centre, rate


@kernel
def _reach(u, rate, stiff, centre, t):
    """A bound on the square of the way [m^2] in the time t: the energy about the equilibrium falls."""
    return (rate * rate + stiff * (u - centre) * (u - centre)) * t * t


@kernel
def stays_free(u, rate, side, w2, centre, travel, t):
    """Whether it is certain that the mass, in free motion about `centre`, touches no stop within the time t."""
    gap = travel - abs(u)
    return (side == 0.0) & (gap > 0.0) & (_reach(u, rate, w2, centre, t) < gap * gap)


@kernel
def time_to_contact(u, rate, side, gamma, w2, push, w2_stop, travel, t):
    """Time [s] until the mass touches a stop (side = 0) or leaves the stop `side` (+1, -1); `t` if not before t.

    Negative if the search did not end. `u` [m] and `rate` = du/dt [m/s] are the present travel and its rate;
    push [m/s^2] is the constant acceleration.
    """
    stiff, centre = _phase(side, w2, push, w2_stop, travel)
    gap = travel - abs(u) if side == 0.0 else side * u - travel
    if gap <= 0.0 and rate == 0.0:
        # at rest on the boundary the acceleration, which is the same on both sides, decides
        outwards = math.copysign(1.0, u) * stiff * (centre - u)
        return 0.0 if (outwards > 0.0 if side == 0.0 else outwards < 0.0) else t
    if gap > 0.0 and _reach(u, rate, stiff, centre, t) < gap * gap:
        return t
    curvature = (gamma + math.sqrt(stiff)) * math.sqrt(_reach(u, rate, stiff, centre, 1.0))
    elapsed, now, now_rate = 0.0, u, rate
    for _ in range(MAX_MARCH):
        if side == 0.0:
            up = free_step(max(0.0, travel - now), -now_rate, curvature)
            down = free_step(max(0.0, travel + now), now_rate, curvature)
            step = min(up, down)
        else:
            step = free_step(max(0.0, side * now - travel), side * now_rate, curvature)
        # not step > ...: 0/0 is a touch at rest
        if not step > RESOLUTION:
            return elapsed
        elapsed += step
        if elapsed >= t:
            return t
        now, now_rate = free_motion(u - centre, rate, gamma, stiff, elapsed)
        now += centre
    return -1.0


@kernel
def move_with_stop(u, rate, side, gamma, w2, push, w2_stop, travel, t):
    """Travel, its rate, the side of the stop in contact (0 if none), touches and whether it failed, after the time t.

    On a failure the rest is what was known until then.
    """
    touches = 0
    for _ in range(MAX_CONTACTS):
        free_for = time_to_contact(u, rate, side, gamma, w2, push, w2_stop, travel, t)
        if free_for < 0.0:
            break
        u, rate = _move(u, rate, side, gamma, w2, push, w2_stop, travel, free_for)
        t -= free_for
        if t <= 0.0:
            return u, rate, side, touches, False
        u = math.copysign(travel, u)
        touches += side == 0.0
        side = math.copysign(1.0, u) if side == 0.0 else 0.0
    return u, rate, side, touches, True
