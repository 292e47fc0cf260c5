"""Counter-based random numbers: their distribution, their independence, and the trigonometry behind the normals."""

import math

import mpmath
import numpy as np
import pytest

from vr_envs.models.noise import bits, cos_sin_turns, normal_pair, uniform

KEY = np.uint64(0x0123456789ABCDEF)


def test_bits_are_the_splitmix64_sequence() -> None:
    """The first outputs of SplitMix64 seeded with 1234567 (reference implementation of Vigna)."""
    expected = [6457827717110365317, 3203168211198807973, 9817491932198370423, 4593380528125082431]
    assert [int(bits(np.uint64(1234567), k)) for k in range(4)] == expected


@pytest.mark.parametrize("turns", [0.0, 1e-17, 0.1, 0.125, 0.25, 0.3, 0.375, 0.5, 0.6, 0.75, 0.875, 0.999, 1.0])
def test_cosine_and_sine_of_turns_are_exact_to_rounding(turns: float) -> None:
    with mpmath.workdps(30):
        angle = 2 * mpmath.pi * mpmath.mpf(turns)
        exact = float(mpmath.cos(angle)), float(mpmath.sin(angle))
    assert cos_sin_turns(turns) == pytest.approx(exact, rel=0, abs=2.5e-16)


def test_uniform_numbers_lie_in_the_open_interval_and_pass_kolmogorov_smirnov() -> None:
    draws = np.sort([uniform(KEY, k) for k in range(20000)])
    assert draws[0] > 0.0 and draws[-1] < 1.0
    steps = np.arange(len(draws) + 1) / len(draws)
    distance = max(np.max(steps[1:] - draws), np.max(draws - steps[:-1]))
    assert distance < 1.95 / math.sqrt(len(draws))  # one in a thousand exceeds it


def test_normal_numbers_have_the_normal_distribution_and_no_correlation() -> None:
    n = 20000
    draws = np.array([normal_pair(KEY, k) for k in range(n)])
    cdf = np.sort(0.5 * (1.0 + np.vectorize(math.erf)(draws.ravel() / math.sqrt(2.0))))
    steps = np.arange(2 * n + 1) / (2 * n)
    assert max(np.max(steps[1:] - cdf), np.max(cdf - steps[:-1])) < 1.95 / math.sqrt(2 * n)
    within = np.mean(draws[:, 0] * draws[:, 1])
    along = np.mean(draws[1:] * draws[:-1], axis=0)
    assert np.all(np.abs([within, *along]) < 4.0 / math.sqrt(n))
    assert abs(np.mean(draws[:, 0] ** 2 * draws[:, 1] ** 2) - 1.0) < 4.0 * math.sqrt(8.0 / n)
