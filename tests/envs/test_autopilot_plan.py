"""Flight plans: read from a file with clear errors, flown at their times whatever the control interval."""

import math
from pathlib import Path

import numpy as np
import pytest

from tests.envs.autopilot_flight import LEVEL, fly
from vr_envs.envs.autopilot import TASK
from vr_envs.envs.autopilot_plan import Plan
from vr_envs.envs.scene import resolve
from vr_envs.models.atmosphere import equivalent_share

EXAMPLE = Path(__file__).resolve().parents[2] / "docs" / "flight_plan.csv"
PLAN = {
    "time": [0.0, 30.0, 70.5],
    "altitude": [1000.0, 1400.0, 1200.0],
    "airspeed": [100.0, 110.0, 110.0],
    "heading": [math.radians(350.0), math.radians(10.0), math.radians(-90.0)],
}
CALM = {"turbulence": None}


def flown(steps=100, dt=1.0, **changes):  # type: ignore[no-untyped-def]
    return fly(LEVEL, {**CALM, "dt": dt, "plan": {**PLAN, **changes}}, n=1, steps=steps)[0][:, 0]


def test_the_flight_starts_level_on_the_first_waypoint() -> None:
    start = flown(steps=0)[0]
    assert start["altitude"] == 1000.0
    assert start["speed"] * equivalent_share(1000.0) == pytest.approx(100.0, rel=1e-14)
    assert start["heading"] == pytest.approx(math.radians(-10.0), abs=1e-14)
    assert start["vertical_speed"] == start["acceleration"] == start["turn_rate"] == 0.0


@pytest.mark.parametrize("dt", [1.0, 0.5, 4.0, 0.1])
def test_demands_step_at_the_control_instant_at_or_after_the_waypoints_time(dt) -> None:
    history = flown(steps=round(100 / dt), dt=dt)
    for k, record in enumerate(history):
        here = int(np.searchsorted(PLAN["time"], k * dt + 1e-9, side="right")) - 1
        expected = [PLAN[name][here] for name in ("altitude", "airspeed")]
        np.testing.assert_array_equal(record["demand"][:2], expected)
        assert math.remainder(record["demand"][2] - PLAN["heading"][here], 2.0 * math.pi) == pytest.approx(0, abs=1e-14)
        np.testing.assert_array_equal(record["demand_rate"], 0.0)


@pytest.mark.parametrize("dt", [1.0, 3.0])
def test_ramps_go_straight_from_waypoint_to_waypoint_and_the_heading_the_short_way(dt) -> None:
    history = flown(steps=round(99 / dt), dt=dt, ramp=True)
    times = dt * np.arange(len(history))
    for channel, name in enumerate(("altitude", "airspeed")):
        expected = np.interp(times, PLAN["time"], PLAN[name])
        np.testing.assert_allclose(history["demand"][:, channel], expected, rtol=1e-13)
    headings = np.interp(times, PLAN["time"], np.radians([-10.0, 10.0, -90.0]))
    np.testing.assert_allclose(history["demand"][:, 2], headings, atol=1e-12)
    assert history["demand_rate"][0][0] == pytest.approx(400.0 / 30.0, rel=1e-14)
    np.testing.assert_array_equal(history["demand_rate"][-1], 0.0)


def test_waypoints_closer_than_a_control_interval_are_passed_over() -> None:
    close = {"time": [0.0, 4.0, 5.0], "altitude": [1000.0, 9000.0, 1500.0]}
    history = flown(steps=2, dt=10.0, **close)
    np.testing.assert_array_equal(history["demand"][:, 0], [1000.0, 1500.0, 1500.0])


def test_the_example_is_a_plan_that_a_scene_takes_in_place_of_its_demands() -> None:
    scene = resolve(TASK, {"plan": str(EXAMPLE)})
    assert scene.options["demands"] is None and len(scene.options["plan"].time) >= 5
    again = resolve(TASK, scene.as_dict())
    assert again.options["plan"] == scene.options["plan"]


def write(tmp_path, text):  # type: ignore[no-untyped-def]
    path = tmp_path / "plan.csv"
    path.write_text(text)
    return str(path)


def test_columns_are_found_by_name_and_degrees_become_radians(tmp_path) -> None:
    path = write(tmp_path, "note, heading_deg,airspeed_m_s,time_s,altitude_m\n,270,100,0,900\n\nx,0,101.5,60,950\n")
    found = Plan.read(path)
    assert found == {"time": (0.0, 60.0), "altitude": (900.0, 950.0), "airspeed": (100.0, 101.5),
                     "heading": (pytest.approx(-0.5 * math.pi), 0.0)}  # fmt: skip


HEADER = "time_s,altitude_m,airspeed_m_s,heading_deg\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "0 columns 'time_s'"),
        ("time_s,altitude_m,airspeed_m_s\n0,1,2\n", "0 columns 'heading_deg'"),
        (HEADER, "no waypoint"),
        (HEADER + "0,900,100,0\n60,high,100,0\n", "line 3: altitude_m = 'high'"),
        (HEADER + "0,900,100,0\n60,900,nan,0\n", "line 3: airspeed_m_s = 'nan'"),
        (HEADER + "0,900,100\n", "line 2: heading_deg = ''"),
        (HEADER + "5,900,100,0\n", r"plan.time\[0\] = 5"),
        (HEADER + "0,900,100,0\n60,900,100,0\n60,900,100,0\n", r"plan.time\[2\] = 60 .*above plan.time\[1\]"),
        (HEADER + "".join(f"{k},900,100,0\n" for k in range(65)), "65 numbers is not allowed; give a list of 1 to 64"),
        (HEADER + "0,900,100,0\n60,900,50,0\n", "waypoint 1 of the plan, 900 m at 50 m/s"),
        (HEADER + "0,11000,160,0\n", "waypoint 0 of the plan.*Mach"),
    ],
)
def test_a_bad_file_is_refused(tmp_path, text, message) -> None:
    with pytest.raises(ValueError, match=message):
        resolve(TASK, {"plan": write(tmp_path, text)})


def test_a_missing_file_uneven_lists_and_two_programmes_are_refused(tmp_path) -> None:
    with pytest.raises(ValueError, match="cannot be read.*give the path of a CSV file"):
        resolve(TASK, {"plan": str(tmp_path / "none.csv")})
    with pytest.raises(ValueError, match="plan.heading has 1 numbers for 2 times"):
        resolve(TASK, {"plan": {**PLAN, "time": [0.0, 30.0], "altitude": [900.0] * 2, "airspeed": [100.0] * 2,
                                "heading": [0.0]}})  # fmt: skip
    with pytest.raises(ValueError, match="demands and plan exclude each other"):
        resolve(TASK, {"plan": PLAN, "demands": True})
