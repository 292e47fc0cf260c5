"""The International Standard Atmosphere (ISO 2533) up to 20 km, and the airspeeds that are measured in it.

Two layers: temperature falls by 6.5 K/km up to 11 km and is constant above. Altitudes are geopotential. Equivalent
airspeed is the speed at sea level that gives the same dynamic pressure, v sqrt(rho / rho0).
"""

from __future__ import annotations

import math

from vr_envs.models.constants import G
from vr_envs.models.elementary import exp, power
from vr_envs.models.jit import kernel
from vr_envs.models.lanes import any_lane, where

TROPOPAUSE = 11000.0  # m
SEA_LEVEL_TEMPERATURE = 288.15  # K
SEA_LEVEL_PRESSURE = 101325.0  # Pa
LAPSE = 0.0065  # K/m
GAS_CONSTANT = 287.05287  # J/(kg K), of dry air
HEAT_RATIO = 1.4  # of the specific heats

_EXPONENT = G / (LAPSE * GAS_CONSTANT)  # of the pressure below the tropopause, 5.25588
_TOP_TEMPERATURE = SEA_LEVEL_TEMPERATURE - LAPSE * TROPOPAUSE
_TOP_PRESSURE = SEA_LEVEL_PRESSURE * (_TOP_TEMPERATURE / SEA_LEVEL_TEMPERATURE) ** _EXPONENT
_PER_HEIGHT = G / (GAS_CONSTANT * _TOP_TEMPERATURE)  # 1/m: decay of pressure and density above the tropopause
SEA_LEVEL_DENSITY = SEA_LEVEL_PRESSURE / (GAS_CONSTANT * SEA_LEVEL_TEMPERATURE)  # kg/m^3
_SHARE_LAPSE = 0.5 * (_EXPONENT - 1.0) * LAPSE  # K/m: times 1 / T the decay of `equivalent_share`
_TOP_ROOT = math.sqrt(_TOP_PRESSURE / (GAS_CONSTANT * _TOP_TEMPERATURE) / SEA_LEVEL_DENSITY)


def _share_series(terms: int) -> tuple[tuple[float, float], ...]:
    """Taylor coefficients of `equivalent_share` about the middle of the lower layer, in units of half its height.

    Pairs of an even and an odd order, highest first; `terms` is even. From the layer's middle to its ends temperature
    changes by 14 %, so the coefficients fall by that factor or faster and 14 of them reach rounding.
    """
    middle = 1.0 - 0.5 * LAPSE * TROPOPAUSE / SEA_LEVEL_TEMPERATURE
    power = 0.5 * (_EXPONENT - 1.0)
    row, ratio = [middle**power], -0.5 * LAPSE * TROPOPAUSE / (middle * SEA_LEVEL_TEMPERATURE)
    for k in range(1, terms):
        row.append(row[-1] * ratio * (power - k + 1) / k)
    return tuple((row[k], row[k + 1]) for k in range(terms - 2, -1, -2))


_SHARE = _share_series(14)


@kernel
def temperature(altitude: float) -> float:
    """Air temperature [K] at an altitude [m]."""
    return SEA_LEVEL_TEMPERATURE - LAPSE * min(altitude, TROPOPAUSE)


@kernel
def pressure(altitude: float) -> float:
    """Static pressure [Pa] at an altitude [m]."""
    if altitude > TROPOPAUSE:
        return _TOP_PRESSURE * math.exp(-_PER_HEIGHT * (altitude - TROPOPAUSE))
    return SEA_LEVEL_PRESSURE * (temperature(altitude) / SEA_LEVEL_TEMPERATURE) ** _EXPONENT


@kernel
def density(altitude: float) -> float:
    """Density [kg/m^3] at an altitude [m]."""
    return pressure(altitude) / (GAS_CONSTANT * temperature(altitude))


@kernel
def sound_speed(altitude: float) -> float:
    """Speed of sound [m/s] at an altitude [m]."""
    return math.sqrt(HEAT_RATIO * GAS_CONSTANT * temperature(altitude))


@kernel
def equivalent_share(altitude: float) -> float:
    """Equivalent over true airspeed, sqrt(rho / rho0), at an altitude [m]."""
    y = altitude * (2.0 / TROPOPAUSE) - 1.0  # a power is twice as slow as its series
    square = y * y
    even, odd = 0.0 * y, 0.0 * y
    for a, b in _SHARE:
        even, odd = even * square + a, odd * square + b
    share = even + y * odd
    above, below = altitude > TROPOPAUSE, altitude < 0.0
    if any_lane(above):
        share = where(above, _TOP_ROOT * exp(-0.5 * _PER_HEIGHT * (altitude - TROPOPAUSE)), share)
    if any_lane(below):
        ratio = temperature(altitude) / SEA_LEVEL_TEMPERATURE
        share = where(below, power(ratio, 0.5 * (_EXPONENT - 1.0)), share)
    return share


@kernel
def airspeed(altitude, speed, atmosphere):  # type: ignore[no-untyped-def]
    """The airspeed [m/s] that is measured, demanded and limited, of a true airspeed `speed` [m/s] at an altitude [m].

    With the option `atmosphere` it is the equivalent airspeed, otherwise the true one.
    """
    if atmosphere is None:
        return speed
    return speed * equivalent_share(altitude)


@kernel
def true_airspeed(altitude, measured, atmosphere):  # type: ignore[no-untyped-def]
    """The inverse of `airspeed`: true airspeed [m/s] of an airspeed as measured [m/s] at an altitude [m]."""
    if atmosphere is None:
        return measured
    return measured / equivalent_share(altitude)


@kernel
def airspeed_rate(altitude, measured, climb, acceleration, atmosphere):  # type: ignore[no-untyped-def]
    """Rate of change [m/s^2] of an airspeed as measured, in still air, at a climb rate and true acceleration.

    Thinner air takes from the equivalent airspeed of a climbing aircraft: (v s)' = v' s + v s (ln s)' h'.
    """
    if atmosphere is None:
        return acceleration
    decay = where(altitude > TROPOPAUSE, 0.5 * _PER_HEIGHT, _SHARE_LAPSE / temperature(altitude))
    return acceleration * equivalent_share(altitude) - decay * climb * measured


@kernel
def airspeed_of_mach(mach: float, altitude: float) -> float:
    """Equivalent airspeed [m/s] of a Mach number at an altitude [m]: M a sqrt(rho / rho0)."""
    return mach * sound_speed(altitude) * equivalent_share(altitude)


@kernel
def highest_airspeed(altitude, params, atmosphere):  # type: ignore[no-untyped-def]
    """Upper end [m/s] of the operating range of airspeeds, as measured, at an altitude [m].

    With the option `atmosphere` the lesser of `params.speed_high` and the equivalent airspeed of its `mach_high`.
    """
    if atmosphere is None:
        return params.speed_high
    return min(params.speed_high, airspeed_of_mach(atmosphere.mach_high, altitude))
