"""The lecture's recurrence: its map, its limit of stability, and what its two readings converge to."""

import math

import numpy as np
import pytest

from vr_envs.envs.task import Metrics
from vr_envs.models.record import dtype_of, pack
from vr_envs.models.ride_options import TICK, Textbook
from vr_envs.models.ride_textbook import drift, kick, roll, step_of
from vr_envs.models.road import start_road
from vr_envs.models.road_options import Road
from vr_envs.models.terrain import Undulation, start_undulation, undulation_ahead
from vr_envs.models.terrain_ride import Params, State, advance

OPTIONS = (
    "undulation", "road", "profile", "bumps", "obstacle", "wheel", "tyre", "stop", "lag", "cruise", "textbook",
    "metrics",
)  # fmt: skip
LEVEL = (None,) * 6  # no ground but a level one
SINES = pack(Undulation())


def fresh(**fields):
    state = np.zeros(1, dtype_of(State))[0]
    for name, value in {"key": 5, **fields}.items():
        state[name] = value
    return state


def ridden(textbook, dt, intervals, road=None, **fields):
    """Travel, velocity and height over the start after every interval, over sines (and a road)."""
    params = pack(Params(damping="absolute", dt=dt))
    given = {"undulation": SINES, "textbook": None if textbook is None else pack(textbook), "metrics": pack(Metrics())}
    state = fresh(**fields)
    start_undulation(state)
    if road is not None:
        given["road"] = pack(road)
        start_road(state, given["road"], None, None, None, None)
    rows = []
    for _ in range(intervals):
        advance(state, np.array([0.3, -0.2]), params, *(given.get(name) for name in OPTIONS))
        rows.append((state["travel"], state["velocity"], state["travel"] + state["climb"]))
    return np.array(rows), state


def step_matrix(step, gamma, w2):
    """The map of (displacement, velocity) that one step of the recurrence is."""
    params, textbook = pack(Params()), pack(Textbook())
    columns = []
    for start in ((1.0, 0.0), (0.0, 1.0)):
        state = fresh(travel=start[0], velocity=start[1])
        rise = drift(state, step, params, *LEVEL)
        kick(state, step, rise, gamma, w2, 0.0, textbook)
        columns.append((state["travel"], state["velocity"]))
    return np.array(columns).T


@pytest.mark.parametrize("damping", [0.0, 0.6, 5.0, 40.0])
@pytest.mark.parametrize("step", [1 / 120, 1 / 60, 0.2])
def test_a_step_is_the_lectures_map(damping, step):
    w2 = 58.0
    k_d = math.exp(-damping * step)
    expected = [[1.0, step], [-w2 * step, k_d - w2 * step**2]]
    assert np.allclose(step_matrix(step, damping, w2), expected, 0, 1e-14)


@pytest.mark.parametrize("k_d", [1.0, 0.99, 0.5, 0.01])
def test_it_is_stable_up_to_its_closed_form_limit(k_d):
    """w dt < sqrt(2 (1 + k_d)): damping makes the limit lower."""
    step = 1 / 60
    gamma = -math.log(k_d) / step
    limit = math.sqrt(2.0 * (1.0 + k_d)) / step
    radius = [np.abs(np.linalg.eigvals(step_matrix(step, gamma, (f * limit) ** 2))).max() for f in (0.999, 1.001)]
    assert radius[0] < 1.0 + 1e-12 and radius[1] > 1.0 + 1e-6


@pytest.mark.parametrize("road", [None, Road(iso_class="B")])
def test_reading_a_converges_to_the_exact_ride_with_order_one(road):
    exact = ridden(None, 0.1, 80, road, travel=0.03)[0][:, :2]
    found = [ridden(Textbook(step=s), 0.1, 80, road, travel=0.03)[0][:, :2] for s in (1 / 160, 1 / 320, 1 / 640)]
    errors = [np.abs(one - exact).max(axis=0) for one in found]
    order = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (np.abs(order - 1.0) < 0.12).all(), order
    assert (errors[-1] < 0.02 * np.abs(exact).max(axis=0)).all()


def test_reading_b_feels_half_of_the_ground_at_half_the_step():
    """Its motion vanishes with the step: it is not the exact one's, which stays."""
    exact = ridden(None, 0.1, 200)[0][100:, 1].std()
    sizes = [ridden(Textbook(step=s, reading="B"), 0.1, 200)[0][100:, 1].std() for s in (1 / 60, 1 / 120, 1 / 240)]
    assert np.allclose(np.divide(sizes[:-1], sizes[1:]), 2.0, 0, 0.1)
    assert sizes[-1] < 0.1 * exact


@pytest.mark.parametrize("reading", ["A", "B"])
def test_the_readings_are_the_slides_recurrences(reading):
    """Against the recurrence written out in the lecture's own variables: y down, e = y - l + h."""
    params = Params(damping="absolute", dt=1 / 60)
    mass, length, g, dt = params.mass, 0.5, 9.81, 1 / 60
    gamma = math.exp(params.damping_centre + params.damping_half * 0.3)
    modulus = params.spring_rate * length * math.exp(params.modulus_centre + params.modulus_half * -0.2)
    rest = length + mass * g * length / modulus
    road = fresh()
    start_undulation(road)
    y, v, ground, expected = rest - 0.02, 0.0, undulation_ahead(road, 0.0, SINES), []
    first = ground
    for _ in range(100):
        y += v * dt
        roll(road, params.speed * dt, SINES, *LEVEL[1:])
        before, ground = ground, undulation_ahead(road, 0.0, SINES)
        h = ground - (first if reading == "A" else before)
        a = g - modulus * (y - length + h) / (length * mass)
        v = math.exp(-gamma * dt) * v + a * dt
        expected.append((rest - y, -v))
    found, _ = ridden(Textbook(reading=reading), dt, 100, travel=0.02)
    assert np.abs(found[:, [2, 1]] - expected).max() < 1e-12


def test_an_interval_is_a_whole_number_of_equal_steps():
    for dt, step, expected in ((0.01, 1 / 60, 0.01), (0.05, 1 / 60, 1 / 60), (0.1, 0.03, 0.025), (1.0, 1.0, 1.0)):
        assert step_of(pack(Params(dt=dt)), pack(Textbook(step=step))) == pytest.approx(expected, rel=1e-14)


def test_ticks_within_a_step_see_the_mass_move_evenly():
    """The ground and the mass are where they are at the tick; the velocity changes at the step's end alone."""
    found, state = ridden(Textbook(step=0.05), 0.05, 1, travel=0.01, velocity=0.4)
    assert state["ticks"] == 5
    assert state["acceleration"] == pytest.approx((state["velocity"] - 0.4) / TICK, rel=1e-12)
    road = fresh()
    start_undulation(road)
    travel, squares = 0.01, 0.0
    for _ in range(5):
        travel += 0.4 * TICK - roll(road, Params().speed * TICK, SINES, *LEVEL[1:])
        squares += travel**2
    assert state["travel_squares"] == pytest.approx(squares, rel=1e-12)
    assert found[0, 0] == pytest.approx(travel, rel=1e-12)
