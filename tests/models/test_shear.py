"""Wind and shear: what they do to airspeed and ground track, from momentum and by quadrature."""

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from vr_envs.models import autopilot as model
from vr_envs.models.autopilot_options import Lags, Shear, Track, Wind
from vr_envs.models.record import dtype_of, pack
from vr_envs.models.shear import shear_bounds, shear_gain, shear_rate

TRACK = pack(Track())


def flight(**values: float) -> np.ndarray:
    states = np.zeros(1, dtype_of(model.State))
    for name, value in {"altitude": 4000.0, "speed": 150.0, "sheared": True, **values}.items():
        states[name] = value
    return states


def test_a_steady_wind_moves_the_aircraft_over_the_ground_only() -> None:
    """From the east (x) at 20 m/s: 200 m to the west in 10 s."""
    calm, windy = flight(heading=0.4), flight(heading=0.4)
    model.fly(calm[0], 5.0, 0.3, 0.02, 0.0, 10.0, None, None, None, TRACK)
    model.fly(windy[0], 5.0, 0.3, 0.02, 0.0, 10.0, None, pack(Wind(speed=20.0, origin=0.5 * math.pi)), None, TRACK)
    assert windy["x"][0] - calm["x"][0] == pytest.approx(-200.0, rel=1e-12)
    assert windy["z"][0] == pytest.approx(calm["z"][0], rel=1e-12)
    for name in ("speed", "altitude", "heading", "acceleration"):
        assert windy[name][0] == calm[name][0]


@pytest.mark.parametrize(("heading", "sign"), [(0.7, 1.0), (0.7 - math.pi, -1.0), (0.7 + 0.5 * math.pi, 0.0)])
@pytest.mark.parametrize("lags", [None, pack(Lags())])
def test_without_thrust_the_speed_over_the_ground_is_kept(heading: float, sign: float, lags: np.void | None) -> None:
    """Climbing straight into the wind, down the wind or across it, airspeed changes by the wind's growth."""
    states = flight(heading=heading)
    model.fly(states[0], 10.0, 0.0, 0.0, 0.02, 30.0, lags, None, pack(Shear(gradient=0.01, origin=0.7)), None)
    growth = 0.01 * (states["altitude"][0] - 4000.0)
    assert growth > 2.0
    assert states["speed"][0] == pytest.approx(150.0 + sign * growth, rel=1e-14)


def test_velocity_over_the_ground_is_airspeed_plus_wind() -> None:
    """Newton's law on the velocity over the ground, with the lift across the path that the turn needs, as an ODE."""
    gradient, origin, rise, turn, duration = 0.02, -1.1, 8.0, 0.04, 40.0
    blow = -gradient * np.array([math.sin(origin), math.cos(origin)])  # wind per metre of altitude, (x, z)

    def slopes(time: float, y: np.ndarray) -> np.ndarray:
        heading = 0.2 + turn * time
        ahead = np.array([math.sin(heading), math.cos(heading)])
        beside = np.array([math.cos(heading), -math.sin(heading)])
        over = y[:2]
        air = over - blow * (4000.0 + rise * time)
        # no force along the path; the one across it turns the air's velocity at the rate commanded
        across = (air @ ahead) * turn + blow @ beside * rise
        return np.array([*(across * beside), *over])

    start = 150.0 * np.array([math.sin(0.2), math.cos(0.2)]) + blow * 4000.0
    end = solve_ivp(slopes, (0.0, duration), [*start, 0.0, 0.0], "DOP853", rtol=1e-12, atol=1e-10).y[:, -1]
    states = flight(heading=0.2)
    model.fly(
        states[0], rise, 0.0, turn, 0.0, duration, None, None, pack(Shear(gradient=gradient, origin=origin)), TRACK
    )  # fmt: skip
    air = end[:2] - blow * (4000.0 + rise * duration)
    assert states["speed"][0] == pytest.approx(np.hypot(*air), rel=1e-10)
    assert math.atan2(*air) == pytest.approx(states["heading"][0], abs=1e-10)
    assert [states["x"][0], states["z"][0]] == pytest.approx(end[2:], rel=1e-9)


@pytest.mark.parametrize(
    "lags",
    [
        None,
        Lags(),
        Lags(vertical=0.05, along=60.0, turn=0.3, vertical_slew=50.0, roll_in=0.01),
        Lags(vertical=60.0, along=0.05, turn=60.0, vertical_slew=0.01, jerk=0.001, roll_in=60.0),
    ],
)
@pytest.mark.parametrize("turn", [0.0, 1e-9, 0.05, -1.0])
def test_gain_is_the_integral_of_the_rate_within_its_bounds(lags: Lags | None, turn: float) -> None:
    state = flight(vertical_speed=-6.0, turn_rate=-0.4 * turn, heading=2.0)[0]
    lag, shear = None if lags is None else pack(lags), pack(Shear(gradient=0.1, origin=-0.4))
    slew = 0.01 + abs(turn)
    steepest, curvature = shear_bounds(state, 11.0, turn, lag, shear)
    rates = np.array([shear_rate(state, 11.0, turn, slew, t, lag, shear) for t in np.arange(0.0, 8.0, 1e-2)])
    assert np.abs(rates).max() <= steepest * (1.0 + 1e-12)
    assert np.abs(np.diff(rates)).max() <= curvature * 1e-2 * (1.0 + 1e-9) + 1e-15
    expected = sum(
        quad(lambda t: shear_rate(state, 11.0, turn, slew, t, lag, shear), k * 0.1, k * 0.1 + 0.1, epsrel=1e-12)[0]
        for k in range(5, 80)
    )
    assert shear_gain(state, 11.0, turn, slew, 0.5, 8.0, lag, shear) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("shear", [None, Shear(gradient=0.2, origin=1.0)])
def test_panels_are_short_enough_for_any_lags(shear: Shear | None) -> None:
    """Sixteen parts of an interval against the whole, over the ranges that the options allow."""
    rng = np.random.default_rng(4)
    blowing = None if shear is None else pack(shear)

    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    for _ in range(1000):
        lags = pack(
            Lags(
                vertical=between(0.05, 60.0), along=between(0.05, 60.0), turn=between(0.05, 60.0),
                vertical_slew=between(0.01, 50.0), jerk=between(0.001, 50.0), roll_in=between(0.01, 60.0),
            )
        )  # fmt: skip
        turn, duration = between(1e-3, 1.0), between(1e-3, 10.0)
        rates = {"vertical_speed": rng.uniform(-10.0, 13.0), "turn_rate": turn * rng.uniform(-1.0, 1.0)}
        whole = flight(heading=rng.uniform(-3.0, 3.0), acceleration=rng.uniform(-0.6, 0.6), **rates)
        parts = whole.copy()
        commands = rng.uniform(-10.0, 13.0), rng.uniform(-0.6, 0.6), turn * rng.uniform(-1.0, 1.0), turn / 4.0
        model.fly(whole[0], *commands, duration, lags, None, blowing, TRACK)
        for _ in range(16):
            model.fly(parts[0], *commands, duration / 16.0, lags, None, blowing, TRACK)
        scale = max(1.0, abs(whole["speed"][0]) * duration)
        for name in ("x", "z", "speed"):
            assert abs(whole[name][0] - parts[name][0]) < 2e-13 * scale
