import math

import numpy as np
import pytest

from vr_envs.experiments.road_spectrum import chance, periodogram, road_spectrum, stretches
from vr_envs.models.road_density import iso_density, knot_density
from vr_envs.models.road_options import Road

STRETCHES, KNOTS = 4000, 2048
ROAD = Road(spread=0.0)
OCTAVES = ((0.1, 0.15), (0.15, 0.3), (0.3, 0.6), (0.6, 1.2), (1.2, 2.5))


@pytest.fixture(scope="module")
def heights():
    return stretches(ROAD, STRETCHES, KNOTS, 10**6)


def expected_periodogram(road, knots):
    """Mean of the estimate, exactly: the covariance sd^2 phi^k under the window's own correlation."""
    window = np.sin(np.pi * (np.arange(knots) + 0.5) / knots) ** 2
    correlation = np.fft.irfft(np.abs(np.fft.rfft(window, 2 * knots)) ** 2)
    lag = np.minimum(np.arange(2 * knots), 2 * knots - np.arange(2 * knots))
    covariance = 0.1**2 * math.pi * road.density / (2 * road.cutoff) * road.memory**lag
    power = np.fft.fft(correlation * covariance).real[::2][1 : knots // 2]
    return power * 2 * road.knot_spacing / np.sum(window**2)


@pytest.mark.parametrize("octave", OCTAVES)
def test_the_periodogram_of_the_road_has_ratio_one(heights, octave):
    """Four standard deviations of chance: from 2.0 % (20 bins) to 0.4 % (532 bins) for 4000 stretches of 410 m."""
    number, found = periodogram(heights, ROAD.knot_spacing)
    band = (number >= octave[0]) & (number < octave[1])
    exact = expected_periodogram(ROAD, KNOTS)
    allowed = 4 * chance(STRETCHES, band.sum())
    assert 0.003 < allowed < 0.02
    assert np.mean((found / exact)[band]) == pytest.approx(1.0, abs=allowed)
    assert np.mean((found / knot_density(number, ROAD))[band]) == pytest.approx(1.0, abs=allowed + 0.001)
    line = iso_density(number, 256e-6)
    bent = np.mean((knot_density(number, ROAD) / line)[band])
    assert np.mean((found / line)[band]) == pytest.approx(bent, abs=allowed * bent + 0.001)


def test_long_waves_are_cut_off(heights):
    """Below 0.1 cycle/m, bin by bin, against the exact mean of the estimate."""
    number, found = periodogram(heights, ROAD.knot_spacing)
    few = number < 0.1
    z = (found / expected_periodogram(ROAD, KNOTS) - 1.0)[few] * math.sqrt(STRETCHES)
    assert np.abs(z).max() < 4.5
    assert found[0] < 0.2 * iso_density(number, 256e-6)[0]


def test_chance_is_as_large_as_stated(heights):
    """Over 160 groups of 25 stretches the mean ratio varies as the formula says."""
    number, _ = periodogram(heights[:1], ROAD.knot_spacing)
    exact, band = expected_periodogram(ROAD, KNOTS), number >= 0.1
    ratios = [
        np.mean((periodogram(group, ROAD.knot_spacing)[1] / exact)[band]) for group in heights.reshape(160, 25, KNOTS)
    ]
    assert np.std(ratios) / chance(25, band.sum()) == pytest.approx(1.0, abs=4 / math.sqrt(2 * 160))


def test_the_mean_square_is_that_of_the_formula(heights):
    """Gd(n0) n0^2 pi / (2 n_c); over a stretch of length L it varies by sqrt(2 / (2 pi n_c L)) of itself at most."""
    length = KNOTS * ROAD.knot_spacing
    allowed = 4 * math.sqrt(2 / (STRETCHES * length * 2 * math.pi * ROAD.cutoff))
    assert np.mean(heights**2) == pytest.approx(256e-6 * 0.1**2 * math.pi / (2 * 0.011), rel=allowed)


def test_every_finding_of_the_experiment_agrees():
    outcome = road_spectrum(lambda values, desc: values)
    assert len(outcome.findings) == 11
    assert all(finding.agrees for finding in outcome.findings)
    assert set(outcome.tables) == {"A", "C", "E"}
    for table in outcome.tables.values():
        assert np.abs(table["over_exact"][table["wave_number_cycle_m"] > 0.1] - 1.0).max() < 0.1
