import math

import numpy as np
import pytest
from scipy.integrate import quad

from vr_envs.models.road_density import iso_density, knot_density, met_density, road_density
from vr_envs.models.road_options import Road

SPACINGS = (0.05, 0.2, 1.0)


def test_the_line_of_the_standard():
    """Class A at n0, and the root mean square of its band, 3.8 mm."""
    assert iso_density(np.array([0.1, 0.2]), 16e-6) == pytest.approx([16e-6, 4e-6], rel=1e-15)
    square = quad(lambda n: float(iso_density(np.array(n), 16e-6)), 0.011, 2.83, epsrel=1e-12)[0]
    assert square == pytest.approx(16e-6 * 0.1**2 * (1 / 0.011 - 1 / 2.83), rel=1e-10)
    assert 1e3 * math.sqrt(square) == pytest.approx(3.806, abs=5e-4)


@pytest.mark.parametrize("spacing", SPACINGS)
def test_densities_have_the_mean_square_of_the_road(spacing):
    """One-sided: the integral over n > 0 is the variance. Straight pieces have the mean of (2 + phi) / 3 of it."""
    road = Road(knot_spacing=spacing)
    variance = 0.1**2 * math.pi * 256e-6 / (2 * 0.011)
    points = [0.01, 0.1, 0.4 / spacing]

    def integral(density, top):
        return quad(lambda n: float(density(np.array(n), road)), 0.0, top, epsrel=1e-11, limit=4000, points=points)[0]

    assert integral(knot_density, 0.5 / spacing) == pytest.approx(variance, rel=1e-10)
    rest = 256e-6 * 0.1**2 / 0.011 * (0.5 * math.pi - math.atan(10.0 / 0.011))
    assert integral(road_density, 10.0) + rest == pytest.approx(variance, rel=1e-9)
    polygon = variance * (2.0 + road.memory) / 3.0
    assert integral(met_density, 200 / spacing) == pytest.approx(polygon, rel=1e-7)


@pytest.mark.parametrize("spacing", SPACINGS)
def test_the_density_of_the_knots_is_that_of_samples(spacing):
    """The sum over all that folds onto n, |n + m / spacing|; its tail by an integral."""
    road = Road(knot_spacing=spacing)
    number = np.array([1e-3, 0.01, 0.05, 0.2, 0.5]) / spacing
    last = 20000
    fold = np.arange(-last, last + 1)[:, None] / spacing
    tail = 2 * 256e-6 * 0.1**2 * spacing**2 / (last + 0.5)
    assert knot_density(number, road) == pytest.approx(road_density(number + fold, road).sum(axis=0) + tail, rel=1e-9)


@pytest.mark.parametrize("spacing", SPACINGS)
def test_the_density_of_the_knots_is_the_transform_of_their_covariance(spacing):
    """2 h (c_0 + 2 sum of c_k cos(2 pi n h k)), Wiener and Khinchin."""
    road = Road(knot_spacing=spacing)
    variance, lag = 0.1**2 * math.pi * 256e-6 / (2 * 0.011), np.arange(1, 200_000)
    for number in np.array([0.003, 0.02, 0.2, 0.5]) / spacing:
        series = 1.0 + 2.0 * np.sum(
            math.exp(-2 * math.pi * 0.011 * spacing) ** lag * np.cos(2 * math.pi * number * spacing * lag)
        )
        assert knot_density(np.array(number), road) == pytest.approx(2 * spacing * variance * series, rel=1e-8)


def test_where_the_road_meets_the_line_of_the_standard():
    """Within 1 % from 12 n_c to 0.045 / h; beyond, by the factors that the module names."""
    for spacing in (0.05, 0.1, 0.2):
        road = Road(knot_spacing=spacing)
        number = np.geomspace(0.132, 0.045 / spacing, 50)
        for density in (road_density, knot_density, met_density):
            assert density(number, road) == pytest.approx(iso_density(number, road.density), rel=0.01)
        number = np.geomspace(1e-4, 0.5 / spacing, 50)
        assert road_density(number, road) * (1 + (0.011 / number) ** 2) == pytest.approx(
            iso_density(number, road.density), rel=1e-14
        )
        sinc = np.sinc(number * spacing)
        assert knot_density(number, road) * sinc**2 == pytest.approx(road_density(number, road), rel=2e-5)
        assert met_density(number, road) / sinc**2 == pytest.approx(road_density(number, road), rel=2e-5)


def test_the_class_means_are_not_the_popular_recipe():
    """Amplitudes sqrt(dn) 2^k 1e-3 n0/n have the density of the limit between two classes, twice the mean."""
    number, step = 0.3, 0.01
    for k, letter in zip(range(3, 10), "ABCDEFG", strict=True):
        density = (math.sqrt(step) * 2.0**k * 1e-3 * 0.1 / number) ** 2 / (2 * step)
        mean = float(iso_density(np.array(number), Road(iso_class=letter).density))
        assert density / mean == pytest.approx(2.0, rel=1e-12)
