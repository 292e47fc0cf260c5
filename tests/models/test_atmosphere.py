"""The ISA against its table, its differential equation and the definitions of the airspeeds."""

import math

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vr_envs.models import atmosphere as air
from vr_envs.models.autopilot import Params
from vr_envs.models.autopilot_options import Atmosphere
from vr_envs.models.record import pack

PARAMS, OPTION = pack(Params()), pack(Atmosphere())


# ISO 2533, geopotential altitude: K, Pa, kg/m^3, m/s
@pytest.mark.parametrize(
    ("altitude", "temperature", "pressure", "density", "sound"),
    [
        (0.0, 288.15, 101325.0, 1.2250, 340.294),
        (1000.0, 281.65, 89874.6, 1.11164, 336.434),
        (5000.0, 255.65, 54019.9, 0.736116, 320.529),
        (10000.0, 223.15, 26436.3, 0.412707, 299.463),
        (11000.0, 216.65, 22632.1, 0.363918, 295.069),
        (15000.0, 216.65, 12044.6, 0.193674, 295.069),
        (20000.0, 216.65, 5474.89, 0.0880349, 295.069),
    ],
)
def test_table(altitude: float, temperature: float, pressure: float, density: float, sound: float) -> None:
    assert air.temperature(altitude) == pytest.approx(temperature, rel=1e-12)
    assert air.pressure(altitude) == pytest.approx(pressure, rel=5e-6)
    assert air.density(altitude) == pytest.approx(density, rel=5e-6)
    assert air.sound_speed(altitude) == pytest.approx(sound, rel=5e-6)


def test_air_at_rest_carries_its_own_weight() -> None:
    """p' = -rho g, with rho from the gas law, from sea level through both layers."""
    p = [101325.0]
    for begin, end in ((0.0, 11000.0), (11000.0, 20000.0)):
        leg = solve_ivp(
            lambda h, p: -p * 9.80665 / (287.05287 * max(288.15 - 0.0065 * h, 216.65)), (begin, end), p, "DOP853",
            rtol=1e-13, atol=1e-9,
        )  # fmt: skip
        p = leg.y[:, -1]
        assert air.pressure(end) == pytest.approx(p[0], rel=1e-12)


@pytest.mark.parametrize("altitude", [0.0, 3000.0, 11000.0, 11000.001, 14000.0])
def test_equivalent_airspeed_has_the_same_dynamic_pressure(altitude: float) -> None:
    measured = air.airspeed(altitude, 200.0, OPTION)
    assert air.density(0.0) * measured**2 == pytest.approx(air.density(altitude) * 200.0**2, rel=1e-14)
    assert air.true_airspeed(altitude, measured, OPTION) == pytest.approx(200.0, rel=1e-15)


def test_equivalent_airspeed_is_exact_to_rounding_from_below_the_ground_to_the_tropopause() -> None:
    with mpmath.workdps(40):
        gravity, lapse, gas, sea = (mpmath.mpf(v) for v in (9.80665, 0.0065, 287.05287, 288.15))
        for altitude in (*np.linspace(-600.0, 11000.0, 400), -1e-9, 0.0, 1e-9):
            expected = (1 - lapse * mpmath.mpf(altitude) / sea) ** ((gravity / (lapse * gas) - 1) / 2)
            assert abs(air.equivalent_share(altitude) / expected - 1) < 1e-15, altitude


def test_without_an_atmosphere_the_airspeed_is_the_true_one() -> None:
    assert air.airspeed(9000.0, 200.0, None) == 200.0
    assert air.true_airspeed(9000.0, 200.0, None) == 200.0
    assert air.highest_airspeed(9000.0, PARAMS, None) == 250.0


def test_mach_limits_the_operating_range_from_above() -> None:
    """The equivalent airspeed of a Mach number is M a0 sqrt(p / p0)."""
    assert air.highest_airspeed(300.0, PARAMS, OPTION) == 250.0
    for altitude in (5000.0, 10000.0, 12000.0):
        expected = min(250.0, 0.79 * 340.294 * math.sqrt(air.pressure(altitude) / 101325.0))
        assert air.highest_airspeed(altitude, PARAMS, OPTION) == pytest.approx(expected, rel=1e-6)
    assert air.highest_airspeed(10000.0, PARAMS, OPTION) < 250.0


@pytest.mark.parametrize("altitude", [4000.0, 13000.0])
def test_rate_of_change_of_the_airspeed_is_its_derivative_along_a_climb(altitude: float) -> None:
    climb, acceleration, step = 12.0, 0.3, 0.01
    rate = air.airspeed_rate(altitude, air.airspeed(altitude, 200.0, OPTION), climb, acceleration, OPTION)
    after = air.airspeed(altitude + climb * step, 200.0 + acceleration * step, OPTION)
    before = air.airspeed(altitude - climb * step, 200.0 - acceleration * step, OPTION)
    assert rate == pytest.approx((after - before) / (2.0 * step), rel=1e-6)
    assert air.airspeed_rate(altitude, 200.0, climb, acceleration, None) == acceleration
