"""Time neither lost nor gained, whatever the control interval is."""

import math

import numpy as np
import pytest

from vr_envs.envs.autopilot import AutopilotEnv
from vr_envs.envs.terrain_ride import TerrainRideEnv
from vr_envs.models.clock import MEET, left_after, piece_of, to_next_tick

# some end within a hair of a tick, again and again
INTERVALS = [1e-3, 0.0033333333, 1.0 / 3.0, 0.00999999905, 0.01 - 5e-12, 0.01 + 5e-12, 0.1, 0.37, 10.0]


@pytest.mark.parametrize("dt", INTERVALS)
def test_pieces_and_what_is_owed_add_up_to_the_time_that_passed(dt):
    period, to_tick, owed, ticks = 0.01, 0.01, 0.0, 0
    intervals = min(3000, math.ceil(300.0 / dt))
    for _ in range(intervals):
        total = left = dt + owed
        first, here = to_tick, 0
        while left > MEET:
            piece = piece_of(left, to_tick)
            to_tick, ticked = to_next_tick(to_tick, piece, period)
            left -= piece
            if ticked:
                here += 1
                left = left_after(total, first, here, period)
        owed, ticks = left, ticks + here
        assert abs(owed) <= 1.001 * MEET
    assert ticks * period + (period - to_tick) + owed == pytest.approx(intervals * dt, rel=1e-14, abs=1e-15)


@pytest.mark.parametrize("dt", [0.0033333333, 0.00999999905])
def test_a_ride_covers_the_distance_of_its_time(dt):
    env = TerrainRideEnv({"dt": dt, "stop": None})
    env.reset(options={"scenario": 1})
    for _ in range(2999):
        env.step(np.zeros(2))
    assert env.get_state()["distance"] == pytest.approx(2999 * dt * 20.0, rel=1e-12)


def test_a_flight_covers_the_distance_of_its_time():
    env = AutopilotEnv({"turbulence": None, "demands": None, "track": True, "dt": 0.3333333335})
    env.reset(options={"scenario": 1})
    speed = float(env.get_state()["speed"])
    for _ in range(1500):
        env.step(np.zeros(3))
    state = env.get_state()
    assert math.hypot(state["x"], state["z"]) == pytest.approx(1500 * 0.3333333335 * speed, rel=1e-12)
