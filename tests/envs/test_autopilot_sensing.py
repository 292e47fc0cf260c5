"""The autopilot's instruments: late by whole control intervals, with independent normal errors."""

import numpy as np
import pytest

from tests.envs.autopilot_flight import started
from vr_envs.envs.autopilot_observation import read
from vr_envs.models.atmosphere import equivalent_share
from vr_envs.models.autopilot import wrap

PERFECT = dict.fromkeys(("altitude", "airspeed", "heading", "vertical_speed", "acceleration", "turn_rate"), 0.0)
QUIET = {"turbulence": None}


def measured(states):  # type: ignore[no-untyped-def]
    speed = states["speed"] * [equivalent_share(h) for h in states["altitude"]]
    return np.stack([states["altitude"], speed, states["heading"]], axis=1)


def rates(states):  # type: ignore[no-untyped-def]
    return np.stack([states[name] for name in ("vertical_speed", "acceleration", "turn_rate")], axis=1)


@pytest.mark.parametrize("delay", [0, 3, 8])
def test_observations_are_late_and_demands_are_not(delay) -> None:
    world, observations = started({**QUIET, "sensing": {**PERFECT, "delay": delay}}, 16)
    past = [world.states.copy()]
    rng = np.random.default_rng(0)
    for step in range(40):
        old = past[max(0, step - delay)]
        error = past[-1]["demand"] - measured(old)
        error[:, 2] = [wrap(e) for e in error[:, 2]]
        reading = read(observations, world.scene)
        np.testing.assert_allclose(reading.error, error, rtol=1e-5, atol=2e-6)
        np.testing.assert_allclose(reading.rate, rates(old), rtol=1e-6, atol=1e-6)
        np.testing.assert_allclose(reading.altitude, old["altitude"], atol=2e-3)
        np.testing.assert_allclose(reading.true_speed, old["speed"], rtol=1e-5)
        observations = world.step(rng.uniform(-1.0, 1.0, (16, 3)), np.ones(16, np.bool_), 10**6)[0]
        past.append(world.states.copy())


def test_errors_are_normal_and_independent_and_come_from_the_key_alone() -> None:
    sensing = {"altitude": 2.0, "airspeed": 0.3, "heading": 0.003, "vertical_speed": 0.2, "acceleration": 0.02,
               "turn_rate": 0.001, "delay": 0}  # fmt: skip
    scene = {**QUIET, "demands": None, "sensing": sensing}
    n, steps = 50, 100
    world, observations = started(scene, n)
    again, _ = started(scene, n)
    found = []
    for _ in range(steps):
        reading = read(observations, world.scene)
        error = reading.error - (world.states["demand"] - measured(world.states))
        found.append(np.concatenate([-error, reading.rate - rates(world.states)], axis=1))
        observations = world.step(np.zeros((n, 3)), np.ones(n, np.bool_), 10**6)[0]
        again.step(np.zeros((n, 3)), np.ones(n, np.bool_), 10**6)
        np.testing.assert_array_equal(again.observe(), observations)
        np.testing.assert_array_equal(again.observe(), observations)
    flat = np.reshape(found, (n * steps, 6)) / list(sensing.values())[:6]
    size = len(flat)
    np.testing.assert_allclose(flat.mean(axis=0), 0.0, atol=4.5 / np.sqrt(size))
    np.testing.assert_allclose(flat.var(axis=0), 1.0, atol=4.5 * np.sqrt(2.0 / size))
    np.testing.assert_allclose(np.corrcoef(flat.T), np.eye(6), atol=4.5 / np.sqrt(size))
    series = np.array(found) / list(sensing.values())[:6]
    next_one = (series[1:] * series[:-1]).mean(axis=(0, 1))
    np.testing.assert_allclose(next_one, 0.0, atol=4.5 / np.sqrt(size))


def test_the_flight_is_the_same_with_and_without_instruments() -> None:
    with_them, _ = started({**QUIET, "sensing": True}, 4)
    without, _ = started(QUIET, 4)
    for _ in range(20):
        for world in (with_them, without):
            world.step(np.full((4, 3), 0.5), np.ones(4, np.bool_), 10**6)
    for name in ("altitude", "speed", "heading", "demand"):
        np.testing.assert_array_equal(with_them.states[name], without.states[name])
    assert np.all(without.states["past"] == 0.0) and np.all(with_them.states["past"][:, 0] != 0.0)
