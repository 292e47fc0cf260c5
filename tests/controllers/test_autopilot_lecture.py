"""The lecture's law: proportional, clamped, captured with hysteresis; it flies the lecture's aircraft home."""

import math

import numpy as np
import pytest

from tests.controllers.autopilot_world import world_at
from vr_envs.controllers.autopilot import BASELINE, LAWS
from vr_envs.controllers.autopilot_lecture import TURN_TIME, LectureLaw
from vr_envs.envs.autopilot import TASK
from vr_envs.envs.autopilot_observation import BAND
from vr_envs.envs.scene import resolve


def law_at(errors, **gains):  # type: ignore[no-untyped-def]
    world = world_at(errors)
    law = LectureLaw(world.scene, **gains)
    law.reset(len(world.states))
    return law(world.observe())


def test_the_baseline_is_the_lectures_law() -> None:
    assert LAWS[BASELINE] is LectureLaw


def test_rates_are_proportional_to_the_errors() -> None:
    error = np.array([50.0, -2.0, math.radians(4.0)])
    action = law_at(error, altitude_gain=0.1, speed_gain=0.08, heading_gain=14.0)[0]
    turn = math.atan(14.0 * error[2] / 150.0) / TURN_TIME
    expected = [0.1 * 50.0 / 13.0, -0.08 * 2.0 / 0.6, turn / math.radians(3.0)]
    np.testing.assert_allclose(action, expected, rtol=2e-5)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_rates_are_clamped_to_their_limits(sign: float) -> None:
    np.testing.assert_array_equal(law_at(sign * np.array([3000.0, 60.0, 3.0]))[0], sign)


def test_the_heading_turns_the_short_way() -> None:
    assert law_at([0.0, 0.0, math.radians(350.0)])[0, 2] < 0.0


def test_a_captured_channel_is_released_at_twice_the_threshold() -> None:
    world = world_at(np.zeros(3))
    law = LectureLaw(world.scene)
    law.reset(1)
    commanded = []
    for error in (20.0, 14.0, 20.0, 29.0, 31.0, 20.0):
        world.states["demand"][:, 0] = 5000.0 + error
        commanded.append(law(world.observe())[0, 0] > 0.0)
    assert commanded == [True, False, False, False, True, True]


def test_with_thresholds_of_zero_nothing_is_captured() -> None:
    zero = {"altitude_threshold": 0.0, "speed_threshold": 0.0, "heading_threshold": 0.0}
    assert np.all(law_at([0.5, 0.05, 0.001], **zero) > 0.0)
    assert np.all(law_at([0.5, 0.05, 0.001]) == 0.0)


def test_every_gain_has_its_default_inside_its_range() -> None:
    for low, high, default in LectureLaw.TUNABLE.values():
        assert low <= default <= high


def test_it_brings_the_lectures_aircraft_into_the_band_and_altitude_as_its_time_constant_says() -> None:
    world = world_at([[260.0, 12.0, math.radians(40.0)], [-200.0, -15.0, math.radians(-100.0)]])
    law = LectureLaw(world.scene, altitude_threshold=0.0)
    law.reset(2)
    errors = []
    for _ in range(200):
        world.step(law(world.observe()).astype(np.float64), np.ones(2, np.bool_), 10**6)
        errors.append(world.states["demand"][:, 0] - world.states["altitude"])
    states = world.states
    value = np.stack([states["altitude"], states["speed"], states["heading"]], axis=1)
    assert np.all(np.abs(states["demand"] - value) <= np.array(BAND))
    # the sampled law closes in by 1 - k dt in every interval once it is not clamped
    tail = np.array(errors)[60:80, 0]
    np.testing.assert_allclose(tail[1:] / tail[:-1], 1.0 - 1.0 / 11.0, rtol=1e-3)


@pytest.mark.parametrize(("error", "turn"), [(0.0, 0.0), (1e-6, 1.0), (-2.0, -1.0)])
def test_it_is_defined_at_a_standstill(error, turn) -> None:
    """The angle atan(v_x / v) is a right one there, which is more than the largest turn."""
    world = world_at([0.0, 0.0, error], {"base": "lecture", "stall_speed": 0.0}, speed=0.0)
    law = LectureLaw(world.scene, heading_threshold=0.0)
    law.reset(1)
    assert law(world.observe())[0, 2] == turn


def test_it_works_in_the_default_scene() -> None:
    scene = resolve(TASK)
    law = LectureLaw(scene)
    law.reset(4)
    observations = np.zeros((4, 23), np.float32)
    actions = law(observations)
    assert actions.shape == (4, 3) and actions.dtype == np.float32
    assert np.all(np.abs(actions) <= 1.0)
