import numpy as np
import pytest

from tests.controllers.ride_case import asked, observation
from vr_envs.controllers.terrain_ride_optimal import ClippedOptimal, LinearQuadratic, LoadObserver, Preview
from vr_envs.envs.scene import resolve
from vr_envs.envs.terrain_ride import TASK, TerrainRideBatchEnv
from vr_envs.envs.terrain_ride_observation import read

FLAT = {"road": {"iso_class": "flat"}, "bumps": None}


def test_the_damper_gives_what_is_wanted_where_it_can():
    """Travel 0, so the spring has no say: v' = -K v wanted, -gamma u' given."""
    scene = resolve(TASK, {"payload": None})
    law = ClippedOptimal(scene, persistence=1.0, lead=1e-6, least=0.4)
    gain = law.gain[1]
    for velocity, rate in ((0.1, 0.25), (-0.1, -0.25)):
        damping, _ = asked(law, observation(scene, velocity=velocity / 0.5, travel_rate=rate / 0.5))
        assert damping == pytest.approx(gain * velocity / rate, rel=1e-3)


def test_the_clipped_law_never_asks_a_damper_for_energy():
    """Where mass and travel move opposite ways the wanted force would feed the travel: the least damping, no more."""
    scene = resolve(TASK, {"payload": None})
    law = ClippedOptimal(scene, persistence=1.0, lead=1e-6, least=0.4)
    for velocity, rate in ((0.1, -0.25), (-0.1, 0.25)):
        damping, _ = asked(law, observation(scene, velocity=velocity / 0.5, travel_rate=rate / 0.5))
        assert damping == pytest.approx(0.4, rel=1e-6)
    rows = np.random.default_rng(0).uniform(-2, 2, (2000, 17)).astype(np.float32)
    for one in (law, Preview(scene)):
        one.reset(2000)
        p, actions = scene.params, one(rows)
        damping = np.exp(p.damping_centre + p.damping_half * actions[:, 0].astype(float))
        assert damping.min() > 0.39


def test_modulus_gives_what_the_damper_leaves():
    """At rest with the travel u only the spring can act: w2 m u = K u + w2 u wanted, whatever the damping."""
    scene = resolve(TASK, {"payload": None})
    law = ClippedOptimal(scene, persistence=0.0, lead=1e-6, travel=4.0)
    _, modulus = asked(law, observation(scene, travel=0.4))
    assert modulus == pytest.approx(1.0 + law.gain[0] / scene.params.w2, rel=1e-3)


def test_the_load_is_found_and_carried():
    """On a flat road a force levels the payload; the estimate is the payload, to the sensors' error."""
    scene = {"base": "active", **FLAT, "noise": None}
    env = TerrainRideBatchEnv(16, scene=scene)
    law = LinearQuadratic(env.world.scene)
    observations, _ = env.reset(seed=0)
    law.reset(16)
    sag = env.get_state()["travel"]
    for _ in range(800):
        observations, *_ = env.step(law(observations))
    states = env.get_state()
    assert np.abs(sag).max() > 0.01
    assert law.observer.load == pytest.approx(states["payload"], abs=5e-3)
    assert np.abs(states["travel"]).max() < 2e-4


def test_nothing_is_learned_from_a_stop_and_no_load_is_larger_than_loads_are():
    scene = resolve(TASK)
    observer = LoadObserver(scene, 3.0)
    observer.reset(1)
    at_stop = read(observation(scene, travel=1.7, acceleration=4.0), scene)
    assert observer.update(at_stop, np.zeros(1)) == 0.0
    inside = read(observation(scene, acceleration=4.0), scene)
    assert observer.update(inside, np.zeros(1))[0] == pytest.approx(8.0 * (1 - np.exp(-0.03)), rel=1e-6)
    for _ in range(1000):
        observer.update(inside, np.zeros(1))
    assert observer.load == 1.0
    observer.reset(2)
    assert (observer.load == 0.0).all() and observer.load.shape == (2,)


@pytest.mark.parametrize("scene", ["quarter-car", "active"])
def test_preview_acts_before_the_bump_arrives(scene):
    """On a flat road with one bump in view the others wait; with it the force, or the damping, changes at once."""
    resolved = resolve(TASK, {"base": scene, "payload": None})
    quiet = observation(resolved)
    bump = observation(resolved, **{"road_0.15 s ahead": 1.0, "road_0.18 s ahead": 1.0})
    law = Preview(resolved)
    other = (LinearQuadratic if scene == "active" else ClippedOptimal)(resolved)
    for one in (law, other):
        one.reset(1)
    assert (other(quiet) == other(bump)).all()
    assert np.abs(law(quiet) - law(bump)).max() > 0.05
