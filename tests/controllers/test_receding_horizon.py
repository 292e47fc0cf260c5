import numpy as np
import pytest

from vr_envs.controllers.bell_sink import BellSink
from vr_envs.controllers.linear_quadratic import riccati
from vr_envs.controllers.receding_horizon import RecedingHorizon
from vr_envs.envs.ball_on_bar import TASK
from vr_envs.envs.scene import resolve
from vr_envs.envs.world import World
from vr_envs.evaluation.rollout import rollout
from vr_envs.evaluation.scenarios import scenario_set


@pytest.fixture(scope="module")
def bell():
    return RecedingHorizon(resolve(TASK, "bell"))


def observation(state):
    """What shows the ball's (x, u, z, w, spin) and the motion of a design's state."""
    return np.concatenate([state[:4], state[5:], state[4:5]])[None]


class Upright(RecedingHorizon):
    """About a bar that moves up and down only: its orbit is at x = 0, where the cost is least.

    On a flat bar no gain exists there: of small motions only the changes move the ball, and they telescope.
    """

    SHARE = 0.0


def test_near_the_orbit_the_plan_is_the_linear_quadratic_law():
    """A finite plan that ends with the cost-to-go of the infinite one is the infinite one."""
    law = Upright(resolve(TASK, "lens"))
    orbit = law.design.orbit(law.action)
    a, b = law.design.matrices(orbit.map)
    place = np.zeros(len(a))
    place[0] = law.design.units[0] / 0.002
    _, gain = riccati(a, b, np.outer(place, place), law.EFFORT * np.eye(6))
    rest = np.concatenate([orbit.ball / law.design.units, law.action])
    step = 1e-3 * np.array([1.0, 0.5, 0.1, 0.1, 0.5, 1, 1, 1, 1, 1, 1])
    above, below = (law(observation(rest + sign * step))[0].astype(float) for sign in (1, -1))
    expected = -2.0 * gain @ step
    assert np.abs(expected).max() > 0.04
    # the law's derivatives are one-sided differences
    assert above - below == pytest.approx(expected, abs=0.02 * np.abs(expected).max())


def test_a_ball_at_rest_is_thrown_and_caught(bell):
    world = World(TASK, {"scatter": None}, 1)
    seen = np.empty((1, 10), np.float32)
    world.reset(np.arange(1), np.array([3], np.uint64), seen)
    world.states["resting"], world.states["w"], world.states["z"] = True, 0.0, world.states["motion"][0, 4]
    world.states["d"] = world.states["x"]
    live, counts = np.ones(1, bool), []
    for _ in range(60):
        before = int(world.states["impacts"][0])
        seen, *_ = world.step(bell(seen).astype(float), live, 100)
        counts.append(int(world.states["impacts"][0]) - before)
    assert counts[-5:] == [2] * 5
    assert abs(world.states["x"][0]) < 1e-3


@pytest.mark.parametrize(("scene", "gain"), [("bell", 0.1), ("rolling", 0.5)])
def test_it_beats_the_sink(scene, gain):
    scenarios = scenario_set("BallOnBar", scene, n=8, seed=4, side="training")
    sink = BellSink(scenarios.scene, x_acceleration=8.0, tilt_acceleration=100.0, z_acceleration=7.5)
    scores = [rollout(law, scenarios).scores.mean() for law in (sink, RecedingHorizon(scenarios.scene))]
    assert scores[1] > scores[0] + gain or scores[1] > 0.97


def test_the_plan_depends_on_what_is_seen_now_alone(bell):
    rows = np.random.default_rng(5).uniform(-0.3, 0.3, (6, 10)).astype(np.float32)
    together = bell(rows)
    assert (bell(rows[::-1])[::-1] == together).all()
    assert (np.abs(together) <= 1.0).all() and together.dtype == np.float32


@pytest.mark.parametrize(
    "scene",
    [
        {"z_acceleration_span": 0.0},
        {"x_acceleration": 0.0, "tilt_acceleration": 0.0},
        {"z_acceleration": 3.0, "z_acceleration_span": 0.0},
        {"hold": 0.5},
    ],
)
def test_without_a_linear_quadratic_law_it_is_the_sink_motion(scene):
    law = RecedingHorizon(resolve(TASK, scene))
    actions = law(np.random.default_rng(0).uniform(-0.3, 0.3, (5, 10)).astype(np.float32))
    assert np.isfinite(actions).all() and (np.abs(actions) <= 1.0).all()
    if "z_acceleration_span" not in scene or "z_acceleration" in scene:
        assert (actions == law.action.astype(np.float32)).all()
