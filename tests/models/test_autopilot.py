"""The aircraft against DOP853 over whole episodes, however time is split; its limits, at low speed too."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import spherical_jn

from tests.models.autopilot_reference import GRADIENT, NAMES, SHEAR_ORIGIN, WIND, WIND_ORIGIN, Flight
from vr_envs.models import autopilot as model
from vr_envs.models import autopilot_options as options
from vr_envs.models.autopilot_limits import climb_limit, turn_limit
from vr_envs.models.ground_track import spherical_bessel
from vr_envs.models.record import dtype_of, pack

G = 9.80665
PARAMS, ENVELOPE, ENERGY = pack(model.Params()), pack(options.Envelope()), pack(options.Energy())
RECORDS = {
    "envelope": ENVELOPE,
    "energy": ENERGY,
    "lags": pack(options.Lags()),
    "wind": pack(options.Wind(speed=WIND, origin=WIND_ORIGIN)),
    "shear": pack(options.Shear(gradient=GRADIENT, origin=SHEAR_ORIGIN)),
    "track": pack(options.Track()),
}
LECTURE, STILL, AIRLINER = "track", "envelope energy lags track", "envelope energy lags wind shear track"
ANGLES = ("heading",)


def chosen(parts: str) -> tuple[np.void | None, ...]:
    """The option records of the named parts, in the kernels' order."""
    return tuple(RECORDS[name] if name in parts.split() else None for name in options.OPTIONS)


def flight(**values: float) -> np.ndarray:
    """One record, as the single row of an array."""
    states = np.zeros(1, dtype_of(model.State))
    for name, value in {"altitude": 4000.0, "speed": 150.0, **values}.items():
        states[name] = value
    return states


def flown(parts: str, dt: float, actions: np.ndarray, hold: float, **values: float) -> np.ndarray:
    """States (len(actions), 8) in the order of NAMES, each at the end of an action held for `hold` [s]."""
    states, records, params = flight(**values), chosen(parts), pack(model.Params(dt=dt))
    history = []
    for action in actions:
        for _ in range(round(hold / dt)):
            model.advance(states[0], action, params, *records)
        history.append([states[name][0] for name in NAMES])
    return np.array(history)


def expected(parts: str, actions: np.ndarray, hold: float, **values: float) -> tuple[np.ndarray, int]:
    """The same by DOP853, and how often the aircraft came to a standstill."""
    reference = Flight(parts, **{"altitude": 4000.0, "speed": 150.0, **values})
    history = []
    for action in actions:
        reference.fly(action, hold)
        history.append(reference.y.copy())
    return np.array(history), reference.stops


def assert_close(got: np.ndarray, reference: np.ndarray, relative: float) -> None:
    """Relative to the largest value of a channel over the flight; headings modulo a turn."""
    away = got - reference
    away[:, 5] = (away[:, 5] + math.pi) % (2.0 * math.pi) - math.pi
    scale = np.maximum(np.abs(reference).max(axis=0), 1.0)
    assert np.abs(away / scale).max() < relative


def commands(seed: int, count: int, fast: bool) -> np.ndarray:
    """Actions long enough held to saturate; fast: about a cruising speed, otherwise braking to a standstill."""
    actions = np.clip(np.random.default_rng(seed).normal(0.0, 0.8, (count, 3)), -1.0, 1.0)
    actions[:, 1] = np.abs(actions[:, 1]) * np.where(np.arange(count) % 2 == 0, -1.0, 1.0)
    if not fast:
        actions[:, 0] = np.clip(actions[:, 0], -0.7, 0.7)  # where the power that is shared out allows to brake
        actions[::2, 1] -= 0.5
        actions[1::2, 1] *= 0.9  # no standstill at the very end of an action, where rounding decides
    return np.clip(actions, -1.0, 1.0)


@pytest.mark.parametrize("dt", [0.1, 1.0, 10.0])
@pytest.mark.parametrize("parts", [LECTURE, STILL, AIRLINER])
def test_whole_episode_agrees_with_dop853(parts: str, dt: float) -> None:
    actions = commands(1, 48, True)
    reference, _ = expected(parts, actions, 10.0, heading=1.0)
    assert np.abs(reference[:, 6:]).max() > 1e4
    assert_close(flown(parts, dt, actions, 10.0, heading=1.0), reference, 1e-12)


@pytest.mark.parametrize("parts", [LECTURE, STILL, AIRLINER])
def test_short_episode_of_one_millisecond_intervals_agrees_with_dop853(parts: str) -> None:
    actions = commands(2, 5, True)
    reference, _ = expected(parts, actions, 4.0, heading=-2.0)
    assert_close(flown(parts, 1e-3, actions, 4.0, heading=-2.0), reference, 1e-10)


@pytest.mark.parametrize("dt", [1e-3, 0.1, 1.0, 10.0])
@pytest.mark.parametrize("parts", [LECTURE, STILL, AIRLINER, "wind shear track"])
def test_at_low_speed_too(parts: str, dt: float) -> None:
    """Braking to a standstill, standing, moving off, in turns and climbs; 1 ms over a third of it."""
    actions = commands(8, 4 if dt < 0.01 else 12, False)
    reference, stops = expected(parts, actions, 10.0, speed=2.0, heading=2.5)
    assert stops >= 1
    got = flown(parts, dt, actions, 10.0, speed=2.0, heading=2.5)
    assert got[:, 4].min() == 0.0
    assert_close(got, reference, 1e-10)


@settings(max_examples=150)
@given(
    parts=st.sampled_from([LECTURE, STILL, AIRLINER, "wind shear track"]),
    dt=st.sampled_from([1e-3, 0.1, 1.0, 10.0]),
    action=st.tuples(*[st.sampled_from([-1.0, 0.0, 1.0]) | st.floats(-1.0, 1.0)] * 3),
    rates=st.tuples(st.floats(-10.0, 13.0), st.floats(-0.6, 0.6), st.floats(-0.05, 0.05)),
    speed=st.sampled_from([0.0, 1e-3]) | st.floats(0.0, 8.0) | st.floats(0.0, 250.0),
    heading=st.floats(-3.1, 3.1),
    to_refresh=st.sampled_from([0.0]) | st.floats(1e-3, 1.0),
    climb=st.floats(0.0, 13.0),
)
def test_an_interval_may_be_split(parts, dt, action, rates, speed, heading, to_refresh, climb) -> None:  # type: ignore[no-untyped-def]
    """One step of dt and two of dt / 2 end in the same state, from any state."""
    values = {
        **dict(zip(NAMES[:3], rates, strict=True)), "speed": speed, "heading": heading, "time_to_refresh": to_refresh,
        "climb_limit": climb, "turn_limit": 0.03, "weight_per_speed": G / max(speed, 0.01), "sheared": speed > 0.0,
    }  # fmt: skip
    whole = flight(**values)
    parted = whole.copy()
    model.advance(whole[0], np.array(action), pack(model.Params(dt=dt)), *chosen(parts))
    for _ in range(2):
        model.advance(parted[0], np.array(action), pack(model.Params(dt=0.5 * dt)), *chosen(parts))
    for name in whole.dtype.names:
        away, scale = parted[name][0] - whole[name][0], max(1.0, abs(whole[name][0]))
        if name == "time_to_refresh":  # at the renewal itself: 0 or a rounding away from it
            away = math.remainder(away, 1.0)
        elif name in ANGLES:
            away = math.remainder(away, 2.0 * math.pi)
        elif name == "weight_per_speed" and speed < 10.0:
            continue  # 1 / v doubles the rounding of a small v
        assert abs(away) <= 1e-12 * scale, name


def test_constant_turn_is_the_circle() -> None:
    """x = x0 + (v / w)(cos psi0 - cos(psi0 + w t)), z = z0 + (v / w)(sin(psi0 + w t) - sin psi0)."""
    v, w, psi, t = 150.0, math.radians(3.0), 0.7, 10.0
    x, z = flown(LECTURE, t, np.array([[0.0, 0.0, 1.0]]), t, heading=psi)[0, 6:]
    assert x == pytest.approx(v / w * (math.cos(psi) - math.cos(psi + w * t)), rel=1e-13)
    assert z == pytest.approx(v / w * (math.sin(psi + w * t) - math.sin(psi)), rel=1e-13)


def test_straight_flight_is_the_limit_of_the_turn() -> None:
    """The lecture's forward step v t + a t^2 / 2, along the heading."""
    for turn in (0.0, 1e-12):
        x, z = flown(LECTURE, 8.0, np.array([[0.0, 0.5, turn]]), 8.0, heading=0.4)[0, 6:]
        assert math.hypot(x, z) == pytest.approx(150.0 * 8.0 + 0.15 * 64.0, rel=1e-14)
        assert math.atan2(x, z) == pytest.approx(0.4, abs=1e-12)


@pytest.mark.parametrize("q", [-3.0, -0.2, 0.0, 1e-9, 0.1, 0.4999999, 0.5000001, 2.0])
def test_spherical_bessel_functions(q: float) -> None:
    sign = math.copysign(1.0, q)
    expected = spherical_jn(0, abs(q)), sign * spherical_jn(1, abs(q))
    assert spherical_bessel(q) == pytest.approx(expected, rel=1e-14, abs=1e-300)


def test_ground_track_does_not_contain_the_gust() -> None:
    z = flown(LECTURE, 10.0, np.zeros((1, 3)), 10.0, gust_along=2.0)[0, 7]
    assert z == pytest.approx(1480.0, rel=1e-14)


@pytest.mark.parametrize(
    ("angle", "expected"), [(0.0, 0.0), (3.2, 3.2 - 2 * math.pi), (-3.2, 2 * math.pi - 3.2), (math.pi, -math.pi)]
)
def test_headings_wrap(angle: float, expected: float) -> None:
    assert model.wrap(angle) == pytest.approx(expected, abs=1e-15)
    assert model.wrap(angle + 20.0 * math.pi) == pytest.approx(expected, abs=1e-13)


def test_limits_follow_altitude_speed_and_bank() -> None:
    assert climb_limit(0.0, PARAMS, ENVELOPE) == 13.0
    assert climb_limit(11000.0, PARAMS, ENVELOPE) == pytest.approx(6.0, rel=1e-15)
    assert climb_limit(25000.0, PARAMS, ENVELOPE) == 0.0
    assert climb_limit(11000.0, PARAMS, None) == 13.0
    crossover = G * math.tan(math.radians(25.0)) / math.radians(3.0)  # 87.3 m/s
    assert crossover == pytest.approx(87.3, abs=0.05)
    assert turn_limit(crossover - 1.0, PARAMS, ENVELOPE) == math.radians(3.0)
    assert turn_limit(0.0, PARAMS, ENVELOPE) == math.radians(3.0)
    assert turn_limit(200.0, PARAMS, ENVELOPE) == pytest.approx(math.radians(3.0) * crossover / 200.0, rel=1e-14)


@pytest.mark.parametrize("refresh", [0.25, 1.0, 3.0])
def test_limits_are_renewed_at_their_instants_whatever_the_interval(refresh: float) -> None:
    """Climbing as fast as allowed: y grows by the limit of the last renewal, the first of them at once."""
    ends = []
    for dt in (0.1, 0.75, 6.0):
        states, params = flight(), pack(model.Params(dt=dt, refresh=refresh))
        for _ in range(round(6.0 / dt)):
            model.advance(states[0], np.array([1.0, 0.0, 0.0]), params, *chosen("envelope"))
        ends.append(states["altitude"][0])
    altitude = 4000.0
    for _ in range(round(6.0 / refresh)):
        altitude += refresh * (13.0 - 7.0 * altitude / 11000.0)
    np.testing.assert_allclose(ends, altitude, rtol=1e-14)


@pytest.mark.parametrize("action", [(1, 1), (1, -1), (-1, 1), (-1, -1), (0.3, 1.0), (-0.9, -0.1)])
def test_steady_climb_and_acceleration_share_one_power(action: tuple[float, float]) -> None:
    """Without lags the rates are the commands: g v_y + v a stays in [-8 g, g V_cli], and v_y is as commanded."""
    states = flight(altitude=5500.0, speed=200.0)
    model.advance(states[0], np.array([*action, 0.0]), PARAMS, *chosen("envelope energy"))
    rise, gain = states["vertical_speed"][0], states["acceleration"][0]
    assert rise == pytest.approx(action[0] * (9.5 if action[0] > 0 else 10.0), rel=1e-15)
    power = G * rise + 200.0 * gain
    assert -8.0 * G - 1e-9 <= power <= 9.5 * G + 1e-9
    if abs(gain - 0.6 * action[1]) > 1e-12:
        assert power == pytest.approx(9.5 * G if gain < 0.6 * action[1] else -8.0 * G, rel=1e-12)


@pytest.mark.parametrize("speed", [0.0, 1e-9, 0.3, 10.0])
@pytest.mark.parametrize("rise", [-1.0, -0.5, 1.0])
@pytest.mark.parametrize("gain", [-1.0, 1.0])
def test_shared_power_at_low_speed_keeps_the_acceleration_within_its_limits(
    speed: float, rise: float, gain: float
) -> None:
    """A full climb leaves nothing; what a steep descent gives beyond the largest acceleration, drag takes."""
    states = flight(speed=speed)
    model.advance(states[0], np.array([rise, gain, 0.0]), PARAMS, *chosen("envelope energy"))
    got = states["acceleration"][0]
    if rise == 1.0 and gain > 0.0:
        assert got == 0.0
    elif rise == -1.0 or gain > 0.0:  # 2 m/s beyond the idle sink
        assert got == pytest.approx(0.6, rel=1e-15)
    assert states["speed"][0] >= 0.0


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
    assert model.left_envelope(flight(**values)[0], PARAMS, None) == lost


@pytest.mark.parametrize(
    ("altitude", "speed", "lost"),
    [
        (10000.0, 200.0, False),  # 116 m/s equivalent
        (10000.0, 95.0, True),  # 55 m/s equivalent: stalled
        (10000.0, 256.0, False),  # Mach 0.855
        (10000.0, 259.0, True),  # Mach 0.865
        (2000.0, 260.0, False),
        (1000.0, 318.0, True),  # 303 m/s equivalent
    ],
)
def test_envelope_in_the_atmosphere_is_one_of_equivalent_airspeeds_and_mach_numbers(
    altitude: float, speed: float, lost: bool
) -> None:
    states = flight(altitude=altitude, speed=speed)
    assert model.left_envelope(states[0], PARAMS, pack(options.Atmosphere())) == lost


def test_a_stall_speed_of_zero_never_stalls() -> None:
    params = pack(model.Params(stall_speed=0.0))
    assert not model.left_envelope(flight(speed=0.0)[0], params, None)
