"""Dryden gusts against MIL-F-8785C: scales, the exact law of an interval, variances and spectra."""

import math

import mpmath
import numpy as np
import pytest
from scipy.linalg import expm, solve_continuous_lyapunov
from scipy.signal import welch

from vr_envs.models import turbulence as gusts
from vr_envs.models.autopilot import State
from vr_envs.models.autopilot_options import Track, Turbulence
from vr_envs.models.jit import kernel
from vr_envs.models.record import dtype_of, pack

OPTION, TRACK = pack(Turbulence(wind_20ft=15.4, sigma=3.0)), pack(Track())
FOOT = 0.3048
# x = (p1, p2, integral of p1, integral of p2), time in units of T
DRIFT = np.array([[-1.0, 0, 0, 0], [1, -1, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0]])
NOISE = np.array([1.0, 0, 0, 0])
W = np.array([math.sqrt(3.0), 1.0 - math.sqrt(3.0)])


def transition(q: float) -> tuple[np.ndarray, np.ndarray]:
    """Transition matrix and covariance of the noise of (p1, p2, integral of w / q) over q, as the kernels have it."""
    law = gusts.interval_law(q)
    units = np.eye(5)
    rows = np.array([gusts.cascade(u[0], u[1], q, law, *u[2:]) for u in units])  # (input, output)
    return rows[:2].T, rows[2:].T @ rows[2:]


def exact(q: float) -> tuple[np.ndarray, np.ndarray]:
    """The same, by Van Loan's matrix exponential with 50 digits."""
    with mpmath.workdps(50):
        block = mpmath.zeros(8)
        for i in range(4):
            for j in range(4):
                block[i, j] = -DRIFT[i, j]
                block[4 + i, 4 + j] = DRIFT[j, i]
            block[i, 4 + i] = NOISE[i] ** 2
        power = mpmath.expm(block * mpmath.mpf(q), method="taylor")
        phi = power[4:8, 4:8].T
        covariance = phi * power[0:4, 4:8]
        pick = mpmath.zeros(3, 4)
        pick[0, 0] = pick[1, 1] = 1
        pick[2, 2], pick[2, 3] = mpmath.sqrt(3) / mpmath.mpf(q), (1 - mpmath.sqrt(3)) / mpmath.mpf(q)
        return (
            np.array((pick * phi)[:, 0:2].tolist(), float),
            np.array((pick * covariance * pick.T).tolist(), float),
        )


def test_scales_of_the_standard() -> None:
    """At 500 ft: L_w = 500 ft, L_u = 500 / (0.177 + 0.4115)^1.2, sigma_w = 0.1 W20, sigma_u = that / 0.5885^0.4."""
    along, vertical, sigma_along, sigma_vertical = gusts.scales(500.0 * FOOT, OPTION)
    assert vertical == pytest.approx(500.0 * FOOT, rel=1e-15)
    assert along == pytest.approx(500.0 * FOOT / 0.5885**1.2, rel=1e-14)
    assert sigma_vertical == pytest.approx(1.54, rel=1e-15)
    assert sigma_along == pytest.approx(1.54 / 0.5885**0.4, rel=1e-14)
    assert gusts.scales(3000.0, OPTION) == (1750.0 * FOOT, 1750.0 * FOOT, 3.0, 3.0)
    assert gusts.scales(1500.0 * FOOT, OPTION) == pytest.approx((1375.0 * FOOT, 1375.0 * FOOT, 2.27, 2.27), rel=1e-14)
    assert gusts.scales(-5.0, OPTION) == gusts.scales(10.0 * FOOT, OPTION)


@pytest.mark.parametrize("feet", [1000.0, 2000.0])
def test_scales_are_continuous(feet: float) -> None:
    below, above = gusts.scales((feet - 1e-9) * FOOT, OPTION), gusts.scales((feet + 1e-9) * FOOT, OPTION)
    assert below == pytest.approx(above, rel=1e-11)


@pytest.mark.parametrize("q", [1e-7, 1e-3, 0.1, 0.4999, 0.5001, 1.0, 4.0, 30.0])
def test_law_of_an_interval_is_exact(q: float) -> None:
    phi, covariance = transition(q)
    expected_phi, expected = exact(q)
    np.testing.assert_allclose(phi, expected_phi, rtol=2e-14, atol=1e-16)
    np.testing.assert_allclose(covariance, expected, rtol=1e-13, atol=0)


@pytest.mark.parametrize("q", [1e-6, 0.01, 0.3, 0.499, 0.501, 2.0])
def test_cholesky_factor_is_accurate_where_the_integral_is_nearly_determined(q: float) -> None:
    """det of the covariance of (p1, p2, integral of p2): what the factor's last entry is for."""
    *_, l11, _, l22, _, _, l33 = gusts.interval_law(q)
    kernels = [lambda r: mpmath.exp(-r), lambda r: r * mpmath.exp(-r), lambda r: 1 - (1 + r) * mpmath.exp(-r)]
    with mpmath.workdps(60):
        gram = mpmath.matrix(3)
        for i in range(3):
            for j in range(3):
                gram[i, j] = mpmath.quad(lambda r, i=i, j=j: kernels[i](r) * kernels[j](r), [0, mpmath.mpf(q)])
        scaled = float(mpmath.det(gram) / mpmath.mpf(q) ** 9)
    assert (l11 * l22 * l33) ** 2 == pytest.approx(scaled, rel=1e-11)


@pytest.mark.parametrize("q", [1e-3, 0.2, 0.7, 0.99, 3.0])
def test_two_halves_have_the_law_of_the_whole(q: float) -> None:
    phi, covariance = transition(q)
    half, part = transition(0.5 * q)
    first = np.vstack([half[:2], half[2]])
    both = np.zeros((3, 3))  # from p1, p2 and the mean at half time to those of the whole
    both[:2, :2], both[2, :2], both[2, 2] = half[:2], 0.5 * half[2], 0.5
    scale = np.diag([1.0, 1.0, 0.5])
    np.testing.assert_allclose(both @ first, phi, rtol=0, atol=1e-12)
    np.testing.assert_allclose(both @ part @ both.T + scale @ part @ scale, covariance, rtol=0, atol=1e-12)


def test_stationary_law_is_kept_and_has_variance_one() -> None:
    stationary = solve_continuous_lyapunov(DRIFT[:2, :2], -np.outer(NOISE[:2], NOISE[:2]))
    assert W @ stationary @ W == pytest.approx(1.0, rel=1e-14)
    phi, covariance = transition(0.6)
    np.testing.assert_allclose(phi[:2] @ stationary @ phi[:2].T + covariance[:2, :2], stationary, rtol=0, atol=1e-15)


@pytest.mark.parametrize("q", [0.05, 0.6, 5.0])
def test_variance_of_the_integral_follows_from_the_autocorrelation(q: float) -> None:
    """R(t) = (1 - t / 2) exp(-t), the transform of MIL-F-8785C's spectrum: 2 times the integral of (q - t) R."""
    phi, covariance = transition(q)
    stationary = solve_continuous_lyapunov(DRIFT[:2, :2], -np.outer(NOISE[:2], NOISE[:2]))
    variance = (phi @ stationary @ phi.T + covariance)[2, 2] * q**2
    with mpmath.workdps(30):
        expected = 2 * mpmath.quad(lambda t: (q - t) * (1 - t / 2) * mpmath.exp(-t), [0, mpmath.mpf(q)])
    assert variance == pytest.approx(float(expected), rel=1e-13)


@kernel
def _records(states, count, length, speed, altitude, duration, option, track, vertical, along):  # type: ignore[no-untyped-def]
    """Gusts [m/s] at the ends of intervals and the altitudes gained in them, (count, length)."""
    for i in range(count):
        state = states[i]
        gusts.start_gusts(state, 1 << 40, option, track)
        for k in range(length):
            state.altitude, state.speed = altitude, speed
            vertical[i, k] = math.sqrt(3.0) * state.updraught + (1.0 - math.sqrt(3.0)) * state.updraught_lag
            along[i, k] = state.headwind
            gusts.blow(state, altitude, speed, 0.0, duration, option, track)
            state.steps += 1


def flown(count: int, length: int, duration: float, track: np.void | None = None) -> tuple[np.ndarray, ...]:
    states = np.zeros(count, dtype_of(State))
    states["altitude"], states["speed"], states["key"] = 4000.0, 200.0, np.arange(count) + 5
    vertical, along = np.empty((count, length)), np.empty((count, length))
    _records(states, count, length, 200.0, 4000.0, duration, OPTION, track, vertical, along)
    return states, vertical, along


def test_spectra_are_those_of_the_standard() -> None:
    """Welch's periodograms of 400 flights against the one-sided formulas in f = W V / (2 pi), aliases added.

    400 x 3 windows of 32 s scatter by 3 % at a frequency, by 0.4 % in the mean over the band.
    """
    rate = 50.0
    _, vertical, along = flown(400, 3200, 1.0 / rate)
    time = 1750.0 * FOOT / 200.0
    for samples, second in ((vertical, True), (along, False)):
        f, density = welch(samples, fs=rate, nperseg=1600, detrend=False, window="hann")
        part = (f > 0.4) & (f < 5.0)
        s = (2.0 * math.pi * (f[part] + rate * np.arange(-100, 101)[:, None]) * time) ** 2
        expected = np.sum(2.0 * time * (1.0 + 3.0 * s) / (1.0 + s) ** 2 if second else 4.0 * time / (1.0 + s), axis=0)
        ratio = density.mean(axis=0)[part] / expected
        assert np.mean(ratio) == pytest.approx(1.0, abs=0.016)
        assert np.abs(ratio - 1.0).max() < 0.15


def test_variances_and_correlations_at_a_second() -> None:
    """4000 flights: variance 1 of every component, autocorrelations exp(-t) and (1 - t/2) exp(-t), independence."""
    n = 4000
    states, vertical, along = flown(n, 5, 1.0, TRACK)
    lag = 200.0 / (1750.0 * FOOT)
    band = 4.5 * math.sqrt(2.0 / n)
    for samples, law in ((vertical, (1.0 - 0.5 * lag) * math.exp(-lag)), (along, math.exp(-lag))):
        assert np.var(samples[:, 4]) == pytest.approx(1.0, abs=band)
        assert np.mean(samples[:, 4] * samples[:, 3]) == pytest.approx(law, abs=band)
    crosswind = W[0] * states["crosswind"] + W[1] * states["crosswind_lag"]
    assert np.var(crosswind) == pytest.approx(1.0, abs=band)
    assert abs(np.corrcoef(np.stack([crosswind, states["updraught"], states["headwind"]])) - np.eye(3)).max() < band


def test_what_gusts_do_to_the_aircraft() -> None:
    """One interval: altitude and sideways drift have the integral's variance, airspeed gains the gust's change."""
    n, duration, speed = 4000, 2.0, 200.0
    states, *_ = flown(n, 0, duration, TRACK)
    before = states.copy()
    for i in range(n):
        gusts.blow(states[i], 4000.0, speed, 0.0, duration, OPTION, TRACK)
    q = duration * speed / (1750.0 * FOOT)
    variance = float(2 * mpmath.quad(lambda t: (q - t) * (1 - t / 2) * mpmath.exp(-t), [0, q])) / q**2
    band = 4.5 * math.sqrt(2.0 / n)
    assert np.var(states["altitude"]) / (3.0 * duration) ** 2 / variance == pytest.approx(1.0, abs=band)
    assert np.var(states["x"]) / (3.0 * duration) ** 2 / variance == pytest.approx(1.0, abs=band)
    assert np.abs(states["z"]).max() == 0.0  # it flew along z
    gained = states["speed"] - before["speed"]
    np.testing.assert_allclose(gained, 3.0 * (states["headwind"] - before["headwind"]), rtol=0, atol=1e-12)
    np.testing.assert_allclose(states["gust_along"], 3.0 * states["headwind"], rtol=1e-15)


def test_the_track_does_not_change_the_other_gusts() -> None:
    with_track, without = flown(3, 4, 1.0, TRACK)[0], flown(3, 4, 1.0)[0]
    for name in ("altitude", "speed", "updraught", "headwind"):
        np.testing.assert_array_equal(with_track[name], without[name])
    assert not without["crosswind"].any()


def test_gusts_are_frozen_where_nothing_flies_through_them() -> None:
    states = flown(1, 0, 1.0)[0]
    states["speed"] = states["gust_along"] = 0.0
    before = states.copy()
    gusts.blow(states[0], 4000.0, 0.0, 0.0, 2.0, OPTION, None)
    for name in ("updraught", "updraught_lag", "headwind"):
        assert states[name][0] == before[name][0]
    w = W @ [before["updraught"][0], before["updraught_lag"][0]]
    assert states["altitude"][0] - before["altitude"][0] == pytest.approx(3.0 * 2.0 * w, rel=1e-12)
    assert states["speed"][0] >= 0.0


def test_drift_is_at_right_angles_to_the_mean_heading() -> None:
    """From 170 to -170 degrees the heading in between is 180: the crosswind moves the aircraft along x only."""
    states = flown(1, 0, 1.0, TRACK)[0]
    states["x"], states["heading"] = 0.0, math.radians(-170.0)
    gusts.blow(states[0], 4000.0, 200.0, math.radians(170.0), 1.0, OPTION, TRACK)
    assert abs(states["x"][0]) > 1e-3
    assert abs(states["z"][0]) < 1e-12 * abs(states["x"][0]) + 1e-14


def test_transition_is_the_matrix_exponential() -> None:
    phi, _ = transition(0.8)
    np.testing.assert_allclose(phi[:2], expm(0.8 * DRIFT[:2, :2]), rtol=1e-14)
