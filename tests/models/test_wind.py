"""Gusts against their exact law: stationary variance, autocorrelation, and the joint law of end value and integral."""

import math

import mpmath
import numpy as np
import pytest

from vr_envs.models.wind import excess_over_tanh, gust_after, gust_integral

SIGMA, TIME = 0.7, 2.5


@pytest.mark.parametrize("q", [1e-5, 1e-3, 0.1, 0.3, 0.4999, 0.5001, 1.0, 20.0])
def test_difference_of_q_and_its_tanh_is_exact(q: float) -> None:
    with mpmath.workdps(40):
        exact = float(mpmath.mpf(q) - mpmath.tanh(mpmath.mpf(q)))
    assert excess_over_tanh(q, math.tanh(q)) == pytest.approx(exact, rel=4e-15)


@pytest.mark.parametrize("interval", [0.05, 1.0, 10.0])
def test_moments_are_those_of_the_ornstein_uhlenbeck_process(interval: float) -> None:
    """End value and integral are affine in the deviates, so their covariance follows from unit inputs, exactly."""
    decay = math.exp(-interval / TIME)

    def step(gust: float, first: float, second: float) -> tuple[float, float]:
        after = gust_after(gust, decay, SIGMA, first)
        return after, gust_integral(gust, after, interval, TIME, decay, SIGMA, second)

    end_1, integral_1 = step(0.0, 1.0, 0.0)
    end_2, integral_2 = step(0.0, 0.0, 1.0)
    k = mpmath.mpf(interval) / mpmath.mpf(TIME)
    a = mpmath.exp(-k)
    assert end_2 == 0.0
    assert end_1**2 == pytest.approx(float(SIGMA**2 * (1 - a * a)), rel=1e-12)
    assert end_1 * integral_1 == pytest.approx(float(SIGMA**2 * TIME * (1 - a) ** 2), rel=1e-11)
    variance = float(SIGMA**2 * TIME**2 * (2 * k - (1 - a) * (3 - a)))
    assert integral_1**2 + integral_2**2 == pytest.approx(variance, rel=1e-9)
    end, integral = step(1.0, 0.0, 0.0)
    assert (end, integral) == pytest.approx((float(a), float(TIME * (1 - a))), rel=1e-12)


def test_sequence_has_the_variance_and_the_exponential_autocorrelation() -> None:
    interval, n = 1.0, 200_000
    decay = math.exp(-interval / TIME)
    deviates = np.random.default_rng(0).standard_normal(n)
    gusts = np.empty(n)
    gust = SIGMA * 0.3
    for i in range(n):
        gust = gusts[i] = gust_after(gust, decay, SIGMA, deviates[i])
    effective = n * (1.0 - decay**2) / (1.0 + decay**2)
    band = 4.0 * math.sqrt(2.0 / effective)
    assert np.mean(gusts**2) / SIGMA**2 == pytest.approx(1.0, abs=band)
    for lag in (1, 3, 6):
        assert np.mean(gusts[lag:] * gusts[:-lag]) / SIGMA**2 == pytest.approx(decay**lag, abs=band)
