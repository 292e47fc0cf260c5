"""What a scene of the ride may add to the lecture's spring on a wheel.

An absent option is passed to the kernels as None and compiled away.
"""

from __future__ import annotations

import dataclasses
import math
from typing import ClassVar

from vr_envs.models.record import quantity

TICK = 0.01  # s: actuators and the weighting filter work at 100 Hz, whatever the control interval


@dataclasses.dataclass(frozen=True)
class Tyre:
    """Option: a quarter car: the wheel has a mass and a tyre, a spring that pushes but does not pull."""

    unsprung_mass: float = quantity(59.0, "kg", "mass of wheel and axle", low=0.1, high=1e5)
    rate: float = quantity(190e3, "N/m", "spring rate of the tyre", low=1e2, high=1e8)


@dataclasses.dataclass(frozen=True)
class ActuatorLag:
    """First-order lag of the actuators' positions: exact at the ticks, by its mean between them.

    From position p0 towards a command held for the tick dt, the lag of time constant T goes to
    p1 = command + (p0 - command) e^(-dt/T), and its mean on the way is command + (p0 - command) (T/dt)(1 - e^(-dt/T)).
    The ride takes that mean for the whole tick, so that its motion stays exact; the positions are those of the
    logarithms of damping and modulus. A step arrives late by T on the whole: the integral of what is still missing
    is T times the step.
    """

    time_constant: float = quantity(0.015, "s", "time constant", low=1e-4, high=10.0)

    DERIVED = ("share", "missing")

    @property
    def share(self) -> float:
        """Part of the way to the command that is made over a tick."""
        return -math.expm1(-TICK / self.time_constant)

    @property
    def missing(self) -> float:
        """Part of the way that is missing in the mean over a tick."""
        return self.share * self.time_constant / TICK


@dataclasses.dataclass(frozen=True)
class Payload:
    """A load that the controller does not know, drawn per episode."""

    size: float = quantity(1.0, "m/s^2", "largest acceleration that it gives, either way", low=0.0, high=10.0)


@dataclasses.dataclass(frozen=True)
class Cruise:
    """Option: the forward speed is an action too, and there is a time to arrive in.

    The speed goes to the commanded one at the largest acceleration; it starts at the scene's `speed`.
    """

    slowest: float = quantity(5.0, "m/s", "speed commanded by -1", low=0.1, high=100.0)
    fastest: float = quantity(30.0, "m/s", "speed commanded by 1", low=0.1, high=100.0)
    acceleration: float = quantity(3.0, "m/s^2", "largest acceleration and deceleration", low=0.01, high=100.0)
    schedule: float = quantity(20.0, "m/s", "mean speed that the time to arrive asks for", low=0.1, high=100.0)
    lateness: float = quantity(5.0, "m", "distance behind the schedule that halves the reward", low=0.01, high=1e4)


@dataclasses.dataclass(frozen=True)
class Textbook:
    """Option, and the engine of that name: the lecture's recurrence (3.89, 3.90) at a fixed step.

    `reading` is what its h stands for: "A" the height of the ground since the start, "B" the change of that height
    in one step alone, as the slides have it.
    """

    OPTIONS: ClassVar[tuple[str, ...]] = (
        "undulation", "road", "profile", "bumps", "obstacle", "payload", "lag", "preview", "noise", "metrics",
        "textbook",
    )  # fmt: skip

    step: float = quantity(
        1.0 / 60.0, "s", "time step at most; an interval is a whole number of equal steps", low=1e-5, high=10.0
    )
    reading: str = quantity("A", "", "of the lecture's h", choices=("A", "B"))

    DERIVED = ("increments",)

    @property
    def increments(self) -> float:
        """1 for reading B, else 0."""
        return float(self.reading == "B")
