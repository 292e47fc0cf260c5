import math

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vr_envs.models.spring import damped_cosine_sine, damping_of_restitution, free_motion


def reference(x, v, gamma, w2, t):
    """The same motion by 60-digit arithmetic, from the matrix exponential of the first-order system."""
    with mpmath.workdps(60):
        matrix = mpmath.matrix([[0, 1], [-mpmath.mpf(w2), -mpmath.mpf(gamma)]])
        moved = mpmath.expm(matrix * mpmath.mpf(t)) * mpmath.matrix([x, v])
        return float(moved[0]), float(moved[1])


# gamma [1/s], w2 [1/s^2]: undamped, under-, nearly, exactly, barely over- and strongly over-damped, no spring, nothing
REGIMES = [(0, 58), (3, 58), (15.999999, 64), (16, 64), (16.000001, 64), (40, 58), (900, 2), (3, 0), (0, 0), (1, 900)]


@pytest.mark.parametrize("gamma, w2", REGIMES)
@pytest.mark.parametrize("t", [0.0, 1e-9, 0.01, 0.033, 0.3, 2.0])
def test_every_regime_to_rounding(gamma, w2, t):
    got = free_motion(0.03, -0.4, float(gamma), float(w2), t)
    size = math.hypot(0.03 * math.sqrt(w2), 0.4)  # the largest speed there can be
    scale = (max(0.03, size / max(math.sqrt(w2), 1.0 / max(t, 1e-3))), size)
    expected = reference(0.03, -0.4, gamma, w2, t)
    assert got == pytest.approx(expected, abs=0, rel=1e-12) or all(
        abs(g - e) < 2e-15 * s for g, e, s in zip(got, expected, scale, strict=True)
    )


@pytest.mark.parametrize("q", [0.0624999, 0.0625001, -0.0624999, -0.0625001])
def test_series_and_closed_form_meet(q):
    gamma, t = 6.0, 0.1
    got = damped_cosine_sine(gamma, q / t**2 + gamma**2 / 4, t)
    with mpmath.workdps(40):
        z, decay = mpmath.sqrt(mpmath.mpc(q)), mpmath.exp(-gamma * t / 2)
        expected = (float((decay * mpmath.cos(z)).real), float((decay * mpmath.sin(z) / z).real))
    assert got == pytest.approx(expected, rel=4e-16)


def test_strong_damping_does_not_overflow():
    x, v = free_motion(0.1, 0.0, 1e4, 1.0, 100.0)
    assert x == pytest.approx(0.1 * math.exp(-100.0 / 1e4), rel=1e-7)
    assert v == pytest.approx(-x * 1e-4, rel=1e-7)


def test_two_half_steps_are_one_step():
    rng = np.random.default_rng(1)
    for gamma, w2, x, v in zip(*rng.uniform([[0], [0], [-1], [-1]], [[40], [200], [1], [1]], (4, 200)), strict=True):
        whole = free_motion(x, v, gamma, w2, 0.02)
        halves = free_motion(*free_motion(x, v, gamma, w2, 0.01), gamma, w2, 0.01)
        assert halves == pytest.approx(whole, abs=1e-14)


def test_undamped_energy_is_kept():
    x, v, w2 = 0.05, 0.3, 58.0
    energy = v * v + w2 * x * x
    for _ in range(1000):
        x, v = free_motion(x, v, 0.0, w2, 0.037)
    assert v * v + w2 * x * x == pytest.approx(energy, rel=1e-13)


def test_restitution_factor_is_exact_over_its_interval():
    """With no spring the velocity falls by k_d in one interval, whatever number of steps it is cut into."""
    gamma = damping_of_restitution(0.99, 1 / 60)
    assert gamma == pytest.approx(0.603, abs=5e-4)
    v = 1.0
    for _ in range(7):
        _, v = free_motion(0.0, v, gamma, 0.0, 1 / 420)
    assert v == pytest.approx(0.99, rel=1e-15)


def test_agrees_with_a_general_integrator():
    solution = solve_ivp(
        lambda t, y: (y[1], -58.0 * y[0] - 3.0 * y[1]), (0, 1), (0.03, -0.4), "DOP853", rtol=1e-13, atol=1e-16
    )
    assert free_motion(0.03, -0.4, 3.0, 58.0, 1.0) == pytest.approx(solution.y[:, -1], rel=1e-11)
