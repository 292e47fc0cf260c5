"""The clamped first-order lag against an event-split high-order integration, its flow property and its limits."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vr_envs.models.lag import clamped_lag, ramp_time

CASES = [
    # rate, command, time constant, slew: ramp only, ramp then exponential, exponential only, both signs
    (-10.0, 13.0, 2.5, 1.5),
    (0.0, 5.0, 2.5, 1.5),
    (0.2, -0.4, 3.5, 0.15),
    (2.0, 1.0, 2.5, 1.5),
    (1.0, 1.0, 2.5, 1.5),
    (0.0, -1.0, 0.05, 100.0),
]


def reference(rate: float, command: float, time_constant: float, slew: float, duration: float) -> tuple[float, float]:
    """DOP853 on rate' = clamp(...), stopped and restarted where the limit ceases to act."""

    def slope(_: float, y: np.ndarray) -> list[float]:
        return [min(slew, max(-slew, (command - y[0]) / time_constant)), y[0]]

    def corner(_: float, y: np.ndarray) -> float:
        return abs(command - y[0]) - slew * time_constant

    corner.terminal = True
    y, t = np.array([rate, 0.0]), 0.0
    if corner(0.0, y) > 0.0:
        leg = solve_ivp(slope, (0.0, duration), y, "DOP853", rtol=1e-13, atol=1e-14, events=corner)
        y, t = leg.y[:, -1], leg.t[-1]
    if t < duration:
        y = solve_ivp(slope, (t, duration), y, "DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    return float(y[0]), float(y[1])


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("duration", [0.0, 0.3, 1.0, 7.0])
def test_agrees_with_dop853(case: tuple[float, ...], duration: float) -> None:
    scale = max(abs(case[0]), abs(case[1]))
    expected = reference(*case, duration) if duration else (case[0], 0.0)
    assert clamped_lag(*case, duration) == pytest.approx(expected, rel=0, abs=2e-12 * scale * max(1.0, duration))


@pytest.mark.parametrize("case", CASES)
def test_two_halves_are_the_whole(case: tuple[float, ...]) -> None:
    rate, command, time_constant, slew = case
    for split in np.linspace(0.0, 8.0, 33):
        middle, first = clamped_lag(rate, command, time_constant, slew, split)
        end, second = clamped_lag(middle, command, time_constant, slew, 8.0 - split)
        whole = clamped_lag(rate, command, time_constant, slew, 8.0)
        assert (end, first + second) == pytest.approx(whole, rel=1e-13, abs=1e-13)


def test_without_an_active_limit_it_is_the_plain_exponential() -> None:
    after, integral = clamped_lag(0.0, 1.0, 2.0, 1e9, 3.0)
    assert after == pytest.approx(-math.expm1(-1.5), rel=1e-15)
    assert integral == pytest.approx(3.0 + 2.0 * math.expm1(-1.5), rel=1e-14)


def test_the_limit_acts_exactly_until_the_corner() -> None:
    assert ramp_time(0.0, 10.0, 2.5, 1.5) == pytest.approx(10.0 / 1.5 - 2.5, rel=1e-15)
    assert ramp_time(0.0, 3.7, 2.5, 1.5) == 0.0
    assert clamped_lag(0.0, 10.0, 2.5, 1.5, 4.0)[0] == pytest.approx(6.0, rel=1e-15)
