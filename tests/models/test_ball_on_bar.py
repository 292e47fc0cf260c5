"""The ball model against 50 digits and against the closed forms of the bouncing ball."""

import math

import numpy as np
import pytest

from tests.models.ball_reference import Reference
from vr_envs.envs.ball_on_bar import TASK
from vr_envs.envs.scene import resolve
from vr_envs.models.ball_on_bar import advance, demanded
from vr_envs.models.noise import normal_pair
from vr_envs.models.record import dtype_of


def world(scene, key=7):
    params, options = resolve(TASK, scene).records()
    state = np.zeros(1, dtype_of(TASK.state))
    state["key"] = key
    TASK.start(state[0], params, *options)
    return params, options, state


def run(scene, actions, key=7):
    """States and the log of impacts (cycle, time in the cycle, x, z, normal and tangential approach velocity)."""
    params, options, state = world(scene, key)
    impacts = []
    for cycle, action in enumerate(actions):
        log = np.zeros((30_000, 5))
        before = int(state["impacts"][0])
        advance(state[0], np.asarray(action, float), params, *options, log)
        rows = [log[i % len(log)] for i in range(before, int(state["impacts"][0]))]
        impacts += [(cycle, *row) for row in rows]
    return params, state[0], np.array(impacts)


def varied_actions(n, seed=3):
    """Actions about the sink motion whose orbit stays near period one, another one every cycle."""
    rng = np.random.default_rng(seed)
    return np.array([0.4, 0, 0, 0.5, 0, 0]) + rng.uniform(-0.2, 0.2, (n, 6))


@pytest.mark.parametrize(
    ("scene", "actions"),
    [
        pytest.param("bell", np.zeros((26, 6)), id="default-still"),
        pytest.param("bell", varied_actions(26), id="default-action-every-cycle"),
        pytest.param({"scatter": None}, varied_actions(26, 5), id="smooth-action-every-cycle"),
    ],
)
def test_impact_times_match_fifty_digits(scene, actions):
    params, options, state = world(scene)
    reference = Reference(params, state[0])
    scatter = options[0]

    def draws(i):
        if scatter is None:
            return reference.p["restitution"], 0
        first, second = normal_pair(7, i + 1)
        return min(1.0, max(0.0, params["restitution"] + scatter["restitution"] * first)), scatter["normal"] * second

    for cycle, action in enumerate(actions):
        before = len(reference.impacts)
        reference.cycle(demanded(np.asarray(action, float), params), draws)
        reference.impacts[before:] = [(cycle, *row) for row in reference.impacts[before:]]
    _, _, impacts = run(scene, actions)
    assert len(impacts) == len(reference.impacts) >= 50
    assert np.array_equal(impacts[:, 0], [row[0] for row in reference.impacts])
    error = np.array([[float(mine - theirs) for mine, theirs in zip(a[1:4], b[1:], strict=True)] for a, b in zip(impacts, reference.impacts, strict=True)])
    print("largest error: time %.1e s, x %.1e m, z %.1e m" % tuple(np.abs(error).max(axis=0)))
    assert np.abs(error[:, 0]).max() < 1e-13
    assert np.abs(error[:, 1:]).max() < 1e-13
