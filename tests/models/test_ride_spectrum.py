import dataclasses
from functools import partial

import numpy as np
import pytest

from vr_envs.models.ride_spectrum import ISO_BAND, Vehicle, response, ride_rms
from vr_envs.models.road_density import iso_density

CAR = Vehicle(290.0, 16812.0, 1500.0, 59.0, 190e3)
CLASS_C = partial(iso_density, reference=256e-6)
# up to 100 Hz at 20 m/s and down to almost nothing, as published figures are that do not end at ISO's band
WIDE = (1e-4, 5.0)


def test_response_is_that_of_the_equations_of_motion():
    """State space with the road as input, solved frequency by frequency."""
    ms, mu, k, c, kt, sky = 290.0, 59.0, 16812.0, 1500.0, 190e3, 700.0
    a = np.array([
        [0, 1, 0, 0],
        [-k / ms, -(c + sky) / ms, k / ms, c / ms],
        [0, 0, 0, 1],
        [k / mu, (c + sky) / mu, -(k + kt) / mu, -c / mu],
    ])  # fmt: skip
    frequencies = np.geomspace(0.05, 80, 40)
    found = response(frequencies, dataclasses.replace(CAR, sky=sky))
    for i, f in enumerate(frequencies):
        s = 2j * np.pi * f
        zs, vs, zu, _ = np.linalg.solve(s * np.eye(4) - a, np.array([0, 0, 0, kt / mu]))
        assert found.acceleration[i] == pytest.approx(s * vs, rel=1e-10)
        assert found.travel[i] == pytest.approx(zs - zu, rel=1e-9)
        assert found.deflection[i] == pytest.approx(zu - 1, rel=1e-9)


def test_a_follower_is_the_car_whose_tyre_gives_nothing():
    f = np.geomspace(0.05, 80, 40)
    follower = Vehicle(290.0, 16812.0, 1500.0)
    stiff = response(f, dataclasses.replace(CAR, tyre_rate=1e15))
    for one, other in zip(response(f, follower), stiff, strict=True):
        assert one == pytest.approx(other, rel=1e-7, abs=1e-7)
    assert not response(f, follower).deflection.any()
    assert ride_rms(follower, 20.0, CLASS_C).tyre_load == 0.0


@pytest.mark.parametrize(
    ("damping", "weighted", "travel", "tyre"),
    [(1000, 1.130, 13.3, 0.298), (1500, 1.306, 10.8, 0.262), (2000, 1.470, 9.4, 0.248)],
)
def test_class_c_at_20_m_s(damping, weighted, travel, tyre):
    """Reference figures to their last digit; the tyre load has some 1 % from waves shorter than ISO's band."""
    car = dataclasses.replace(CAR, damping=float(damping))
    iso, wide = ride_rms(car, 20.0, CLASS_C), ride_rms(car, 20.0, CLASS_C, WIDE)
    for found in (iso, wide):
        assert found.weighted == pytest.approx(weighted, abs=6e-4)
        assert 1e3 * found.travel == pytest.approx(travel, abs=0.05)
    assert wide.tyre_load == pytest.approx(tyre, abs=6e-4)
    assert iso.tyre_load == pytest.approx(tyre, rel=0.012)


def test_the_reference_within_a_thousandth():
    assert ride_rms(CAR, 20.0, CLASS_C).weighted == pytest.approx(1.306, rel=1e-3)


def test_a_class_is_a_factor_of_two():
    found = [ride_rms(CAR, 20.0, partial(iso_density, reference=16e-6 * 4**k)) for k in range(5)]
    assert [one.weighted for one in found] == pytest.approx([0.326, 0.653, 1.306, 2.612, 5.224], abs=6e-4)
    for one, other in zip(found, found[1:], strict=False):
        assert np.array(other) == pytest.approx(2 * np.array(one), rel=1e-13)


def test_ideal_skyhook():
    """Half the acceleration at twice the tyre load; its travel has slow parts below ISO's band."""
    sky = dataclasses.replace(CAR, damping=300.0, sky=2000.0)
    iso, wide = ride_rms(sky, 20.0, CLASS_C), ride_rms(sky, 20.0, CLASS_C, WIDE)
    assert (iso.weighted, wide.weighted) == pytest.approx((0.792, 0.792), abs=6e-4)
    assert (1e3 * iso.travel, 1e3 * wide.travel) == pytest.approx((13.6, 13.8), abs=0.05)
    assert (iso.tyre_load, wide.tyre_load) == pytest.approx((0.4863, 0.4876), abs=1e-4)


def test_travel_of_a_follower_on_a_white_road():
    """u'' + gamma u' + w2 u = -r'' with white r' of the two-sided density S has the mean square S / (2 gamma)."""
    gamma, w2, speed = 4.0, 60.0, 20.0
    found = ride_rms(Vehicle(1.0, w2, gamma), speed, CLASS_C, (1e-6, 1e4))
    spectral = (2 * np.pi * 0.1) ** 2 * 256e-6 * speed / 2
    assert found.travel == pytest.approx(np.sqrt(spectral / (2 * gamma)), rel=1e-4)


def test_integral_has_converged(monkeypatch):
    coarse = ride_rms(CAR, 20.0, CLASS_C)
    monkeypatch.setattr("vr_envs.models.ride_spectrum.POINTS", 200_001)
    assert np.array(ride_rms(CAR, 20.0, CLASS_C, ISO_BAND)) == pytest.approx(np.array(coarse), rel=1e-6)
