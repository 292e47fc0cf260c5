import numpy as np
import pytest

from tests.controllers.ride_case import asked, observation
from vr_envs.controllers.terrain_ride_skyhook import Skyhook, SkyhookAdd, TwoStateSkyhook
from vr_envs.envs.scene import resolve
from vr_envs.envs.terrain_ride import TASK

SCENE = resolve(TASK)


@pytest.mark.parametrize("law", [Skyhook, SkyhookAdd, TwoStateSkyhook])
def test_modulus_is_a_factor_on_the_springs_nominal_one(law):
    for modulus in (0.5, 0.8, 2.0):
        assert asked(law(SCENE, modulus=modulus), observation(SCENE))[1] == pytest.approx(modulus, rel=1e-6)


def test_skyhook_damps_in_proportion_while_it_takes_energy():
    """sky v / u' = 10 * 0.125 / 0.25 where both have one sign, else the least."""
    law = Skyhook(SCENE, sky=10.0, least=0.6)
    for velocity, rate, damping in ((0.25, 0.5, 5.0), (-0.25, -0.5, 5.0), (-0.5, 0.5, 0.6), (0.5, 0.0, 10.0)):
        found, _ = asked(law, observation(SCENE, velocity=velocity, travel_rate=rate))
        assert found == pytest.approx(damping, rel=1e-5)


def test_a_force_is_the_real_skyhook():
    scene = resolve(TASK, "active")
    action = Skyhook(scene, sky=10.0)(observation(scene, velocity=0.25, travel_rate=0.5))
    assert action[0, 0] * scene.params.push == pytest.approx(-10 * 0.125, rel=1e-6)


@pytest.mark.parametrize(
    ("velocity", "rate", "hard"), [(0.1, 0.3, True), (-0.1, -0.3, True), (0.1, -0.3, False), (-0.1, 0.3, False)]
)
def test_two_states(velocity, rate, hard):
    law = TwoStateSkyhook(SCENE, hard=7.0, least=0.5)
    found, _ = asked(law, observation(SCENE, velocity=velocity, travel_rate=rate))
    assert found == pytest.approx(7.0 if hard else 0.5, rel=1e-5)


@pytest.mark.parametrize(
    ("acceleration", "velocity", "rate", "hard"),
    [
        # slow: |a| = 1 below 10 * 0.2, the velocity decides
        (1.0, 0.2, 0.1, True),
        (-1.0, 0.2, 0.1, True),
        (1.0, 0.2, -0.1, False),
        (1.0, -0.2, 0.1, False),
        # quick: |a| = 3 above 10 * 0.2, the acceleration decides
        (3.0, 0.2, 0.1, True),
        (-3.0, 0.2, 0.1, False),
        (-3.0, 0.2, -0.1, True),
        (3.0, -0.2, 0.1, True),
    ],
)
def test_sh_add_switches_at_the_crossover(acceleration, velocity, rate, hard):
    law = SkyhookAdd(SCENE, crossover=10.0, hard=7.0, least=0.5)
    row = observation(SCENE, acceleration=acceleration / 2.0, velocity=velocity / 0.5, travel_rate=rate / 0.5)
    assert asked(law, row)[0] == pytest.approx(7.0 if hard else 0.5, rel=1e-5)
    assert bool(acceleration**2 > 100 * velocity**2) == (abs(acceleration) == 3.0)


def test_a_switched_damper_never_gives_energy():
    """Force on the mass times rate of the travel is negative, whatever is observed."""
    rows = np.random.default_rng(1).uniform(-3, 3, (1000, 17)).astype(np.float32)
    for law in (Skyhook, SkyhookAdd, TwoStateSkyhook):
        damping = np.exp(SCENE.params.damping_centre + SCENE.params.damping_half * law(SCENE)(rows)[:, 0])
        assert (damping >= 0.3 * (1 - 1e-6)).all()
