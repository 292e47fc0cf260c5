"""A linear ride over a random road, in the frequency domain: what a long ride comes to, without riding it.

A quarter car in which nothing switches, lifts off or meets a stop answers a road r with transfer functions. With the
sprung mass ms at height zs, the unsprung mass mu at zu, both from static equilibrium, and s = i 2 pi f,

    ms s^2 zs = -(k + c s)(zs - zu) - sky s zs
    mu s^2 zu = +(k + c s)(zs - zu) + sky s zs - kt (zu - r)

where `sky` is what an ideal skyhook adds: a force between mass and wheel in proportion to the velocity of the mass.
Without a tyre the wheel follows the ground: zu = r. A road whose heights have the one-sided density G(n) over wave
number n [cycle/m] has G(f / V) / V over frequency at the speed V, so that the mean square of a quantity with the
response H(f) is the integral of |H(V n)|^2 G(n) over n.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vr_envs.models.constants import G
from vr_envs.models.weighting import INTERVAL, sampled_wk, wk

ISO_BAND = (0.011, 2.83)  # cycle/m, of ISO 8608
POINTS = 20_001  # of an integral; even in the logarithm, the responses have no sharp peak
BINS, FOLDS = 1 << 14, 40  # of a sampled spectrum: lines below half the rate, multiples of the rate that fold back

Density = Callable[[np.ndarray], np.ndarray]


@dataclasses.dataclass(frozen=True)
class Vehicle:
    """A linear quarter car; without an unsprung mass and a tyre rate its wheel follows the ground."""

    sprung_mass: float  # kg
    spring_rate: float  # N/m
    damping: float  # N s/m, between mass and wheel
    unsprung_mass: float | None = None  # kg
    tyre_rate: float | None = None  # N/m
    sky: float = 0.0  # N s/m, of an ideal skyhook with its reaction on the wheel

    @property
    def static_load(self) -> float:
        """Force on the ground at rest [N]."""
        return (self.sprung_mass + (self.unsprung_mass or 0.0)) * G


class Response(NamedTuple):
    """Complex response to one metre of road, each of the frequencies' shape."""

    acceleration: np.ndarray  # of the sprung mass, 1/s^2
    travel: np.ndarray  # zs - zu, 1
    deflection: np.ndarray  # of the tyre, zu - r, 1


class Rms(NamedTuple):
    """Root mean squares of a long ride."""

    weighted: float  # acceleration through Wk, m/s^2
    acceleration: float  # m/s^2
    travel: float  # m
    tyre_load: float  # dynamic tyre load over the static one, 1; 0 without a tyre


def response(frequency: np.ndarray, vehicle: Vehicle) -> Response:
    """How `vehicle` answers a road that rises and falls at `frequency` [Hz], any shape, positive."""
    s = 2j * np.pi * np.asarray(frequency, float)
    link = vehicle.spring_rate + vehicle.damping * s
    own = vehicle.sprung_mass * s**2 + vehicle.sky * s
    body_of_hub = link / (own + link)
    hub = np.ones_like(s)
    if vehicle.unsprung_mass is not None and vehicle.tyre_rate is not None:
        # the suspension lifts the hub with the force that it takes from the sprung mass
        inertia = vehicle.unsprung_mass * s**2 + vehicle.sprung_mass * s**2 * body_of_hub
        hub = vehicle.tyre_rate / (vehicle.tyre_rate + inertia)
    body = body_of_hub * hub
    return Response(s**2 * body, body - hub, hub - 1.0)


def ride_rms(vehicle: Vehicle, speed: float, density: Density, band: tuple[float, float] = ISO_BAND) -> Rms:
    """Root mean squares of a long ride at `speed` [m/s].

    Args:
        vehicle: what rides.
        speed: forward speed [m/s].
        density: one-sided density of the road [m^3] at wave numbers [cycle/m], as those of `road_density`.
        band: wave numbers that the road has [cycle/m]; beyond them it is taken to have none.
    """
    number = np.geomspace(*band, POINTS)
    frequency = speed * number
    found = response(frequency, vehicle)
    # dn = n d(ln n)
    power, logarithm = density(number) * number, np.log(number)

    def rms(values: np.ndarray) -> float:
        return float(np.sqrt(np.trapezoid(np.abs(values) ** 2 * power, logarithm)))

    tyre = 0.0 if vehicle.tyre_rate is None else vehicle.tyre_rate * rms(found.deflection) / vehicle.static_load
    return Rms(rms(found.acceleration * wk(frequency)), rms(found.acceleration), rms(found.travel), tyre)


def metered_rms(vehicle: Vehicle, speed: float, density: Density) -> tuple[float, float]:
    """What `ride_meter` shows in a long ride: rms of the weighted and of the unweighted acceleration [m/s^2].

    It sees the mean acceleration of each tick, and takes what is quicker than half the rate of the ticks for slower
    motion. Ticks and road are taken to be out of step: where the ride passes a whole number of knots per tick, kinks
    fall on ticks, and under a wheel that follows the ground the meter shows up to 10 % more.
    """
    rate = 1.0 / INTERVAL
    frequency = (np.arange(BINS) + 0.5) * (0.5 * rate / BINS)
    power = np.zeros(BINS)
    for fold in range(-FOLDS, FOLDS + 1):
        true = np.abs(frequency + fold * rate)
        mean = response(true, vehicle).acceleration * np.sinc(true * INTERVAL)
        power += np.abs(mean) ** 2 * density(true / speed) / speed
    step = frequency[1] - frequency[0]
    weighted = np.abs(sampled_wk(frequency)) ** 2 * power
    return float(np.sqrt(weighted.sum() * step)), float(np.sqrt(power.sum() * step))
