"""What a road may be made of. An absent option is passed to the kernels as None and compiled away."""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from vr_envs.models.csv_columns import read_columns
from vr_envs.models.record import quantity

RING = 128  # knots kept, a power of two; at least the next RING - 3 are ahead of the wheel
RAW = 64  # knots of the bare profile kept for a wheel of finite radius, a power of two
REFERENCE_NUMBER = 0.1  # cycle/m, n0 of ISO 8608
POINTS = 4096  # of a measured profile, at most
SAME_PLACE = 1e-9  # m: closer than this to where an obstacle begins or ends is there, in spite of rounding

_KINDS = ("bump", "pothole", "kerb", "washboard", "ramp")
POTHOLE, KERB, WASHBOARD, RAMP = (float(_KINDS.index(kind)) for kind in _KINDS[1:])
_UNEVEN = 0.01  # of their distance: points of a file that lie so near to equal distances are taken to lie there
_RESOLVED = 4.0  # knot spacings in the shortest wave or slope of an obstacle, at least


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
    """Option: a measured profile, straight between its points, added to the road.

    The ride begins on its first point, and all heights count from there; the last height goes on. It is sampled at the
    road's knots, which is exact where `spacing` is a whole multiple of their distance. The scene takes the path of a
    CSV file in its place, such as docs/road_profile.csv.
    """

    spacing: float = quantity(0.2, "m", "distance between the points", low=1e-3, high=100.0)
    height: tuple[float, ...] = quantity((0.0,), "m", "heights", low=-1e4, high=1e4, shape=(POINTS,))

    DERIVED = ("points",)

    @property
    def points(self) -> float:
        """Number of points."""
        return float(len(self.height))

    @staticmethod
    def read(path: str | os.PathLike[str]) -> dict[str, Any]:
        """The fields of a profile from the columns distance_m and height_m of a CSV file with a header row.

        Points at unequal distances are replaced by points at the smallest of these distances, on the straight lines
        between them; differences of a hundredth, as from rounding, are let pass.

        Raises:
            ValueError: the file cannot be read, a number is missing, distances do not increase, or there are too few or
                too many points; it names the file and the line.
        """
        lines, columns = read_columns(path, ("distance_m", "height_m"), "profile")
        where, distance = f"profile {str(path)!r}", np.array(columns["distance_m"])
        if len(distance) < 2:
            raise ValueError(f"{where} has {len(distance)} points; give at least 2")
        gaps = np.diff(distance)
        if gaps.min() <= 0.0:
            worst = int(np.argmax(gaps <= 0.0)) + 1
            raise ValueError(
                f"{where}, line {lines[worst]}: distance_m = {distance[worst]:g} is not allowed; it must be above the "
                f"{distance[worst - 1]:g} before it"
            )
        length, smallest, uniform = float(distance[-1] - distance[0]), float(gaps.min()), float(gaps.mean())
        even = distance[0] + uniform * np.arange(len(distance))
        if np.abs(distance - even).max() <= _UNEVEN * uniform:
            smallest = uniform
        if length > (POINTS - 1) * smallest * (1.0 + 1e-9):
            raise ValueError(
                f"{where}: points {smallest:g} m apart over {length:g} m are not allowed; "
                f"give at most {POINTS} points: a shorter piece of road, or larger distances between them"
            )
        if smallest == uniform:
            return {"spacing": uniform, "height": tuple(columns["height_m"])}
        places = distance[0] + smallest * np.arange(math.ceil(length / smallest - 1e-6) + 1)
        return {"spacing": smallest, "height": tuple(np.interp(places, distance, columns["height_m"]).tolist())}


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
    """Option: one obstacle of a test track, or the same again and again, sampled at the road's knots.

    A kerb's steps are as steep as the knots allow: each takes the last piece between two knots before its place. The
    centre of a wheel of finite radius takes them more softly.
    """

    kind: str = quantity(
        "bump",
        "",
        "bump, pothole: (1 - cos)/2, up or down; kerb: a step up, level, a step down; washboard: whole sines; ramp: a "
        "slope up, level, a slope down",
        choices=_KINDS,
    )
    height: float = quantity(0.05, "m", "height or depth; of a washboard's crests over its mean", low=0.0, high=1.0)
    length: float = quantity(2.0, "m", "of a bump, pothole or washboard; of each slope of a ramp", low=0.01, high=1e3)
    top: float = quantity(2.0, "m", "length of the level top of a kerb or ramp", low=0.01, high=1e5)
    pitch: float = quantity(1.0, "m", "wavelength of a washboard", low=0.05, high=100.0)
    first: float = quantity(20.0, "m", "where the first one begins", low=0.0, high=1e5)
    every: float = quantity(0.0, "m", "distance from one to the next; 0: there is only one", low=0.0, high=1e5)

    DERIVED = ("form", "extent")

    @property
    def form(self) -> float:
        """The kind, as a number."""
        return float(_KINDS.index(self.kind))

    @property
    def extent(self) -> float:
        """Length [m] from end to end."""
        if self.kind == "kerb":
            return self.top
        if self.kind == "ramp":
            return 2.0 * self.length + self.top
        if self.kind == "washboard":
            return self.pitch * math.floor(self.length / self.pitch + 1e-9)
        return self.length


@dataclasses.dataclass(frozen=True)
class Wheel:
    """Option: a wheel of finite radius: its centre runs along the upper envelope of circles about the profile."""

    radius: float = quantity(0.3, "m", "radius of the wheel", low=0.01, high=5.0)


def check_road(options: Mapping[str, Any]) -> None:
    """Check the options road, profile, bumps, obstacle and wheel of a scene, None where absent, against each other.

    Raises:
        ValueError: a rule is broken; it says what was given, what is allowed and what to do.
    """
    road, profile, bumps, obstacle, wheel = (options[k] for k in ("road", "profile", "bumps", "obstacle", "wheel"))
    orders: list[tuple[str, float, str, float]] = []
    if road is None:
        for name in ("profile", "bumps", "obstacle", "wheel"):
            if options[name] is not None:
                raise ValueError(f"{name} = {{...}} is not allowed without a road; give road = true, or {name} = null")
        return
    if profile is not None and profile.points > 1.0:
        orders.append(("road.knot_spacing", road.knot_spacing, "profile.spacing", profile.spacing))
    if bumps is not None:
        orders += [
            ("bumps.low", bumps.low, "bumps.high", bumps.high),
            ("bumps.shortest", bumps.shortest, "bumps.longest", bumps.longest),
            ("2 bumps.longest", 2.0 * bumps.longest, "bumps.stretch", bumps.stretch),
        ]
    if obstacle is not None:
        resolved = f"{_RESOLVED:g} road.knot_spacing", _RESOLVED * road.knot_spacing
        if obstacle.kind == "kerb":
            orders.append(("road.knot_spacing", road.knot_spacing, "obstacle.top", obstacle.top))
        elif obstacle.kind == "washboard":
            orders.append(("obstacle.pitch", obstacle.pitch, "obstacle.length", obstacle.length))
            orders.append((*resolved, "obstacle.pitch", obstacle.pitch))
        else:
            orders.append((*resolved, "obstacle.length", obstacle.length))
        if obstacle.every > 0.0:
            orders.append((f"the {obstacle.kind}'s whole length", obstacle.extent, "obstacle.every", obstacle.every))
    if wheel is not None:
        reach = RAW // 2 - 2  # see `wheel_reach`; the ring holds the two knots next to be drawn as well
        orders.append(("wheel.radius", wheel.radius, f"{reach} road.knot_spacing", reach * road.knot_spacing))
    for low_name, low, high_name, high in orders:
        if low > high * (1.0 + 1e-12):
            raise ValueError(f"{low_name} = {low:g} is not allowed; it must not exceed {high_name} = {high:g}")
