"""Densities of a road's height over the wave number n [cycle/m]: one-sided, in m^3 = m^2 per cycle/m.

ISO 8608: Gd(n) = Gd(n0) (n/n0)^-2 with n0 = 0.1 cycle/m. Class A has the geometric mean Gd(n0) = 16e-6 m^3 and each
further class four times that; the limits between classes are at twice the mean. A road in this package differs from
that line in three ways that are known exactly, and the vehicle meets `met_density`:

- `road_density`: below the cut-off n_c the density is flat, so it is finite; lower than the line by 1 + (n_c/n)^2.
- `knot_density`: the knots are samples; what lies above half a wave per spacing h folds back, higher by 1 / sinc^2 with
  sinc = sin(pi n h) / (pi n h), to some 1e-5 (exactly, by the formula there).
- `met_density`: between knots the road is straight, lower than the knots by sinc^4: in all lower by sinc^2.

So the line is met within 1 % from 12 n_c to 0.045 / h: with n_c = 0.011 cycle/m and h = 0.05 m from 0.132 to
0.9 cycle/m, at 20 m/s from 2.6 to 18 Hz. With h = 0.2 m that ends at 0.225 cycle/m; at 0.5 cycle/m 3 % are missing.

A popular recipe for a sum of cosines, with amplitudes sqrt(dn) 2^k 1e-3 (n0/n) and k = 3 for class A, does not make the
class means: sqrt(2 Gd(n) dn) are the amplitudes of the density Gd, so k = 3 has Gd(n0) = 32e-6, the limit between A and
B, twice the mean.
"""

from __future__ import annotations

import numpy as np

from vr_envs.models.road import roughness_deviation
from vr_envs.models.road_options import REFERENCE_NUMBER, Road


def iso_density(number: np.ndarray, reference: float) -> np.ndarray:
    """The standard's line at the wave numbers `number` [cycle/m] for Gd(n0) = `reference` [m^3]."""
    return reference * (REFERENCE_NUMBER / number) ** 2


def road_density(number: np.ndarray, road: Road) -> np.ndarray:
    """Density of the random process whose samples are the knots; `road` has the mean of its class."""
    return road.density * REFERENCE_NUMBER**2 / (number**2 + road.cutoff**2)


def knot_density(number: np.ndarray, road: Road) -> np.ndarray:
    """Density of the heights of the knots, up to half a cycle per spacing; beyond it repeats itself."""
    deviation = roughness_deviation(road.density, road.cutoff)
    gap = (1.0 - road.memory) ** 2 + 4.0 * road.memory * np.sin(np.pi * number * road.knot_spacing) ** 2
    return 2.0 * road.knot_spacing * (deviation * road.innovation) ** 2 / gap


def met_density(number: np.ndarray, road: Road) -> np.ndarray:
    """Density of the polygon through the knots: the road that a wheel which follows the ground meets."""
    return knot_density(number, road) * np.sinc(number * road.knot_spacing) ** 4
