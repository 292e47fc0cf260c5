"""Quadrature on lanes: exact for polynomials to degree 15, below rounding over one decay or radian."""

import math

import mpmath
import numpy as np
import pytest

from vr_envs.models.elementary import cos_sin, exp
from vr_envs.models.jit import kernel
from vr_envs.models.lane_records import lane
from vr_envs.models.quadrature import integral, points, running_integral


@kernel
def of_power(degree, begin, length):
    time = points(begin, length)
    values = 0.0 * time + 1.0
    for _ in range(degree):
        values *= time
    return integral(values, length)


@kernel
def of_decaying_wave(length, upto):
    time = points(0.0, length)
    cosine, _ = cos_sin(time)
    running = running_integral(exp(-time) * cosine, length)
    for k in range(8):
        upto[0, k], upto[1, k] = lane(time, k), lane(running, k)
    return integral(exp(-time) * cosine, length)


def decaying_wave(t):
    """The integral of exp(-t) cos(t), rounded once."""
    with mpmath.workdps(40):
        t = mpmath.mpf(float(t))
        return float((1 + mpmath.exp(-t) * (mpmath.sin(t) - mpmath.cos(t))) / 2)


@pytest.mark.parametrize("degree", range(16))
def test_polynomials(degree):
    exact = (1.7 ** (degree + 1) - 0.2 ** (degree + 1)) / (degree + 1)
    assert of_power(degree, 0.2, 1.5) == pytest.approx(exact, rel=4e-15)


def test_degree_16_is_the_first_that_is_not_exact():
    error = of_power(16, 0.0, 1.0) - 1.0 / 17.0
    expected = -(math.factorial(8) ** 4) / (17.0 * math.factorial(16) ** 2)
    assert error == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("length", [0.1, 1.0])
def test_decaying_wave(length):
    upto = np.zeros((2, 8))
    assert of_decaying_wave(length, upto) == pytest.approx(decaying_wave(length), rel=4e-16)
    # up to a point within, the polynomial through eight points has an error of the ninth derivative's size
    errors = [abs(found - decaying_wave(time)) for time, found in upto.T]
    assert max(errors) < 3e-10 * length**9 + 1e-15 * length  # and eight roundings
