"""The instant of a standstill against roots with 40 digits, grazing ones too, and what happens afterwards."""

import math

import mpmath
import numpy as np
import pytest

from vr_envs.models import autopilot as model
from vr_envs.models.autopilot_options import Lags, Shear
from vr_envs.models.record import dtype_of, pack
from vr_envs.models.standstill import NEVER, sheared_stop_time, stop_time

LAGS = pack(Lags())  # 3.5 s, 0.15 m/s^3
SHEAR = pack(Shear(gradient=0.05, origin=0.5))


def moving(speed: float, acceleration: float = 0.0, **values: float) -> np.void:
    states = np.zeros(1, dtype_of(model.State))
    for name, value in {"altitude": 4000.0, "speed": speed, "acceleration": acceleration, **values}.items():
        states[name] = value
    return states[0]


def airspeed(speed: float, rate: float, command: float, time: mpmath.mpf) -> mpmath.mpf:
    """Airspeed under a lag of 3.5 s whose rate changes by 0.15 at most, by its two pieces."""
    speed, rate, command, slew, tau = (mpmath.mpf(v) for v in (speed, rate, command, 0.15, 3.5))
    gap = command - rate
    ramp = min(max(0, abs(gap) / slew - tau), time)
    sign = mpmath.sign(gap)
    speed += rate * ramp + sign * slew * ramp**2 / 2
    rate += sign * slew * ramp
    rest = time - ramp
    return speed + command * rest - tau * (command - rate) * (1 - mpmath.exp(-rest / tau))


def test_constant_deceleration() -> None:
    assert stop_time(moving(3.0), -0.6, 10.0, None) == pytest.approx(5.0, rel=1e-15)
    assert stop_time(moving(3.0), -0.6, 4.9, None) == NEVER
    assert stop_time(moving(3.0), 0.6, 10.0, None) == NEVER
    assert stop_time(moving(0.0), -0.6, 10.0, None) == 0.0
    assert stop_time(moving(0.0), 0.6, 10.0, None) == NEVER


@pytest.mark.parametrize(
    ("speed", "rate", "command"),
    [
        (2.0, 0.0, -0.6),  # concave
        (0.5, 0.6, -0.6),  # first faster
        (1e-6, 0.4, -0.6),
        (2.0, -0.6, -0.6),  # uniform
        (2.0, -0.6, -0.1),  # convex, still braking
        (0.3, -0.6, 0.6),  # convex, about to accelerate
        (1.1, -0.6, 0.3),
        (1e-9, -0.3, 0.6),
    ],
)
def test_with_a_lag_the_time_is_the_first_root(speed: float, rate: float, command: float) -> None:
    got = stop_time(moving(speed, rate), command, 30.0, LAGS)
    with mpmath.workdps(40):
        # a root between two samples of a millisecond, the first with a change of sign
        times = np.arange(0.0, 30.0, 1e-3)[1:]
        signs = [airspeed(speed, rate, command, mpmath.mpf(t)) < 0 for t in times[:12000]]
        first = times[signs.index(True)]
        low, high = mpmath.mpf(max(0.0, first - 1e-3)), mpmath.mpf(first)
        if speed < 1e-3 and first > 1e-3:
            low = high / 2
        for _ in range(120):
            middle = (low + high) / 2
            low, high = (low, middle) if airspeed(speed, rate, command, middle) < 0 else (middle, high)
    assert got == pytest.approx(float(high), rel=1e-13, abs=1e-15)


def lowest(rate: float, command: float) -> float:
    """Airspeed lost until the acceleration passes 0: the speed from which the standstill is grazed."""
    with mpmath.workdps(40):
        time = mpmath.findroot(lambda t: mpmath.diff(lambda s: airspeed(0, rate, command, s), t), 2.0)
        return float(-airspeed(0, rate, command, time))


def test_a_grazed_standstill_is_met_or_missed_as_the_speed_says() -> None:
    lost = lowest(-0.6, 0.5)
    assert stop_time(moving(lost * (1.0 + 1e-13), -0.6), 0.5, 30.0, LAGS) == NEVER
    touched = stop_time(moving(lost * (1.0 - 1e-13), -0.6), 0.5, 30.0, LAGS)
    earlier = stop_time(moving(lost * (1.0 - 1e-6), -0.6), 0.5, 30.0, LAGS)
    assert earlier < touched < NEVER


@pytest.mark.parametrize(("climb", "turn", "rate", "command"), [(-10.0, 0.05, 0.0, 0.1), (13.0, -0.5, -0.2, -0.6)])
@pytest.mark.parametrize("lags", [None, LAGS])
def test_in_a_shear_the_time_is_the_first_root(
    climb: float, turn: float, rate: float, command: float, lags: np.void | None
) -> None:
    """Against the kernels' own airspeed, sampled at a millisecond: no earlier change of sign, and a root there."""
    state = moving(1.5, rate, vertical_speed=0.5 * climb, turn_rate=-turn, heading=0.3, sheared=True)
    found = sheared_stop_time(state, climb, command, turn, 0.02, 30.0, lags, SHEAR)

    def after(time: float) -> float:
        copy = np.array([state])
        model._glide(copy[0], climb, command, turn, 0.02, time, lags, None, SHEAR, None)
        return float(copy["speed"][0])

    assert 0.1 < found < 30.0
    assert min(after(t) for t in np.arange(0.0, found, 1e-2)) > 0.0
    assert after(found) == pytest.approx(0.0, abs=1e-13)
    assert after(found + 1e-6) == 0.0  # below 0, but for the rounding that _glide takes away


def test_an_aircraft_that_has_stopped_stands_until_it_is_told_to_move() -> None:
    states = np.array([moving(1.0, -0.5, vertical_speed=3.0)])
    model.fly(states[0], 3.0, -0.6, 0.0, 0.01, 10.0, LAGS, None, None, None)
    assert states["speed"][0] == 0.0
    assert states["acceleration"][0] == 0.0
    assert states["altitude"][0] == pytest.approx(4030.0, rel=1e-15)
    model.fly(states[0], 3.0, 0.0, 0.0, 0.01, 10.0, LAGS, None, None, None)
    assert states["speed"][0] == 0.0
    model.fly(states[0], 3.0, 0.4, 0.0, 0.01, 10.0, LAGS, None, None, None)
    assert states["acceleration"][0] == pytest.approx(0.4 * (1.0 - math.exp(-10.0 / 3.5)), rel=1e-14)
    assert states["speed"][0] == pytest.approx(4.0 - 3.5 * 0.4 * (1.0 - math.exp(-10.0 / 3.5)), rel=1e-13)
