"""The linearised map from impact to impact, against the simulation and a known determinant."""

import numpy as np
import pytest

from vr_envs.experiments.bounce import launches, orbit_phases, vertical, z_omega
from vr_envs.experiments.orbit_noise import deviations, impact_maps
from vr_envs.experiments.simulation import scan

ORBITS = [  # restitution, acceleration, phases near by, periods of z between impacts
    (0.68, 10.4, [0.97], [1]),
    (0.68, 11.95, [0.76, 1.31], [1, 1]),
    (0.75, 11.5, [0.70], [2]),
    (0.76, 13.3, [0.615, 1.11], [2, 2]),
]


@pytest.mark.parametrize(("alpha", "acceleration", "guess", "counts"), ORBITS)
def test_the_determinant_over_the_orbit_is_that_of_the_restitution(alpha, acceleration, guess, counts):
    params = vertical(20.0, alpha)
    phases = orbit_phases(guess, counts, acceleration, params)
    maps, _, _ = impact_maps(phases, counts, acceleration, params)
    assert np.prod(np.linalg.det(maps)) == pytest.approx(alpha ** (2 * len(counts)), rel=1e-10)


@pytest.mark.parametrize(("alpha", "acceleration", "guess", "counts"), ORBITS)
def test_the_maps_are_the_simulations_derivative(alpha, acceleration, guess, counts):
    params = vertical(20.0, alpha)
    phases = orbit_phases(guess, counts, acceleration, params)
    maps, by_alpha, out = impact_maps(phases, counts, acceleration, params)
    omega = z_omega(params)

    def following(launch, after):
        """Phase, counted from `after`, and velocity of the impact after a launch from the bar."""
        phase, velocity, restitution = launch
        moved = vertical(20.0, restitution)
        bar = acceleration / omega * np.cos(phase)
        hit = scan(moved, *launches(moved, acceleration, phase, velocity - bar), 0, 1)[0][0, 0]
        return np.array([np.angle(np.exp(1j * (hit["phase"] - after))), hit["w_out"]])

    for i, after in enumerate(np.roll(phases, -1)):
        launch = np.array([phases[i], out[i], alpha])
        steps = np.diag(1e-5 * launch)
        slopes = [(following(launch + d, after) - following(launch - d, after)) / (2.0 * d.max()) for d in steps]
        expected = np.column_stack([maps[i], by_alpha[i]])
        np.testing.assert_allclose(np.column_stack(slopes), expected, rtol=1e-6, atol=1e-7)


def test_deviations_of_period_one_are_those_of_its_noise_by_hand():
    """The variance is the sum of the squares of what is left of all earlier kicks."""
    alpha, acceleration = 0.68, 10.4
    params = vertical(30.0, alpha)
    phases = orbit_phases([0.97], [1], acceleration, params)
    maps, by_alpha, _ = impact_maps(phases, [1], acceleration, params)
    kicks = [np.linalg.matrix_power(maps[0], k) @ by_alpha[0] for k in range(400)]
    phase = 1e-3 * np.sqrt(sum(k[0] ** 2 for k in kicks))
    found = deviations(phases, [1], acceleration, params, 1e-3)
    assert found[0, 2] == pytest.approx(phase, rel=1e-10)
    assert found[0, 1] == pytest.approx(phase * acceleration / z_omega(params) ** 2 * np.cos(phases[0]), rel=1e-10)
