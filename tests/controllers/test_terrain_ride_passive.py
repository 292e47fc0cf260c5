import math

import numpy as np
import pytest

from tests.controllers.ride_case import asked, observation, run
from vr_envs.controllers.terrain_ride_passive import LecturePassive
from vr_envs.envs.scene import resolve
from vr_envs.envs.terrain_ride import TASK, TerrainRideBatchEnv
from vr_envs.models.terrain_ride import suspension


def test_restitution_becomes_damping_in_the_ride():
    """k_d = 0.95 at 60 Hz is 3.08 1/s, at the nominal modulus."""
    scene = resolve(TASK, {"lag": None})
    env = TerrainRideBatchEnv(1, scene={"lag": None})
    env.reset(seed=0)
    env.step(LecturePassive(scene, restitution=0.95)(observation(scene)))
    gamma, w2, _ = suspension(env.world.states[0], env.world.params)
    assert gamma == pytest.approx(-60 * math.log(0.95), rel=1e-6)
    assert w2 == pytest.approx(16812 / 290, rel=1e-6)


def test_every_restitution_in_the_range_is_a_damping_that_the_damper_has():
    low, high, default = LecturePassive.TUNABLE["restitution"]
    assert -60 * math.log(low) == pytest.approx(10.0, rel=1e-14)
    assert -60 * math.log(high) == pytest.approx(0.3, rel=1e-12)
    scene = resolve(TASK)
    for k in (low, default, high):
        found = asked(LecturePassive(scene, restitution=k), observation(scene))
        assert found == pytest.approx((-60 * math.log(k), 1.0), rel=1e-6)


def test_modulus_stays_nominal_where_its_range_is_lopsided():
    scene = resolve(TASK, {"modulus_low": 0.9, "modulus_high": 4.0})
    assert asked(LecturePassive(scene), observation(scene))[1] == pytest.approx(1.0, rel=1e-6)
    assert asked(LecturePassive(scene, modulus=0.5), observation(scene))[1] == pytest.approx(0.9, rel=1e-6)


@pytest.mark.parametrize("modulus", [0.6, 1.4])
def test_active_baseline_is_the_same_damper_and_spring(modulus):
    """A force that imitates damper and spring scores as they do, but for its being held over the interval."""
    scene = {"lag": None, "noise": None, "force": 1e5}
    passive = run(LecturePassive(resolve(TASK, scene), modulus=modulus), scene=scene)
    active_scene = {**scene, "actuation": "active"}
    active = run(LecturePassive(resolve(TASK, active_scene), modulus=modulus), scene=active_scene)
    assert np.mean(active) == pytest.approx(np.mean(passive), abs=0.03)
