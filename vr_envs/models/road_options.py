"""What a road may be made of. An absent option is passed to the kernels as None and compiled away."""

from __future__ import annotations

import dataclasses
import math

from vr_envs.models.record import quantity

POINTS = 4096  # of a measured profile, at most


@dataclasses.dataclass(frozen=True)
class Road:
    """A road of an ISO 8608 class; the density of an episode is drawn about the class mean."""

    iso_class: str = quantity("C", "", "ISO 8608 class, or flat", choices=("flat", *"ABCDEFGH"))
    spread: float = quantity(1.0, "octave", "the density is its mean times 2^U(-spread, spread)", low=0.0, high=4.0)
    knot_spacing: float = quantity(0.2, "m", "distance between knots of the profile", low=0.01, high=10.0)
    cutoff: float = quantity(0.011, "cycle/m", "longest waves: the density is flat below", low=1e-4, high=0.1)

    DERIVED = ("density", "memory", "innovation")

    @property
    def density(self) -> float:
        """Gd(n0) [m^3], the geometric mean of the class."""
        if self.iso_class == "flat":
            return 0.0
        return 16e-6 * 4.0 ** "ABCDEFGH".index(self.iso_class)

    @property
    def memory(self) -> float:
        """Correlation phi of neighbouring knots."""
        return math.exp(-2.0 * math.pi * self.cutoff * self.knot_spacing)

    @property
    def innovation(self) -> float:
        """sqrt(1 - phi^2)."""
        return math.sqrt(-math.expm1(-4.0 * math.pi * self.cutoff * self.knot_spacing))


@dataclasses.dataclass(frozen=True)
class Profile:
    """Option: a measured profile, straight between its points, added to the road; the last height goes on.

    The scene takes the path of a CSV file in its place.
    """

    spacing: float = quantity(0.1, "m", "distance between the points", low=1e-3, high=100.0)
    height: tuple[float, ...] = quantity((0.0,), "m", "heights", low=-100.0, high=100.0, shape=(POINTS,))


@dataclasses.dataclass(frozen=True)
class Bumps:
    """Option: triangular bumps and dips, one at a random place in each stretch, sampled at the road's knots."""

    stretch: float = quantity(40.0, "m", "length of road with one bump or dip", low=1.0, high=1e5)
    low: float = quantity(0.03, "m", "smallest height or depth", low=0.0, high=0.5)
    high: float = quantity(0.08, "m", "largest height or depth", low=0.0, high=0.5)
    shortest: float = quantity(1.0, "m", "smallest distance from foot to top", low=0.1, high=100.0)
    longest: float = quantity(3.0, "m", "largest distance from foot to top", low=0.1, high=100.0)


@dataclasses.dataclass(frozen=True)
class Obstacle:
    """Option: one obstacle of a test track, again and again, sampled at the road's knots."""

    kind: str = quantity(
        "bump",
        "",
        "bump and pothole: half a sine up or down; kerb: a step up; washboard: sines; ramp: a slope up, then level",
        choices=("bump", "pothole", "kerb", "washboard", "ramp"),
    )
    height: float = quantity(0.05, "m", "height or depth; of a washboard's crests over its mean", low=0.0, high=1.0)
    length: float = quantity(2.0, "m", "length over the ground", low=0.01, high=1e3)
    pitch: float = quantity(0.5, "m", "wavelength of a washboard", low=0.05, high=100.0)
    first: float = quantity(20.0, "m", "where the first one begins", low=0.0, high=1e5)
    every: float = quantity(0.0, "m", "distance from one to the next; 0: there is only one", low=0.0, high=1e5)


@dataclasses.dataclass(frozen=True)
class Wheel:
    """Option: a wheel of finite radius: its centre runs along the upper envelope of circles about the profile."""

    radius: float = quantity(0.3, "m", "radius of the wheel", low=0.01, high=5.0)
