"""The aircraft against DOP853 over whole episodes, its closed forms, its limits and its gusts."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import spherical_jn

from vr_envs.models import autopilot as model
from vr_envs.models.ground_track import spherical_bessel
from vr_envs.models.record import dtype_of, pack

PARAMS = model.Params()
LAGS, ENVELOPE, ENERGY, TRACK = model.Lags(), model.Envelope(), model.Energy(), model.Track()
G = 9.80665
STATE = ("vertical_speed", "acceleration", "turn_rate", "altitude", "speed", "heading", "x", "z")


def flight(**values: float) -> np.ndarray:
    """One record, as the single row of an array."""
    states = np.zeros(1, dtype_of(model.State))
    for name, value in {"altitude": 4000.0, "speed": 150.0, **values}.items():
        states[name] = value
    return states


def packed(*options: object) -> tuple[np.void | None, ...]:
    return tuple(None if option is None else pack(option) for option in options)


def commanded(y: np.ndarray, action: np.ndarray, full: bool) -> tuple[float, float, float, float]:
    """Commanded rates and the limit of the turn rate's slope, written out anew from the scene's description."""
    altitude, speed = y[3], y[4]
    climb, turn = 13.0, math.radians(3.0)
    if full:
        climb = 13.0 - 7.0 * altitude / 11000.0
        turn = min(turn, G * math.tan(math.radians(25.0)) / speed)
    rise = action[0] * (climb if action[0] > 0 else 10.0)
    gain = action[1] * 0.6
    if full:
        gain = min(max(gain, G * (-8.0 - rise) / speed), G * (climb - rise) / speed)
    return rise, gain, action[2] * turn, turn / 4.0


def reference(y: np.ndarray, commands: tuple[float, float, float, float], duration: float, lags: bool) -> np.ndarray:
    """DOP853 over an interval with held commands, restarted where a rate limit ceases to act."""
    goal, tau, slew = commands[:3], (2.5, 3.5, 1.8), (1.5, 0.15, commands[3])

    def slopes(_: float, y: np.ndarray) -> list[float]:
        if lags:
            rates = y[:3]
            bends = [min(slew[i], max(-slew[i], (goal[i] - y[i]) / tau[i])) for i in range(3)]
        else:
            rates, bends = goal, [0.0, 0.0, 0.0]
        return [*bends, *rates, y[4] * math.sin(y[5]), y[4] * math.cos(y[5])]

    # a limited rate moves uniformly, so it meets the corner of its clamp after this time
    corners = [(abs(goal[i] - y[i]) - slew[i] * tau[i]) / slew[i] for i in range(3)] if lags else []
    ends = sorted(t for t in corners if 0.0 < t < duration) + [duration]
    for begin, end in zip([0.0, *ends], ends, strict=False):
        y = solve_ivp(slopes, (begin, end), y, "DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    return y


@pytest.mark.parametrize("full", [False, True], ids=["lecture", "airliner-in-still-air"])
def test_whole_episode_agrees_with_dop853(full: bool) -> None:
    rng = np.random.default_rng(1)
    states = flight(heading=1.0)
    options = packed(*((ENVELOPE, ENERGY, LAGS) if full else (None, None, None)), None, TRACK)
    params = pack(PARAMS)
    y = np.array([states[name][0] for name in STATE])
    for step in range(480):
        if step % 12 == 0:  # held long enough to saturate, far enough to be limited
            action = np.clip(rng.normal(0.0, 0.8, 3), -1.0, 1.0)
            action[1] = math.copysign(action[1], 160.0 - y[4])
        commands = commanded(y, action, full)
        y = reference(y, commands, 1.0, full)
        model.advance(states[0], action, params, *options)
        if not full:
            y[:3] = commands[:3]
    got = np.array([states[name][0] for name in STATE])
    y[5] = (y[5] + math.pi) % (2.0 * math.pi) - math.pi
    assert np.abs(y[6:]).max() > 1e4
    np.testing.assert_allclose(got[3:], y[3:], rtol=1e-12, atol=0)
    np.testing.assert_allclose(got[:3], y[:3], rtol=0, atol=1e-12)


@pytest.mark.parametrize("track", [None, TRACK])
@pytest.mark.parametrize("lags", [None, LAGS])
def test_a_held_command_may_be_split_anywhere(lags: object, track: object) -> None:
    options = packed(lags, track)
    for split in (0.1, 0.5, 1.3, 2.9):
        whole = flight(vertical_speed=-6.0, acceleration=0.3, turn_rate=0.03)
        parts = whole.copy()
        model.fly(whole[0], 12.0, -0.5, -0.05, 0.01, 3.0, *options)
        model.fly(parts[0], 12.0, -0.5, -0.05, 0.01, split, *options)
        model.fly(parts[0], 12.0, -0.5, -0.05, 0.01, 3.0 - split, *options)
        for name in STATE:
            assert parts[name][0] == pytest.approx(whole[name][0], rel=1e-13, abs=1e-12)


def test_constant_turn_is_the_circle() -> None:
    """x = x0 + (v / w)(cos psi0 - cos(psi0 + w t)), z = z0 + (v / w)(sin(psi0 + w t) - sin psi0)."""
    v, w, psi, t = 150.0, 0.05, 0.7, 10.0
    states = flight(speed=v, heading=psi)
    model.fly(states[0], 0.0, 0.0, w, 0.0, t, *packed(None, TRACK))
    assert states["x"][0] == pytest.approx(v / w * (math.cos(psi) - math.cos(psi + w * t)), rel=1e-13)
    assert states["z"][0] == pytest.approx(v / w * (math.sin(psi + w * t) - math.sin(psi)), rel=1e-13)


def test_straight_flight_is_the_limit_of_the_turn() -> None:
    """The lecture's forward step v t + a t^2 / 2, along the heading."""
    for w in (0.0, 1e-12):
        states = flight(speed=150.0, heading=0.4)
        model.fly(states[0], 0.0, 0.5, w, 0.0, 8.0, *packed(None, TRACK))
        assert math.hypot(states["x"][0], states["z"][0]) == pytest.approx(150.0 * 8.0 + 0.25 * 64.0, rel=1e-14)
        assert math.atan2(states["x"][0], states["z"][0]) == pytest.approx(0.4, abs=1e-11)


@pytest.mark.parametrize("q", [-3.0, -0.2, 0.0, 1e-9, 0.1, 0.4999999, 0.5000001, 2.0])
def test_spherical_bessel_functions(q: float) -> None:
    sign = math.copysign(1.0, q)
    expected = spherical_jn(0, abs(q)), sign * spherical_jn(1, abs(q))
    assert spherical_bessel(q) == pytest.approx(expected, rel=1e-14, abs=1e-300)


def test_ground_track_does_not_contain_the_gust() -> None:
    states = flight(speed=150.0, gust_along=2.0)
    model.fly(states[0], 0.0, 0.0, 0.0, 0.0, 10.0, *packed(None, TRACK))
    assert states["z"][0] == pytest.approx(1480.0, rel=1e-14)


@pytest.mark.parametrize(
    ("angle", "expected"), [(0.0, 0.0), (3.2, 3.2 - 2 * math.pi), (-3.2, 2 * math.pi - 3.2), (math.pi, -math.pi)]
)
def test_headings_wrap(angle: float, expected: float) -> None:
    assert model.wrap(angle) == pytest.approx(expected, abs=1e-15)
    assert model.wrap(angle + 20.0 * math.pi) == pytest.approx(expected, abs=1e-13)


def test_limits_follow_altitude_speed_and_bank() -> None:
    params, envelope = packed(PARAMS, ENVELOPE)
    assert model.climb_limit(0.0, params, envelope) == 13.0
    assert model.climb_limit(11000.0, params, envelope) == pytest.approx(6.0, rel=1e-15)
    assert model.climb_limit(25000.0, params, envelope) == 0.0
    assert model.climb_limit(11000.0, params, None) == 13.0
    crossover = G * math.tan(math.radians(25.0)) / math.radians(3.0)  # 87.3 m/s
    assert crossover == pytest.approx(87.3, abs=0.05)
    assert model.turn_limit(crossover - 1.0, params, envelope) == math.radians(3.0)
    assert model.turn_limit(200.0, params, envelope) == pytest.approx(math.radians(3.0) * crossover / 200.0, rel=1e-14)


@pytest.mark.parametrize("action", [(1, 1), (1, -1), (-1, 1), (-1, -1), (0.3, 1.0), (-0.9, -0.1)])
def test_steady_climb_and_acceleration_share_one_power(action: tuple[float, float]) -> None:
    """Without lags the rates are the commands: g v_y + v a stays in [-8 g, g V_cli], and v_y is as commanded."""
    params, envelope, energy = packed(PARAMS, ENVELOPE, ENERGY)
    states = flight(altitude=5500.0, speed=200.0)
    model.advance(states[0], np.array([*action, 0.0]), params, envelope, energy, None, None, None)
    rise, gain = states["vertical_speed"][0], states["acceleration"][0]
    assert rise == pytest.approx(action[0] * (9.5 if action[0] > 0 else 10.0), rel=1e-15)
    power = G * rise + 200.0 * gain
    assert -8.0 * G - 1e-9 <= power <= 9.5 * G + 1e-9
    if abs(gain - 0.6 * action[1]) > 1e-12:
        assert power == pytest.approx(9.5 * G if gain < 0.6 * action[1] else -8.0 * G, rel=1e-12)


def test_gusts_carry_the_aircraft_as_their_law_says() -> None:
    """Over 100 s of level flight the altitude wanders with the integral's variance, the airspeed with the gust's."""
    n, steps, speed = 1500, 100, 200.0
    params, gust = packed(PARAMS, model.Gust())
    states = np.zeros(n, dtype_of(model.State))
    states["altitude"], states["speed"], states["key"] = 5000.0, speed, np.arange(n) + 77
    for _ in range(steps):
        for i in range(n):
            model.blow(states[i], 533.4 / speed, params["dt"], 2 * states["steps"][i], gust)
        states["steps"] += 1
    time = 533.4 / speed
    k = steps / time  # started from no gust: variance of the integral of a process that starts at zero
    variance = 0.7**2 * time**2 * (2.0 * k - (1.0 - math.exp(-k)) * (3.0 - math.exp(-k)))
    band = 4.0 * math.sqrt(2.0 / n)
    assert np.var(states["altitude"]) / variance == pytest.approx(1.0, abs=band)
    assert np.var(states["gust_vertical"]) / 0.7**2 == pytest.approx(1.0, abs=band)
    np.testing.assert_allclose(states["speed"] - states["gust_along"], speed, rtol=1e-12)
    assert np.var(states["gust_along"]) / 0.25**2 == pytest.approx(1.0, abs=band)
    assert abs(np.corrcoef(states["gust_along"], states["gust_vertical"])[0, 1]) < 4.0 / math.sqrt(n)


@pytest.mark.parametrize(
    ("values", "lost"),
    [
        ({}, False),
        ({"altitude": 0.0}, True),
        ({"altitude": 13001.0}, True),
        ({"speed": 59.0}, True),
        ({"speed": 301.0}, True),
    ],
)
def test_envelope(values: dict[str, float], lost: bool) -> None:
    assert model.left_envelope(flight(**values)[0], pack(PARAMS)) == lost
