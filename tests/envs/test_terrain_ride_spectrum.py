"""Long rides against the frequency domain: dynamics, road, weighting and meter, all at once."""

from functools import partial

import numpy as np
import pytest

from vr_envs.envs.terrain_ride import TerrainRideBatchEnv
from vr_envs.models.ride_spectrum import Vehicle, metered_rms, ride_rms
from vr_envs.models.road_density import met_density, road_density
from vr_envs.models.road_options import Road

SECONDS, ROWS, SETTLE, DT = 200, 200, 10, 0.1
CAR = Vehicle(290.0, 16812.0, 1500.0, 59.0, 190e3)
SUMS = {
    "weighted": "weighted_squares",
    "acceleration": "acceleration_squares",
    "travel": "travel_squares",
    "load": "load_squares",
}


def long_ride(spacing, speed, tyre, iso_class="C"):
    """Name -> (rms, its relative standard error) over 40 000 s of road, the settling left out."""
    env = TerrainRideBatchEnv(
        ROWS,
        scene={
            "dt": DT, "speed": speed, "tyre": tyre, "bumps": None, "stop": None, "payload": None, "lag": None,
            "noise": None, "preview": None,
            "road": {"iso_class": iso_class, "spread": 0.0, "knot_spacing": spacing},
        },
    )  # fmt: skip
    env.reset(seed=1)
    p = env.world.scene.params
    position = [(np.log(1500.0 / 290.0) - p.damping_centre) / p.damping_half, -p.modulus_centre / p.modulus_half]
    actions = np.tile(position, (ROWS, 1))
    for _ in range(round(SETTLE / DT)):
        env.step(actions)
    before = env.get_state()
    for _ in range(round(SECONDS / DT)):
        env.step(actions)
    after = env.get_state()
    found = {}
    for name, field in SUMS.items():
        squares = (after[field] - before[field]) / (after["ticks"] - before["ticks"])
        error = 0.5 * squares.std() / np.sqrt(ROWS) / max(squares.mean(), 1e-300)
        found[name] = np.sqrt(squares.mean()), error
    return found


@pytest.mark.parametrize("spacing", [0.05, 0.1])
def test_quarter_car_on_class_c(spacing):
    """a_w = 1.306 m/s^2 within 2 %; and within 0.4 % (4 standard errors) what the polygon of knots has, metered."""
    found = long_ride(spacing, 20.0, tyre=True)
    road = Road("C", 0.0, spacing)
    meter = metered_rms(CAR, 20.0, partial(met_density, road=road))
    exact = ride_rms(CAR, 20.0, partial(met_density, road=road), (1e-4, 40.0))
    expected = {"weighted": meter[0], "acceleration": meter[1], "travel": exact.travel}
    assert found["weighted"][0] == pytest.approx(1.306, rel=0.02)
    for name, value in expected.items():
        assert found[name][1] < 2e-3
        assert found[name][0] == pytest.approx(value, rel=4 * found[name][1])
    # here every tick meets a knot, where the polygon is the road itself; it lifts off 0.02 times a second
    load = ride_rms(CAR, 20.0, partial(road_density, road=road), (1e-4, 50.0)).tyre_load
    assert found["load"][0] == pytest.approx(load, rel=4 * found["load"][1])


@pytest.mark.parametrize("spacing", [0.05, 0.2])
def test_follower_out_of_step_with_the_ticks(spacing):
    """A wheel that follows the ground feels every knot; the meter folds that back, and the formula knows how much."""
    found = long_ride(spacing, 20.3, tyre=None)
    vehicle = Vehicle(290.0, 16812.0, 1500.0)
    expected = metered_rms(vehicle, 20.3, partial(met_density, road=Road("C", 0.0, spacing)))
    for name, value in zip(("weighted", "acceleration"), expected, strict=True):
        assert found[name][0] == pytest.approx(value, rel=4 * found[name][1])


def test_classes_scale_by_two_while_the_tyre_stays_on_the_ground():
    a, b = (long_ride(0.1, 20.0, tyre=True, iso_class=k) for k in "AB")
    for name in SUMS:
        assert b[name][0] == pytest.approx(2.0 * a[name][0], rel=1e-9)
