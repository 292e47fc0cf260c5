"""The lecture's recurrence: what it shares with the exact motion and what its time step does."""

import math

import numpy as np
import pytest

from vr_envs.models import autopilot as model
from vr_envs.models.autopilot_options import Envelope, Textbook, Track
from vr_envs.models.record import dtype_of, pack

TRACK, ENVELOPE = pack(Track()), pack(Envelope())


def flown(action: tuple[float, float, float], dt: float, step: float | None, intervals: int = 1, **values: float):  # type: ignore[no-untyped-def]
    states = np.zeros(1, dtype_of(model.State))
    for name, value in {"altitude": 4000.0, "speed": 150.0, **values}.items():
        states[name] = value
    textbook = None if step is None else pack(Textbook(step=step))
    for _ in range(intervals):
        model.advance(
            states[0], np.array(action), pack(model.Params(dt=dt)), ENVELOPE, *[None] * 6, TRACK, textbook
        )  # fmt: skip
    return states[0]


def test_one_step_is_the_printed_recurrence() -> None:
    """Dd = v dt + a dt^2 / 2 with the old a and the old heading, then y, v and the heading, the last without dt."""
    got = flown((0.5, 1.0, 1.0), 0.5, 0.5, heading=0.3, acceleration=-0.2)
    climb, turn = 13.0 - 7.0 * 4000.0 / 11000.0, min(math.radians(3.0), 9.80665 * math.tan(math.radians(25.0)) / 150.0)
    forward = 150.0 * 0.5 - 0.2 * 0.5**2 / 2.0
    assert got["x"] == pytest.approx(forward * math.sin(0.3), rel=1e-15)
    assert got["z"] == pytest.approx(forward * math.cos(0.3), rel=1e-15)
    assert got["altitude"] == pytest.approx(4000.0 + 0.5 * climb * 0.5, rel=1e-15)
    assert got["speed"] == pytest.approx(150.3, rel=1e-15)
    assert got["heading"] == pytest.approx(0.3 + turn, rel=1e-14)


def test_the_turn_depends_on_the_step() -> None:
    """At 1 s as commanded, at 0.1 s ten times, at 0.01 s a hundred times as much."""
    action = (0.0, 0.0, 0.2)
    exact = flown(action, 1.0, None)["heading"]
    assert flown(action, 1.0, 1.0)["heading"] == pytest.approx(exact, rel=1e-14)
    assert flown(action, 1.0, 0.1)["heading"] == pytest.approx(10.0 * exact, rel=1e-13)
    assert flown(action, 1.0, 0.01)["heading"] == pytest.approx(100.0 * exact, rel=1e-12)


def test_an_interval_is_a_whole_number_of_equal_steps() -> None:
    """Steps of at most 0.3 s in 1 s are four of 0.25 s."""
    exact = flown((0.0, 0.0, 0.2), 1.0, None)["heading"]
    assert flown((0.0, 0.0, 0.2), 1.0, 0.3)["heading"] == pytest.approx(4.0 * exact, rel=1e-13)
    assert flown((0.0, 0.0, 0.2), 1.0, 0.1, 3)["heading"] == pytest.approx(30.0 * exact, rel=1e-13)


def test_altitude_and_airspeed_have_no_error() -> None:
    for step in (1.0, 0.1):
        got, exact = flown((0.7, 0.4, 0.0), 1.0, step, 20), flown((0.7, 0.4, 0.0), 1.0, None, 20)
        assert got["altitude"] == pytest.approx(exact["altitude"], rel=1e-14)
        assert got["speed"] == pytest.approx(exact["speed"], rel=1e-14)


@pytest.mark.parametrize("step", [1.0, 0.5, 0.25, 0.125])
def test_the_way_forward_is_wrong_by_the_change_of_acceleration_times_half_the_step_squared(step: float) -> None:
    """Once per change of the command, so that the changes add up to the last command: second order in straight flight.

    20 s in which the acceleration changes every second.
    """
    states = np.zeros(1, dtype_of(model.State))
    states["altitude"], states["speed"] = 4000.0, 150.0
    exact, params = states.copy(), pack(model.Params())
    for action in np.linspace(0.05, 0.9, 20):
        for record, textbook in ((states, pack(Textbook(step=step))), (exact, None)):
            model.advance(record[0], np.array([0.0, action, 0.0]), params, ENVELOPE, *[None] * 6, TRACK, textbook)
    assert states["z"][0] - exact["z"][0] == pytest.approx(-0.5 * 0.9 * 0.6 * step**2, rel=1e-8)


def test_the_track_of_a_turn_converges_to_first_order() -> None:
    """The heading is held over a step. The command is scaled by the step, for the same turn rate at every one."""
    exact = flown((0.0, 0.0, 0.8), 20.0, None)
    errors = []
    for step in (0.5, 0.25, 0.125, 0.0625):
        got = flown((0.0, 0.0, 0.8 * step), 20.0, step)
        assert got["heading"] == pytest.approx(exact["heading"], rel=1e-12)
        errors.append(math.hypot(got["x"] - exact["x"], got["z"] - exact["z"]))
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(1.0, abs=0.01)


def test_a_standing_aircraft_neither_turns_nor_goes_backwards() -> None:
    got = flown((0.0, -1.0, 1.0), 1.0, 0.1, 3, speed=0.5, heading=0.1)
    assert got["speed"] == 0.0
    assert got["acceleration"] == 0.0
    before = got["heading"]
    again = flown((0.0, -1.0, 1.0), 1.0, 0.1, 1, speed=0.0, heading=before)
    assert again["heading"] == before
