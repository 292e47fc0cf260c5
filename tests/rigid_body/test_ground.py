"""The ground of a Chipmunk space: where a wheel's path goes, and that Chipmunk's own contacts lead it there."""

import numpy as np
import pytest

from vr_envs.envs.terrain_ride import TASK
from vr_envs.envs.world import World
from vr_envs.models.road import road_height
from vr_envs.models.terrain import undulation_ahead
from vr_envs.models.terrain_ride import begin_tick
from vr_envs.rigid_body.ground import BareGround, Ground, Profiles, envelope
from vr_envs.rigid_body.terrain_ride import Vehicle

OPTIONS = ("undulation", "road", "profile", "bumps", "obstacle", "wheel")
# set to nothing rather than left out: one set of options is one compilation
DISC = {
    "wheel": True,
    "obstacle": {"first": 0.5},
    "bumps": {"low": 0.0, "high": 0.0},
    "preview": {"horizon": 0.05},
    "stop": {"travel": 5.0},
}


def world(step=None, **scene):
    engine = {} if step is None else {"rigid_body": {"step": step}}
    world = World(TASK, {**scene, **engine}, 1)
    world.reset(np.zeros(1, np.intp), np.array([3], np.uint64), world.observe())
    return world


def options_of(world):
    given = dict(zip(world.scene.options, world.options, strict=True))
    return tuple(given[name] for name in OPTIONS)


def ways(steps, dt, speed=20.0):
    return speed * np.append(dt * (np.arange(steps + 1) - 0.5), steps * dt)


@pytest.mark.parametrize("spacing", [0.013, 0.2, 3.0])
def test_the_path_is_the_road(spacing):
    """And the record stands afterwards where the path has led it."""
    road = world(road={"knot_spacing": spacing}, preview=None)
    state = road.states[0]
    state["to_knot"] = 0.4 * spacing
    before, now = state.copy(), road_height(state, 0.6)
    ground = Ground(state, ways(50, 2e-4), 2e-4, options_of(road))
    heights = [road_height(before, 0.6 + 20.0 * 2e-4 * (k + 0.5) / spacing) - now for k in range(50)]
    assert np.allclose(ground.heights, heights, 0, 1e-14)
    assert ground.end == pytest.approx(road_height(before, 0.6 + 0.2 / spacing) - now, abs=1e-14)
    gone = (state["knot"] - before["knot"]) * spacing + before["to_knot"] - state["to_knot"]
    assert gone == pytest.approx(0.2, abs=1e-13) and state["distance"] == pytest.approx(0.2, abs=1e-15)


def test_sines_are_cut_finer_than_the_error_of_a_step():
    sines = world(base="lecture")
    state = sines.states[0]
    before, undulation = state.copy(), options_of(sines)[0]
    for dt in (1e-3, 1e-4):
        ground = Ground(before.copy(), ways(20, dt), dt, options_of(sines))
        level = undulation_ahead(before, 0.0, undulation)
        exact = [undulation_ahead(before, 20.0 * dt * (k + 0.5), undulation) - level for k in range(20)]
        assert np.abs(np.array(ground.heights) - exact).max() < 5.0 * dt**2


def test_the_envelope_is_the_highest_of_all_discs():
    rng = np.random.default_rng(0)
    x, heights = 0.1 * np.arange(30), rng.uniform(-0.1, 0.1, 30)
    places, radius = rng.uniform(0.6, 2.2, 40), 0.3
    fine = np.linspace(0.0, 2.9, 290_001)
    ground = np.interp(fine, x, heights)
    for place, found in zip(places, envelope(places, x, heights, radius), strict=True):
        near = np.abs(fine - place) < radius
        discs = ground[near] + np.sqrt(radius**2 - (fine[near] - place) ** 2) - radius
        assert discs.max() - 1e-12 < found < discs.max() + 1e-5


def test_a_bare_profile_has_the_knots_of_the_exact_wheel():
    """The exact model's knots are those of the disc's path, and a profile read twice, or farther on, is the same."""
    disc = world(**DISC)
    state = disc.states[0]
    road, wheel = options_of(disc)[1], options_of(disc)[5]
    spacing = float(road["knot_spacing"])
    profiles = Profiles(options_of(disc))
    heights = profiles.between(3, -5, 60)
    assert (heights[:6] == heights[5]).all()
    path = envelope(spacing * np.arange(50), spacing * np.arange(-5, 61), heights, float(wheel["radius"]))
    assert np.allclose(path, state["knots"][:50], 0, 1e-14)
    assert (profiles.between(3, 100, 400)[:5] == Profiles(options_of(disc)).between(3, 100, 104)).all()
    assert (profiles.between(4, -5, 60)[5:] != heights[5:]).any()


def wheel_heights(disc, ticks):
    """Of every step: the height of Chipmunk's wheel, that of the envelope, and the overlap of their contact."""
    state, lag = disc.states[0], dict(zip(disc.scene.options, disc.options, strict=True))["lag"]
    for _ in range(ticks):
        begin_tick(state, np.zeros(2), lag, None)
        vehicle = Vehicle(disc.simulator, state, 0.01, 20.0)
        assert isinstance(vehicle.ground, BareGround)
        for step, height in enumerate(vehicle.ground.heights):
            vehicle.ground.roll(step)
            vehicle.wheel.force = 0.0, vehicle.pull
            vehicle.space.step(vehicle.dt)
            yield vehicle.wheel.position.y, height, 0.5 * vehicle.space.collision_slop


@pytest.mark.parametrize("kind", ["bump", "pothole", "kerb"])
def test_contacts_alone_lead_a_disc_along_its_envelope(kind):
    """In every step, within the overlap of its contacts; where it is lifted over an edge too."""
    obstacle = {"kind": kind, "first": 0.5, "length": 0.6}
    disc = world(2e-5, **{**DISC, "obstacle": obstacle, "road": {"iso_class": "C", "knot_spacing": 0.05}})
    found, path, overlap = np.array(list(wheel_heights(disc, 8))).T
    assert np.ptp(path.reshape(8, -1), axis=1).max() > 0.02  # in one tick
    assert (np.abs(found - path) < 1.1 * overlap).all()


def test_a_disc_does_not_stumble_over_the_joints_of_a_level_road():
    """Up to where it touches the ramp, though its contacts overlap as a ramp ahead asks for."""
    obstacle = {"kind": "ramp", "first": 0.5, "length": 0.6, "height": 0.1}
    disc = world(1e-4, **{**DISC, "obstacle": obstacle, "road": {"iso_class": "flat", "knot_spacing": 0.05}})
    found, path, overlap = np.array(list(wheel_heights(disc, 4))).T
    level = path < 1e-12
    assert 200 < level.sum() < 300 and overlap[level].max() > 1e-4
    assert np.abs(found[level]).max() < 1e-12


def test_the_disc_and_the_exact_wheel_ride_alike():
    """Over a smooth bump of many knots; the exact path is straight between them, the disc's is round."""
    scene = {**DISC, "obstacle": {"first": 1.0, "length": 1.0}, "road": {"iso_class": "flat", "knot_spacing": 0.05}}
    rows = {}
    for step in (None, 1e-4, 2e-5):
        ride = world(step, **scene)
        state, rows[step] = ride.states[0], []
        for _ in range(20):
            if step is None:
                TASK.advance(state, np.zeros(2), ride.params, *ride.options)
            else:
                ride.simulator.advance(state, np.zeros(2))
            rows[step].append(float(state["travel"]))
    errors = [np.abs(np.subtract(rows[step], rows[None])).max() for step in (1e-4, 2e-5)]
    assert np.ptp(rows[None]) > 0.03
    assert errors[1] < 0.4 * errors[0] and errors[1] < 1e-3 * np.ptp(rows[None])
