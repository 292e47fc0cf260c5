"""The autopilot's instruments: what they measure with an error, and late."""

from __future__ import annotations

import dataclasses

from vr_envs.models.atmosphere import airspeed
from vr_envs.models.jit import kernel
from vr_envs.models.noise import normal_pair
from vr_envs.models.record import quantity

DELAY = 8  # control intervals, at most
RING = DELAY + 1
MEASURED = 6  # altitude, airspeed, heading, vertical speed, acceleration, turn rate
_DRAWS = 1 << 41  # first pair of the errors' random numbers


@dataclasses.dataclass(frozen=True)
class Sensing:
    """Option: measured values have errors, normal and independent from one observation to the next, and come late."""

    altitude: float = quantity(1.5, "m", "standard deviation of the altitude", low=0.0, high=1e3)
    airspeed: float = quantity(0.25, "m/s", "standard deviation of the airspeed", low=0.0, high=100.0)
    heading: float = quantity(0.002, "rad", "standard deviation of the heading", low=0.0, high=1.0)
    vertical_speed: float = quantity(0.1, "m/s", "standard deviation of the vertical speed", low=0.0, high=100.0)
    acceleration: float = quantity(0.02, "m/s^2", "standard deviation of the acceleration", low=0.0, high=10.0)
    turn_rate: float = quantity(0.001, "rad/s", "standard deviation of the turn rate", low=0.0, high=1.0)
    delay: int = quantity(1, "", "age of what is observed, in control intervals", low=0, high=DELAY)


@kernel
def values(state, atmosphere):  # type: ignore[no-untyped-def]
    """What there is to be measured: altitude, airspeed, heading, vertical speed, acceleration, turn rate."""
    return (
        state.altitude,
        airspeed(state.altitude, state.speed, atmosphere),
        state.heading,
        state.vertical_speed,
        state.acceleration,
        state.turn_rate,
    )


@kernel
def remember(state, atmosphere):  # type: ignore[no-untyped-def]
    """Keep the present values for later observations."""
    slot = state.steps % RING
    present = values(state, atmosphere)
    for k in range(MEASURED):
        state.past[slot, k] = present[k]


@kernel
def measure(state, atmosphere, sensing):  # type: ignore[no-untyped-def]
    """`values` as the instruments show them at the present instant; before the start all was as at the start."""
    if sensing is None:
        return values(state, atmosphere)
    slot = max(0, state.steps - sensing.delay) % RING
    pair = _DRAWS + 3 * state.steps
    altitude, speed = normal_pair(state.key, pair)
    heading, climb = normal_pair(state.key, pair + 1)
    acceleration, turn = normal_pair(state.key, pair + 2)
    return (
        state.past[slot, 0] + sensing.altitude * altitude,
        state.past[slot, 1] + sensing.airspeed * speed,
        state.past[slot, 2] + sensing.heading * heading,
        state.past[slot, 3] + sensing.vertical_speed * climb,
        state.past[slot, 4] + sensing.acceleration * acceleration,
        state.past[slot, 5] + sensing.turn_rate * turn,
    )
