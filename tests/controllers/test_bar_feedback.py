"""The laws that feed the ball's state back: what their design promises, and that it holds in the exact model."""

import numpy as np
import pytest

from vr_envs.controllers.ball_on_bar import BASELINE, LAWS
from vr_envs.controllers.bar_design import Design, within_reach
from vr_envs.controllers.bell_sink import BellSink, parabolic_action
from vr_envs.controllers.linear_quadratic import LinearQuadratic, riccati
from vr_envs.controllers.vertical_dead_beat import CYCLES, VERTICAL, VerticalDeadBeat, dead_beat_plan
from vr_envs.envs.ball_on_bar import TASK
from vr_envs.envs.scene import resolve
from vr_envs.evaluation.rollout import rollout
from vr_envs.evaluation.scenarios import scenario_set

MOVED = parabolic_action(resolve(TASK), 4.0, 50.0, 8.0, 0.4)


def follow(design, state, actions):
    """The exact state s after the given actions, one a cycle; without scatter."""
    k = len(design.units)
    for action in actions:
        image = design.map.derivative(state[:k] * design.units, design.motion(state[k:]), design.motion(action)).image
        state = np.concatenate([image / design.units, action])
    return state


@pytest.mark.parametrize("hold", [1.0, 3.0])
@pytest.mark.parametrize("scene", ["bell", "rolling"])
def test_the_design_predicts_the_exact_model_to_second_order(scene, hold):
    design = Design(resolve(TASK, {"base": scene, "hold": hold}))
    a, b = design.matrices(design.orbit(MOVED).map)
    rest = np.concatenate([design.orbit(MOVED).ball / design.units, MOVED])
    rng = np.random.default_rng(2)
    ds, da = 1e-2 * rng.uniform(-1, 1, len(rest)), rng.uniform(-1, 1, 6)
    ds[2:4] *= 0.1
    errors = []
    for size in (4e-4, 2e-4):
        moved = follow(design, rest + size * ds, [MOVED + size * da] * int(hold))
        errors.append(np.abs(moved - rest - size * (a @ ds + b @ da)).max())
    assert errors[0] == pytest.approx(4 * errors[1], rel=0.1)


@pytest.mark.parametrize("scene", TASK.scenes)
def test_the_feedback_is_stable_and_its_cost_is_the_riccati_one(scene):
    law = LinearQuadratic(resolve(TASK, scene))
    a, b = law.design.matrices(law.design.orbit(law.action).map)
    closed = a - b @ law.gain
    assert np.abs(np.linalg.eigvals(closed)).max() < 1.0
    place = np.zeros(len(a))
    place[0] = law.design.units[0] / 0.002
    p, gain = riccati(a, b, np.outer(place, place), np.eye(6))
    closed = a - b @ gain
    s = np.random.default_rng(1).normal(size=len(a))
    expected, cost = s @ p @ s, 0.0
    for _ in range(200):
        action = -gain @ s
        cost += (place @ s) ** 2 + action @ action
        s = closed @ s
    assert cost + s @ p @ s == pytest.approx(expected, rel=1e-6)
    assert s @ p @ s < 0.999 * expected


def test_the_dead_beat_plan_brings_the_launch_back_in_four_impacts_of_the_exact_model():
    design = Design(resolve(TASK))
    action = parabolic_action(resolve(TASK), 0.0, 0.0, 8.0, 0.0)
    orbit = design.orbit(action)
    plan = dead_beat_plan(*design.matrices(orbit.map))
    rest = np.concatenate([orbit.ball / design.units, action])
    kick = np.zeros(len(rest))
    kick[2], kick[3], kick[-2], kick[-1] = 2e-4, -1e-3, 0.01, -0.02
    left = []
    for size in (1.0, 0.5):
        actions = []
        for k in range(CYCLES):
            actions.append(action.copy())
            actions[-1][4:6] += plan[k] @ (size * kick)
        reached = follow(design, rest + size * kick, actions)
        unaided = follow(design, rest + size * kick, [action] * CYCLES)
        left.append(np.abs(reached - rest)[VERTICAL].max())
        assert left[-1] < 0.05 * np.abs(unaided - rest)[VERTICAL].max()
    assert left[0] == pytest.approx(4 * left[1], rel=0.3)  # what is left is of second order


def test_the_dead_beat_feedback_forgets_a_vertical_error_in_a_few_cycles():
    law = VerticalDeadBeat(resolve(TASK), x_acceleration=0.0, tilt_acceleration=0.0)
    a, b = law.design.matrices(law.design.orbit(law.action).map)
    vertical = [2, 3, 8, 9]
    closed = a[np.ix_(vertical, vertical)] + b[np.ix_(vertical, [4, 5])] @ law.gain[:, vertical]
    assert np.abs(np.linalg.eigvals(closed)).max() < 0.2 < np.abs(np.linalg.eigvals(a[2:4, 2:4])).max()


@pytest.mark.parametrize("law", [VerticalDeadBeat, LinearQuadratic])
@pytest.mark.parametrize(
    "scene",
    [
        {"z_acceleration_span": 0.0},
        {"x_acceleration": 0.0},
        {"tilt_acceleration": 0.0},
        {"x_acceleration": 0.0, "tilt_acceleration": 0.0},
        {"z_acceleration": 3.0, "z_acceleration_span": 0.0},
        {"hold": 0.5},
        {"frequencies": True, "sensing": True},
    ],
)
def test_without_authority_or_orbit_a_law_asks_the_missing_part_for_nothing(law, scene):
    resolved = resolve(TASK, scene)
    policy = law(resolved)
    actions = policy(np.random.default_rng(0).uniform(-1, 1, (50, 10)).astype(np.float32))
    assert np.isfinite(actions).all() and (np.abs(actions) <= 1.0).all() and actions.dtype == np.float32
    for channels, name in (([0, 1], "x_acceleration"), ([2, 3], "tilt_acceleration"), ([4, 5], "z_acceleration_span")):
        if scene.get(name) == 0.0:
            assert np.abs(actions[:, channels]).max() < 1e-6
    if scene.get("z_acceleration") == 3.0 or "hold" in scene:
        assert (actions == actions[0]).all()
        assert actions[0] == pytest.approx(BellSink(resolved).action)


def test_a_change_beyond_the_box_is_shortened_and_not_bent():
    action = np.array([0.4, 0.0, 0.5, -0.2, 0.0, 0.9])
    changes = np.array([[0.1, 0, 0, 0, 0, 0.05], [1.2, 0, -0.3, 0, 0, 0], [0, 0, 0, 0, 0, 0], [0, 3, 0, 0, 0, 0.2]])
    found = within_reach(action, changes)
    assert found[0] == pytest.approx(action + changes[0], abs=1e-7)
    assert found[1] == pytest.approx(action + 0.5 * changes[1], abs=1e-7)
    assert found[2] == pytest.approx(action, abs=1e-7)
    assert found[3] == pytest.approx(action + changes[3] / 3.0, abs=1e-7)


@pytest.mark.parametrize("scene", ["bell", "lens"])
def test_the_linear_quadratic_law_beats_the_sink(scene):
    scenarios = scenario_set("BallOnBar", scene, n=24, seed=3, side="training")
    gains = {"x_acceleration": 8.0, "tilt_acceleration": 80.0, "effort": 0.1, "z_effort": 1.0}
    sink = {k: v for k, v in gains.items() if k in BellSink.TUNABLE}
    scores = [
        rollout(law, scenarios).scores
        for law in (LAWS[BASELINE](scenarios.scene, **sink), LinearQuadratic(scenarios.scene, **gains))
    ]
    assert np.mean(scores[1] - scores[0]) > 0.01
