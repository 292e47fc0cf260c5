"""The autopilot's instruments: what they measure with an error, and late."""

from __future__ import annotations

import dataclasses

from vr_envs.models.record import quantity


@dataclasses.dataclass(frozen=True)
class Sensing:
    """Option: measured values have errors, normal and independent from one observation to the next, and come late."""

    altitude: float = quantity(1.5, "m", "standard deviation of the altitude", low=0.0, high=1e3)
    airspeed: float = quantity(0.25, "m/s", "standard deviation of the airspeed", low=0.0, high=100.0)
    heading: float = quantity(0.002, "rad", "standard deviation of the heading", low=0.0, high=1.0)
    vertical_speed: float = quantity(0.1, "m/s", "standard deviation of the vertical speed", low=0.0, high=100.0)
    acceleration: float = quantity(0.02, "m/s^2", "standard deviation of the acceleration", low=0.0, high=10.0)
    turn_rate: float = quantity(0.001, "rad/s", "standard deviation of the turn rate", low=0.0, high=1.0)
    delay: int = quantity(1, "", "age of what is observed, in control intervals", low=0, high=8)
