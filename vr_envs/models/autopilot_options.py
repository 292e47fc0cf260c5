"""What a scene of the autopilot may add to the lecture's aircraft.

An absent option is passed to the kernels as None and compiled away.
"""

from __future__ import annotations

import dataclasses
import math
from typing import ClassVar

from vr_envs.models.constants import G
from vr_envs.models.record import quantity


@dataclasses.dataclass(frozen=True)
class Envelope:
    """Limits that depend on the flight state: climb falls with altitude, turn rate with speed."""

    cruise_climb: float = quantity(6.0, "m/s", "largest climb rate at cruise altitude", low=0.0, high=100.0)
    cruise_altitude: float = quantity(11000.0, "m", "where that holds; linear in between", low=100.0, high=20000.0)
    bank: float = quantity(math.radians(25.0), "rad", "largest bank angle (ICAO Doc 8168)", low=0.01, high=1.4)

    DERIVED: ClassVar[tuple[str, ...]] = ("lateral",)

    @property
    def lateral(self) -> float:
        """Lateral acceleration of a level turn at the largest bank, g tan(bank) [m/s^2]."""
        return G * math.tan(self.bank)


@dataclasses.dataclass(frozen=True)
class Energy:
    """Climbing and accelerating draw on one power: -g idle_sink <= g v_y + v a <= g (climb limit).

    It binds the commanded pair; climb has priority, the acceleration command gives way.
    """

    idle_sink: float = quantity(8.0, "m/s", "sink rate at constant speed with idle thrust", low=0.1, high=100.0)


@dataclasses.dataclass(frozen=True)
class Lags:
    """The rates follow the commands as first-order lags with limited rates of change."""

    vertical: float = quantity(2.5, "s", "time constant of vertical speed", low=0.05, high=60.0)
    along: float = quantity(3.5, "s", "time constant of acceleration", low=0.05, high=60.0)
    turn: float = quantity(1.8, "s", "time constant of turn rate", low=0.05, high=60.0)
    vertical_slew: float = quantity(1.5, "m/s^2", "largest normal acceleration (BADA civil limit)", low=0.01, high=50.0)
    jerk: float = quantity(0.15, "m/s^3", "largest rate of change of acceleration", low=0.001, high=50.0)
    roll_in: float = quantity(4.0, "s", "time from level flight to the largest turn rate", low=0.01, high=60.0)


@dataclasses.dataclass(frozen=True)
class Atmosphere:
    """The ISA: airspeeds that are measured, demanded and limited are equivalent ones, v sqrt(rho / rho0).

    The stall speed, the top speed and the operating range are equivalent airspeeds too, and Mach numbers limit
    them from above.
    """

    mach_high: float = quantity(0.79, "", "highest Mach number in operation", low=0.1, high=0.95)
    top_mach: float = quantity(0.86, "", "Mach number above which the aircraft breaks up", low=0.1, high=0.99)


@dataclasses.dataclass(frozen=True)
class Wind:
    """A steady wind: it moves the aircraft over the ground and leaves its airspeed alone."""

    speed: float = quantity(10.0, "m/s", "wind speed, at sea level where there is a shear", low=0.0, high=200.0)
    origin: float = quantity(0.0, "rad", "direction that it comes from, as a heading", low=-math.pi, high=math.pi)


@dataclasses.dataclass(frozen=True)
class Shear:
    """A wind that grows with altitude: climbing into it changes the airspeed."""

    gradient: float = quantity(0.003, "1/s", "growth of the wind speed with altitude", low=0.0, high=0.2)
    origin: float = quantity(0.0, "rad", "direction that it comes from, as a heading", low=-math.pi, high=math.pi)


@dataclasses.dataclass(frozen=True)
class Turbulence:
    """Dryden turbulence of MIL-F-8785C along, across and vertical to the path.

    Light, moderate and severe of the standard are a wind of 15, 30 and 45 kt (7.7, 15.4, 23.2 m/s) at 20 ft, and
    about 1.5, 3 and 6 m/s above 2000 ft.
    """

    wind_20ft: float = quantity(3.0, "m/s", "wind at 20 ft, W20, that sets the low-altitude gusts", low=0.0, high=60.0)
    sigma: float = quantity(0.5, "m/s", "standard deviation of each gust above 2000 ft", low=0.0, high=20.0)


@dataclasses.dataclass(frozen=True)
class Track:
    """The ground track (x, z) is computed."""

    x: float = quantity(0.0, "m", "start, x", low=-1e7, high=1e7)
    z: float = quantity(0.0, "m", "start, z", low=-1e7, high=1e7)


@dataclasses.dataclass(frozen=True)
class Textbook:
    """Option, and the engine of that name: the lecture's recurrence at a fixed step instead of the exact motion."""

    OPTIONS: ClassVar[tuple[str, ...]] = (
        "envelope",
        "energy",
        "track",
        "demands",
        "plan",
        "sensing",
        "metrics",
        "textbook",
    )

    step: float = quantity(
        1.0, "s", "time step at most; an interval is a whole number of equal steps", low=1e-4, high=10.0
    )


OPTIONS: dict[str, type] = {
    "envelope": Envelope,
    "energy": Energy,
    "lags": Lags,
    "atmosphere": Atmosphere,
    "wind": Wind,
    "shear": Shear,
    "turbulence": Turbulence,
    "track": Track,
    "textbook": Textbook,
}
"""The model's options, in the order in which kernels take their records."""
