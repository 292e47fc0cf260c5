"""Bank and load factors against the known turns."""

import math

import pytest

from vr_envs.models.load_factor import bank, lateral_load_factor, normal_load_factor

KNOT = 1852.0 / 3600.0


@pytest.mark.parametrize(("knots", "degrees"), [(150, 22.4), (250, 34.5), (350, 43.9), (450, 51.0)])
def test_bank_of_the_standard_turn(knots: float, degrees: float) -> None:
    """3 deg/s at these true airspeeds, known from handbooks to a tenth of a degree."""
    assert math.degrees(bank(math.radians(3.0), knots * KNOT)) == pytest.approx(degrees, abs=0.06)


def test_load_factor_of_a_level_turn_is_the_secant_of_the_bank() -> None:
    angle = bank(-0.05, 200.0)
    assert angle < 0.0
    assert normal_load_factor(-0.05, 200.0, 0.0) == pytest.approx(1.0 / math.cos(angle), rel=1e-15)
    assert lateral_load_factor(-0.05, 200.0) == pytest.approx(math.tan(angle), rel=1e-15)


def test_pulling_up_adds_to_the_weight() -> None:
    assert normal_load_factor(0.0, 200.0, 9.80665) == pytest.approx(2.0, rel=1e-15)
    assert normal_load_factor(0.0, 200.0, -9.80665) == 0.0
