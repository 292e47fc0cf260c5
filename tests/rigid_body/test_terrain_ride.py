"""The Chipmunk vehicle against the exact ride, which it does not know: its motion, its contacts and its order."""

import math

import numpy as np
import pytest

from vr_envs.envs.scene import resolve
from vr_envs.envs.terrain_ride import TASK
from vr_envs.envs.world import World
from vr_envs.models.constants import G
from vr_envs.models.quarter_car import lift_off
from vr_envs.rigid_body.terrain_ride import Vehicle

RIDE = ("travel", "velocity")
CAR = (*RIDE, "deflection", "hub_velocity")
QUARTER_CAR = {"tyre": True}
# set to nothing rather than left out: one set of options is one compilation
LEVEL = {"road": {"iso_class": "flat"}, "bumps": {"low": 0.0, "high": 0.0}}
UNLOADED = {"payload": {"size": 0.0}}
# scene, its fields that move, intervals; the last three swing against their stops, lift off, or both
CASES = [
    ({"base": "lecture"}, RIDE, 60),
    ({"base": "lecture", "damping": "relative"}, RIDE, 60),
    ({}, RIDE, 60),
    ({"damping": "absolute"}, RIDE, 60),
    (QUARTER_CAR, CAR, 60),
    ({"road": {"iso_class": "F"}, "actuation": "active"}, RIDE, 60),
    ({**QUARTER_CAR, "road": {"iso_class": "E"}}, CAR, 60),
    ({**QUARTER_CAR, "road": {"iso_class": "E"}, "stop": {"travel": 0.05}, "actuation": "active"}, CAR, 60),
]


def world(step=None, **scene):
    """One ride in the default scene, moved by the space with steps of `step` s or, None, exactly."""
    engine = {} if step is None else {"rigid_body": {"step": step}}
    world = World(TASK, {**scene, **engine}, 1)
    world.reset(np.zeros(1, np.intp), np.array([7], np.uint64), world.observe())
    return world


def moved(world, intervals, action=None, **start):
    """The records after each of `intervals`, from `start`; actions go up and down unless one is given."""
    state, rows = world.states[0], []
    for name, value in start.items():
        state[name] = value
    for k in range(intervals):
        given = np.sin(0.3 * k + np.arange(world.widths[1])) if action is None else np.array(action, float)
        if world.simulator is None:
            TASK.advance(state, given, world.params, *world.options)
        else:
            world.simulator.advance(state, given)
        state["steps"] += 1
        rows.append(state.copy())
    return np.array(rows)


@pytest.mark.parametrize(("scene", "fields", "intervals"), CASES, ids=str)
def test_it_converges_to_the_exact_ride_with_order_one(scene, fields, intervals):
    """Chipmunk feels a slope, a stop and the ground up to a step late, and scales the kick by the damper's decay."""
    exact = moved(world(**scene), intervals)
    errors = []
    for step in (1e-3, 1e-4):
        found = moved(world(step, **scene), intervals)
        assert found["knots"].tobytes() == exact["knots"].tobytes()
        errors.append([np.sqrt(np.mean((found[f] - exact[f]) ** 2)) for f in fields])
    coarse, fine = np.array(errors)
    size = np.array([np.abs(exact[f]).max() for f in fields])
    order = np.log10(coarse / fine)
    assert (order > 0.8).all() and (order < 1.4).all(), order
    assert (fine < 5e-3 * size).all(), fine / size


def test_lift_off_and_landing_come_with_the_exact_ones():
    scene = {**QUARTER_CAR, "road": {"iso_class": "E"}}
    exact, found = moved(world(**scene), 100)[-1], moved(world(5e-5, **scene), 100)[-1]
    assert exact["liftoffs"] == found["liftoffs"] > 5
    # every flight begins and ends up to a step or so late
    assert abs(found["airborne_time"] - exact["airborne_time"]) < 5e-5 * 2 * exact["liftoffs"]


@pytest.mark.parametrize("step", [1e-3, 1e-4])
def test_a_car_in_the_air_falls_freely(step):
    """Spring, damper and stops act between mass and hub: together they fall as g has it, to rounding."""
    car = world(step, **QUARTER_CAR, **LEVEL, **UNLOADED)
    p, tyre = car.scene.params, car.scene.options["tyre"]
    start = {"deflection": 0.5, "hub_velocity": 1.0, "velocity": -0.5, "travel": 0.06, "airborne": True}
    rows = moved(car, 20, **start)
    assert rows["airborne"].all() and rows["airborne_time"][-1] == pytest.approx(0.2, rel=1e-9)
    momentum = p.mass * rows["velocity"] + tyre.unsprung_mass * rows["hub_velocity"]
    patch = tyre.rate * (2.0 * step) ** 2  # rides along
    assert np.ptp(rows["travel"]) > 0.02
    fallen = -G * (p.mass + tyre.unsprung_mass) * 0.01 * np.arange(1, 21)
    begin = p.mass * -0.5 + tyre.unsprung_mass * 1.0
    assert np.abs(momentum - begin - fallen).max() < 3.0 * patch


def test_a_dropped_car_lands_as_the_exact_one_does():
    """On level ground, where a contact may overlap least."""
    scene = {**QUARTER_CAR, **LEVEL, **UNLOADED}
    start = {"deflection": 0.1, "hub_velocity": -1.0, "velocity": -0.5, "travel": 0.06, "airborne": True}
    exact, *found = (moved(world(step, **scene), 12, **start) for step in (None, 1e-3, 1e-4))
    assert exact["airborne"][0] and not exact["airborne"][-1]
    for field in CAR:
        coarse, fine = (np.abs(one[field] - exact[field]).max() for one in found)
        assert fine < 0.15 * coarse and fine < 8e-4 * np.abs(exact[field]).max()


def test_the_patch_is_lifted_and_laid_down_whole():
    """The patch hangs at the tyre's free length once it is lifted, and lies on the ground as soon as it has landed."""
    car = world(1e-4, **QUARTER_CAR, **LEVEL, **UNLOADED)
    hanging, landing = car.states[0].copy(), car.states[0].copy()
    limit = lift_off(car.params, dict(zip(car.scene.options, car.options, strict=True))["tyre"])
    for state, height, falling in ((hanging, -0.0021, 2.0), (landing, 0.003, -1.0)):
        state["deflection"], state["hub_velocity"], state["travel"] = limit + height, falling, 0.06
        state["airborne"] = height > 0.0
    air, ground = (Vehicle(car.simulator, state, 0.01, 20.0) for state in (hanging, landing))
    air.run()
    ground.run()
    assert hanging["airborne"] and not landing["airborne"]
    assert abs(air.hub.position.y - air.wheel.position.y - air.free) < 1e-5
    assert abs(ground.wheel.position.y) < 2e-6


@pytest.mark.parametrize("scene", [{}, QUARTER_CAR], ids=str)
def test_a_levelled_car_stays_at_rest_whatever_its_modulus(scene):
    rows = moved(world(1e-3, **LEVEL, **UNLOADED, **scene), 20)
    for field in CAR:
        assert np.abs(rows[field]).max() < 1e-11


@pytest.mark.parametrize("scene", [{}, QUARTER_CAR], ids=str)
def test_a_payload_presses_as_in_the_exact_ride(scene):
    """At rest: spring and tyre carry it."""
    scene = {**LEVEL, **scene}
    exact, found = world(**scene), world(1e-3, **scene)
    assert abs(exact.states[0]["payload"]) > 0.1
    last = moved(found, 20, action=np.zeros(2))[-1]
    for field in CAR:
        assert last[field] == pytest.approx(exact.states[0][field], abs=1e-11)


def test_the_wheel_stays_on_the_ground_whatever_pulls_at_it():
    """A wheel without tyre follows sharp crests at once: the mass rides as over the exact one's ground."""
    scene = {"road": {"iso_class": "H", "knot_spacing": 0.05}, "stop": {"travel": 5.0}, "preview": {"horizon": 0.1}}
    exact, found = moved(world(**scene), 40), moved(world(2e-5, **scene), 40)
    assert np.abs(exact["travel"]).max() > 0.2
    for field in RIDE:
        assert np.abs(found[field] - exact[field]).max() < 2e-3 * np.abs(exact[field]).max()


def test_speed_and_way_are_those_of_the_exact_ride():
    scene = {"cruise": {"acceleration": 20.0, "slowest": 19.3, "fastest": 20.7}, "dt": 0.013}
    exact, found = moved(world(**scene), 60), moved(world(1e-4, **scene), 60)
    assert np.ptp(exact["speed"]) > 1.0  # and it is reached within some intervals
    for field in ("speed", "distance", "to_knot", "knot"):
        assert np.allclose(found[field], exact[field], 1e-12, 1e-12)
    assert np.abs(found["travel"] - exact["travel"]).max() < 5e-3 * np.abs(exact["travel"]).max()


def test_touches_of_a_stop_are_counted():
    scene = {"road": {"iso_class": "G"}, "stop": {"travel": 0.03}}
    exact, found = moved(world(**scene), 80), moved(world(2e-5, **scene), 80)
    assert exact["touches"].sum() == found["touches"].sum() > 3
    assert (exact["side"] == found["side"]).mean() > 0.95


@pytest.mark.parametrize("scene", [{}, QUARTER_CAR], ids=str)
def test_an_interval_does_not_look_at_anything_but_the_record(scene):
    """A record moved by another simulator goes on to the same bytes."""
    first = moved(world(1e-3, **scene), 20)
    other = world(1e-3, **scene)
    other.states[0] = first[9]
    state = other.states[0]
    for k in range(10, 20):
        other.simulator.advance(state, np.sin(0.3 * k + np.arange(2)))
        state["steps"] += 1
    assert state.tobytes() == first[-1].tobytes()


def test_steps_divide_a_tick_evenly():
    """A step that does not divide the tick is made smaller, not left over."""
    rows = [moved(world(step), 10)[-1] for step in (7e-4, 0.01 / 15)]
    assert rows[0].tobytes() == rows[1].tobytes()


def test_the_textbook_engine_knows_the_lecture_alone():
    assert resolve(TASK, "lecture", "textbook").engine == "textbook"
    with pytest.raises(ValueError, match=r"damping = 'relative' .* 'textbook'.*give damping = 'absolute'"):
        resolve(TASK, {"base": "lecture", "damping": "relative"}, "textbook")
    with pytest.raises(ValueError, match="engine 'textbook' does not know the option 'stop'"):
        resolve(TASK, {"damping": "absolute"}, "textbook")


def test_a_disc_over_sines_is_refused():
    with pytest.raises(ValueError, match=r"wheel = .* over an undulation with the engine 'rigid_body'"):
        resolve(TASK, {"wheel": True, "undulation": True, "stop": None}, "rigid_body")


@pytest.mark.parametrize(
    ("engine", "scene"),
    [
        ("rigid_body", {"mass": 1.0, "spring_rate": 1e7, "rigid_body": {"step": 1e-3}}),
        ("rigid_body", {"tyre": {"unsprung_mass": 0.1, "rate": 1e8}}),
        ("textbook", {"base": "lecture", "dt": 1.0, "textbook": {"step": 0.5}}),
        ("textbook", {"base": "lecture", "dt": 1.0, "spring_rate": 1e7}),
    ],
    ids=str,
)
def test_a_step_that_may_be_unstable_is_refused(engine, scene):
    with pytest.raises(ValueError, match=rf"{engine}\.step = .* stable below .*give a smaller {engine}\.step"):
        resolve(TASK, scene, engine)


def test_the_longest_step_allowed_is_stable():
    """A stiff car on a level road comes to rest."""
    scene = {"tyre": {"rate": 1e8}, "stop": {"rate": 1.0}, "spring_rate": 5e5, "modulus_high": 1.0, **UNLOADED, **LEVEL}
    p, unsprung = world(**scene).scene.params, 59.0
    step = 0.999 / math.sqrt(p.w2 + 1.0 / p.mass + (p.spring_rate + 1.0 + 1e8) / unsprung)
    assert step > 1e-4
    rows = moved(world(step, **scene), 200, action=np.array([1.0, 1.0]), velocity=0.1)
    assert np.abs(rows["velocity"][-20:]).max() < 0.01 * np.abs(rows["velocity"][:20]).max()
