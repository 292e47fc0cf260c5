"""Demands of the autopilot: functions of time from the key alone, of the sizes asked for, and possible to fly."""

import math

import numpy as np
import pytest

from tests.envs.autopilot_flight import LEVEL, fly
from vr_envs.models.atmosphere import airspeed_of_mach, equivalent_share

CALM = {"turbulence": None}


@pytest.fixture(scope="module")
def level_flight():
    return fly(LEVEL)[0]


def test_demands_do_not_depend_on_the_flight(level_flight) -> None:
    other = fly(np.array([0.05, 0.0, -1.0]))[0]
    np.testing.assert_array_equal(level_flight["demand"], other["demand"])
    assert np.abs(level_flight["altitude"][-1] - other["altitude"][-1]).min() > 100.0


def test_demands_stay_in_the_operating_range(level_flight) -> None:
    altitude, speed, heading = np.moveaxis(level_flight["demand"], -1, 0)
    assert altitude.min() >= 300.0 and altitude.max() <= 11000.0
    assert speed.min() >= 75.0 and speed.max() <= 160.0
    assert heading.min() >= -math.pi and heading.max() < math.pi


def test_demanded_airspeeds_can_be_flown_at_the_demanded_altitudes() -> None:
    """With a Mach limit that bites, at both ends of every leg."""
    history = fly(LEVEL, {"atmosphere": {"mach_high": 0.6}, "demands": {"ramp": 0.0}})[0]
    altitude, speed, _ = np.moveaxis(history["demand"], -1, 0)
    highest = np.array([[airspeed_of_mach(0.6, h) for h in row] for row in altitude])
    assert np.all(speed <= np.minimum(highest, 160.0) + 1e-12)
    lowered = np.isclose(speed, highest)
    assert lowered.any() and np.mean(speed > 0.9 * highest) > 0.05


def test_changes_are_due_every_40_to_120_s_and_show_at_the_next_control_instant(level_flight) -> None:
    changes = level_flight["changes"]
    due = [np.unique(level_flight["next_change"][:, i]) for i in range(changes.shape[1])]
    holds = np.concatenate([np.diff([0.0, *d]) for d in due])
    assert 40.0 <= holds.min() < 42.0 and 118.0 < holds.max() <= 120.0
    assert np.mean(holds) == pytest.approx(80.0, abs=3.0)
    for i, times in enumerate(due):
        shown = np.flatnonzero(np.diff(changes[:, i])) + 1
        np.testing.assert_array_equal(shown, np.ceil(times[: len(shown)]))


def test_three_channels_in_four_change_and_one_change_in_four_is_a_ramp() -> None:
    # low enough for the Mach limit to lower no airspeed
    first = fly(LEVEL, {"altitude_high": 5000.0}, steps=0)[0][0]
    start = np.stack([first["altitude"], first["speed"], first["heading"]], axis=1)
    start[:, 1] *= [equivalent_share(h) for h in first["altitude"]]
    ramping = first["demand_rate"] != 0.0
    changed = ramping | (np.abs(first["demand"] - start) > 1e-9)
    n = changed.size
    assert np.mean(changed) == pytest.approx(0.75, abs=4.0 * math.sqrt(0.75 * 0.25 / n))
    assert np.mean(ramping[changed]) == pytest.approx(0.25, abs=4.0 * math.sqrt(0.25 * 0.75 / (0.75 * n)))
    np.testing.assert_allclose(first["demand"][ramping], start[ramping], rtol=1e-12)


@pytest.mark.parametrize("ramp", [0.0, 1.0])
def test_a_programme_of_steps_or_ramps_alone(ramp) -> None:
    history = fly(LEVEL, {"demands": {"ramp": ramp, "change": 1.0}}, n=20, steps=200)[0]
    assert np.all((history["demand_rate"] != 0.0) == (ramp == 1.0))
    if ramp == 1.0:  # and continuous through the changes
        assert np.abs(np.diff(history["demand"][:, :, 0], axis=0)).max() <= 0.6 * 13.0 + 1e-9


def test_a_change_is_a_share_of_what_can_be_reached() -> None:
    """Of the equivalent airspeed: the acceleration, times the root of the density ratio, times the hold."""
    first = fly(LEVEL, steps=0)[0][0]
    share = np.array([equivalent_share(h) for h in first["altitude"]])
    change = np.abs(first["demand_target"][:, 1] - first["speed"] * share)
    size = change / (0.6 * share * first["next_change"])
    free = (change > 1e-9) & (first["demand_target"][:, 1] < 120.0)  # not lowered by the Mach limit
    assert 0.03 - 1e-12 <= size[free].min() < 0.1 and 0.5 < size[free].max() <= 0.6 + 1e-12


def test_a_ramp_is_straight_and_ends_at_its_target(level_flight) -> None:
    first = level_flight[0]
    rows = np.flatnonzero(first["demand_rate"][:, 0] != 0.0)
    assert len(rows) > 20
    for i in rows:
        steps = int(first["next_change"][i]) + 1
        times, demand = np.arange(steps), level_flight["demand"][:steps, i, 0]
        left = first["next_change"][i] - times
        expected = first["demand_target"][i, 0] - first["demand_rate"][i, 0] * left
        np.testing.assert_allclose(demand, expected, rtol=1e-13)
        assert demand[0] == pytest.approx(first["altitude"][i], rel=1e-12)


def test_demands_are_the_same_functions_of_time_whatever_the_control_interval() -> None:
    """Not of turbulence either, which an interval of another length blows otherwise."""
    slow = fly(LEVEL, CALM, n=40, steps=300)[0]
    quick = fly(LEVEL, {**CALM, "dt": 0.25}, n=40, steps=1200)[0]
    same = quick["demand"][::4]
    # an interval that a change falls into shows it later when it is longer; the instants after it are the same
    np.testing.assert_allclose(same, slow["demand"], rtol=1e-12, atol=1e-12)
    assert np.all(slow["changes"][-1] >= 2)


def test_without_a_programme_the_demands_stay_what_the_flight_starts_with() -> None:
    history, rewards = fly(LEVEL, {"demands": None, "turbulence": None}, n=5, steps=50)
    np.testing.assert_array_equal(history["demand"][-1], history["demand"][0])
    np.testing.assert_allclose(rewards, 1.0, rtol=1e-12)
