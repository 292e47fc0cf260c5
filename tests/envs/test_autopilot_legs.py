"""Rise, settling, overshoot, steady error and success against the same definitions written out on whole histories."""

import math

import numpy as np
import pytest

from tests.envs.autopilot_flight import started
from vr_envs.controllers.autopilot import LAWS
from vr_envs.envs.autopilot import AutopilotEnv
from vr_envs.envs.autopilot_demands import NEVER
from vr_envs.envs.autopilot_observation import BAND
from vr_envs.models.atmosphere import equivalent_share
from vr_envs.models.autopilot import wrap

BANDS = np.array(BAND)
RATES = ("rise_s", "settling_s", "overshoot_pct")
STEADY = ("altitude_steady_error_m", "airspeed_steady_error_m_s", "heading_steady_error_deg")


def errors_of(record, demand):  # type: ignore[no-untyped-def]
    speed = record["speed"] * equivalent_share(record["altitude"])
    error = demand - np.array([record["altitude"], speed, record["heading"]])
    error[2] = wrap(error[2])
    return error


def legs_of(history, dt):  # type: ignore[no-untyped-def]
    """Of one row's records: the legs flown to their ends, (errors from the leg's start on (m, 3), jumps, ramps)."""
    starts = [0, *(np.flatnonzero(np.diff(history["changes"])) + 1)]
    jumps = np.abs(errors_of(history[0], history[0]["demand"]))
    for begin, end in zip(starts, starts[1:], strict=False):
        first = history[begin]
        # at the last instant the record has the next leg's demands already, but is judged by this leg's
        last = first["demand"] + first["demand_rate"] * (end - begin) * dt
        demands = [r["demand"] for r in history[begin:end]] + [last]
        errors = np.array([errors_of(r, d) for r, d in zip(history[begin : end + 1], demands, strict=True)])
        yield errors, jumps, first["demand_rate"] != 0.0
        jumps = np.abs(history[end]["demand"] - last)
        jumps[2] = abs(wrap(history[end]["demand"][2] - last[2]))


def judge(history, dt):  # type: ignore[no-untyped-def]
    """The metrics by their definitions."""
    found = {name: [[], [], []] for name in RATES}
    held, steady = [], []
    for errors, jumps, ramps in legs_of(history, dt):
        length = len(errors) - 1
        if length * dt < 20.0 - 1e-9:
            continue
        tail = errors[-math.ceil(10.0 / dt) :]
        held.append(np.all(np.abs(tail) <= BANDS))
        steady.append(np.abs(tail).mean(axis=0))
        for k in range(3):
            if ramps[k] or jumps[k] <= BANDS[k] or abs(errors[0, k]) <= BANDS[k]:
                continue
            left = np.minimum.accumulate(errors[:, k] / errors[0, k])
            rise = np.argmax(left <= 0.1) - np.argmax(left <= 0.9) if left[-1] <= 0.1 else length
            outside = np.flatnonzero(np.abs(errors[:, k]) > BANDS[k])[-1]
            settling = outside + 1 if outside < length else length
            for name, value in zip(RATES, (rise * dt, settling * dt, 100.0 * max(0.0, -left[-1])), strict=True):
                found[name][k].append(value)
    means = {name: [np.mean(v) if v else 0.0 for v in values] for name, values in found.items()}
    return {**means, "steady": np.mean(steady, axis=0), "held": np.mean(held), "judged": len(held)}


@pytest.mark.parametrize(("law", "dt"), [("square-root", 1.0), ("lecture", 1.0), ("square-root", 0.7)])
def test_metrics_are_what_their_definitions_say(law, dt) -> None:
    n = 12
    world, observations = started({"dt": dt}, n)
    policy = LAWS[law](world.scene)
    policy.reset(n)
    history = [world.states.copy()]
    for _ in range(round(480 / dt)):
        observations = world.step(policy(observations).astype(float), np.ones(n, np.bool_), 10**6)[0]
        history.append(world.states.copy())
    history = np.array(history)
    found = world.metrics(np.arange(n))
    for i in range(n):
        expected = judge(history[:, i], dt)
        for name in RATES:
            for k, channel in enumerate(("altitude", "airspeed", "heading")):
                assert found[f"{channel}_{name}"][i] == pytest.approx(expected[name][k], rel=1e-9), (i, name, channel)
        steady = [found[name][i] for name in STEADY]
        np.testing.assert_allclose(steady, expected["steady"] * [1.0, 1.0, np.degrees(1.0)], rtol=1e-9)
        assert found["legs_held"][i] == pytest.approx(expected["held"])
        assert found["legs_judged"][i] == expected["judged"]
        assert found["is_success"][i] == (expected["held"] == 1.0)
    assert 0.0 < found["legs_held"].mean() < 1.0


def plan_env(**changes):  # type: ignore[no-untyped-def]
    plan = {"time": [0.0, 50.0], "altitude": [1000.0] * 2, "airspeed": [120.0] * 2, "heading": [0.0] * 2, **changes}
    return AutopilotEnv({"base": "lecture", "plan": plan})


def test_a_leg_without_an_end_counts_when_the_episode_ends() -> None:
    env = plan_env()
    env.reset(seed=0)
    for _ in range(50 + 19):
        env.step(np.zeros(3))
    assert env.get_state()["next_change"] == NEVER
    assert env.metrics()["is_success"] and env.get_state()["legs"] == 1
    for _ in range(2):  # away at once: out of band at 21 s of the last leg
        env.step([1.0, 0.0, 0.0])
    assert not env.metrics()["is_success"] and env.metrics()["legs_held"] == 0.5


def test_steady_error_of_a_leg_without_an_end_is_that_of_its_last_10_to_20_seconds() -> None:
    env = plan_env()
    env.reset(seed=0)
    for _ in range(50):
        env.step(np.zeros(3))
    for _ in range(23):  # 1.3 m more in every step; the tail of the other leg has no error
        env.step([0.1, 0.0, 0.0])
    assert env.metrics()["altitude_steady_error_m"] == pytest.approx(0.5 * 1.3 * np.arange(11, 24).mean(), rel=1e-12)


def test_steady_error_of_a_leg_that_ends_at_once_with_the_aircraft_is_that_of_all_of_it() -> None:
    env = plan_env(time=[0.0, 95.0])
    env.reset(seed=0)
    state = env.get_state()
    state["altitude"] = 12.0
    env.set_state(state)
    env.step([-1.0, 0.0, 0.0])
    *_, info = env.step([-1.0, 0.0, 0.0])
    assert info["left_envelope"] and info["altitude_steady_error_m"] == pytest.approx(0.5 * (998.0 + 1008.0))


def test_leaving_the_envelope_fails_the_leg_with_its_whole_length() -> None:
    env = plan_env(time=[0.0, 300.0], altitude=[1000.0, 1000.0])
    env.reset(seed=0)
    state = env.get_state()
    state["demand"][0], state["per_start"][0] = 500.0, -1.0 / 500.0
    env.set_state(state)
    for _ in range(110):  # down through the demand into the ground
        _, _, terminated, _, info = env.step([-1.0, 0.0, 0.0])
        if terminated:
            break
    assert terminated and info["left_envelope"] and not info["is_success"]
    assert info["legs_held"] == 0.0 and info["altitude_settling_s"] == 300.0
    assert info["altitude_rise_s"] == pytest.approx(40.0)
    assert info["altitude_overshoot_pct"] == pytest.approx(100.0)


def test_a_turn_through_the_opposite_heading_is_no_overshoot() -> None:
    env = plan_env(time=[0.0, 20.0, 120.0], altitude=[1000.0] * 3, airspeed=[120.0] * 3,
                   heading=[0.0, math.radians(179.0), math.radians(179.0)])  # fmt: skip
    env.reset(seed=0)
    for _ in range(20):
        env.step(np.zeros(3))
    for _ in range(60):  # the long way: 181 deg to the left
        env.step([0.0, 0.0, -1.0])
    for _ in range(40):  # the last degree
        env.step([0.0, 0.0, -1.0 / 120.0])
    found = env.metrics()
    assert found["heading_overshoot_pct"] == 0.0 and found["heading_settling_s"] == 81.0


def test_short_flights_have_finite_metrics_and_no_success() -> None:
    env = plan_env()
    env.reset(seed=0)
    for found in (env.metrics(), env.step(np.zeros(3)) and env.metrics()):
        assert all(np.isfinite(v) for v in found.values()) and not found["is_success"]


def test_load_factors_and_saturation() -> None:
    env = AutopilotEnv({"turbulence": None, "demands": None, "envelope": None})
    env.reset(seed=0)
    for _ in range(40):
        env.step([0.0, 0.0, 1.0])
    state, found = env.get_state(), env.metrics()
    bank = np.arctan(state["speed"] * state["turn_rate"] / 9.80665)
    assert found["lateral_load_factor"] == pytest.approx(np.tan(bank), rel=1e-9)
    assert found["normal_load_factor"] == pytest.approx(1.0 / np.cos(bank), rel=1e-9)
    assert found["saturated"] == pytest.approx(1.0 / 3.0)
    env.step([1.0, 0.9, 0.0])  # climbing takes all power, the acceleration gives way
    assert env.metrics()["saturated"] == pytest.approx((40 + 2) / 123)
    env.reset(seed=0)
    env.step([1.0, 0.0, 0.0])  # no more than the slew of 1.5 m/s^2
    assert env.metrics()["normal_load_factor"] == pytest.approx(1.0 + 1.5 / 9.80665, rel=1e-12)
