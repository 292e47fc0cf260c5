"""The closed forms against each other, the exact simulation, and the numbers that the report's figures imply."""

import math

import numpy as np
import pytest

from vr_envs.experiments.bounce import (
    launches,
    lower_bound,
    newton,
    orbit_phases,
    orbit_residual,
    period_one_apex,
    period_one_launch,
    period_one_phase,
    restitution_of_phase,
    upper_bound,
    vertical,
    z_omega,
)
from vr_envs.experiments.simulation import scan


@pytest.mark.parametrize(
    ("restitution", "bounds"),
    [
        (0.68, [(5.87, 11.74), (11.74, 15.53), (17.6, 20.3), (23.5, 25.6)]),
        (0.75, [(4.40, 10.94), (8.81, 13.33), (13.21, 16.57), (17.61, 20.26)]),
        (0.856, [(2.39, 10.16), (4.78, 10.97), (7.17, 12.20), (9.57, 13.74)]),
    ],
)
def test_bounds(restitution, bounds):
    params = vertical(20.0, restitution)
    for m, (low, high) in enumerate(bounds, start=1):
        assert lower_bound(m, params) == pytest.approx(low, abs=0.06)
        assert upper_bound(m, params) == pytest.approx(high, abs=0.06)


@pytest.mark.parametrize("m", [1, 2, 5])
def test_upper_bound_is_where_an_eigenvalue_of_the_impact_map_is_minus_one(m):
    """Jacobian of (time, velocity): determinant alpha^2, trace 1 + alpha^2 + (1 + alpha)^2 a / g."""
    params = vertical(20.0, 0.75)
    high = upper_bound(m, params)
    acceleration = -high * math.sin(period_one_phase(high, m, params))
    trace = 1 + 0.75**2 + (1 + 0.75) ** 2 * acceleration / params.gravity
    assert 1 + trace + 0.75**2 == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("m", [1, 2, 3])
def test_period_one_satisfies_the_equations_of_motion(m):
    params = vertical(20.0, 0.75)
    acceleration = 0.5 * (lower_bound(m, params) + upper_bound(m, params))
    phase = period_one_phase(acceleration, m, params)
    assert abs(orbit_residual([phase], [m], acceleration, 0.75, 9.81, z_omega(params))[0]) < 1e-15
    assert restitution_of_phase(acceleration, phase, m, 9.81) == pytest.approx(0.75, rel=1e-13)
    motions, starts = period_one_launch(params, acceleration, m)
    kept, counts, _ = scan(params, motions, starts, 0, 6)
    assert counts[0] == 6
    np.testing.assert_allclose(kept["phase"][0], phase, atol=1e-12)
    top = kept["z"][0] + kept["w_out"][0] ** 2 / (2 * 9.81)
    np.testing.assert_allclose(top, period_one_apex(acceleration, m, params), rtol=1e-12)


def test_period_two_of_the_equations_is_the_period_two_of_the_simulation():
    params = vertical(30.0, 0.68)
    phases = orbit_phases([0.7, 1.3], [1, 1], 11.95, params)
    np.testing.assert_allclose(phases, [0.765, 1.315], atol=1e-3)
    motions, starts = period_one_launch(params, 11.95, 1, nudge=1e-3)
    kept, _, _ = scan(params, motions, starts, 1000, 8)
    np.testing.assert_allclose(np.sort(kept["phase"][0])[[0, -1]], phases, atol=1e-11)


def test_newton_finds_a_root_or_says_that_there_is_none():
    root = newton(lambda x: np.array([x[0] ** 2 - 2.0, x[0] * x[1] - 1.0]), [1.0, 1.0])
    np.testing.assert_allclose(root, [math.sqrt(2.0), math.sqrt(0.5)], rtol=1e-14)
    with pytest.raises(ArithmeticError, match="no root"):
        newton(lambda x: x**2 + 1.0, [1.0])


def test_below_the_bound_there_is_no_phase():
    params = vertical(20.0, 0.75)
    with pytest.raises(ValueError, match=r"needs a peak acceleration of 4\.403"):
        period_one_phase(4.0, 1, params)


def test_launches_leave_with_the_speed_asked_for():
    params = vertical(20.0, 0.5)
    motions, starts = launches(params, [10.0, 20.0], [0.3, 4.0], 0.2)
    np.testing.assert_array_equal(starts["motion"], motions)
    size = np.array([10.0, 20.0]) / z_omega(params) ** 2
    np.testing.assert_allclose(starts["z"], size * np.sin([0.3, 4.0]), rtol=1e-14)
    np.testing.assert_allclose(starts["w"], size * z_omega(params) * np.cos([0.3, 4.0]) + 0.2, rtol=1e-14)
