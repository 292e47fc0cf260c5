"""The autopilot task: demands, score, end of an episode, observation and its inverse, scenes."""

import math

import gymnasium as gym
import numpy as np
import pytest

import vr_envs  # noqa: F401 (registers the ids)
from tests.envs.autopilot_flight import LEVEL, fly, started
from vr_envs.envs.autopilot import TASK, AutopilotEnv
from vr_envs.envs.autopilot_observation import BAND, SPAN, actions_for, limits, read
from vr_envs.envs.scene import resolve
from vr_envs.evaluation.scenarios import at_level
from vr_envs.models.atmosphere import airspeed_of_mach, airspeed_rate, equivalent_share
from vr_envs.models.autopilot import wrap


def test_starts_fill_the_operating_range() -> None:
    """Airspeeds from the lowest to the highest that can be flown at the altitude."""
    first = started()[0].states
    highest = [min(160.0, airspeed_of_mach(0.79, h)) for h in first["altitude"]]
    share = [equivalent_share(h) for h in first["altitude"]]
    shares = {
        "altitude": (first["altitude"] - 300.0) / 10700.0,
        "speed": (first["speed"] * share - 75.0) / (np.array(highest) - 75.0),
        "heading": first["heading"] / (2.0 * math.pi) + 0.5,
    }
    for values in shares.values():
        assert 0.0 <= values.min() < 0.05 and 0.95 < values.max() <= 1.0


def test_reward_is_the_mean_closeness_less_the_cost_of_restless_commands() -> None:
    env = AutopilotEnv({"atmosphere": None, "turbulence": None, "demands": None})
    env.reset(seed=3)
    state = env.get_state()
    state["demand"] = state["altitude"] + 30.0, state["speed"] - 1.0, wrap(state["heading"] + math.radians(1.5))
    env.set_state(state)
    reward = env.step(LEVEL)[1]
    assert reward == pytest.approx((1 / 3 + 1 / 2 + 1 / 4) / 3, rel=1e-13)
    env.set_state(state)
    reward = env.step([0.0, 0.0, 0.6])[1]
    after = env.get_state()
    turned = abs(wrap(after["demand"][2] - after["heading"]))
    closeness = (1 / 3 + 1 / 2 + 1 / (1 + turned / BAND[2])) / 3
    assert reward == pytest.approx(closeness * (1 - 0.1 * 0.2 / 0.5), rel=1e-13)


@pytest.mark.parametrize(
    ("action", "start", "limit"),
    [
        ([-1.0, 0.0, 0.0], {"altitude": 400.0}, 60),
        ([0.0, -1.0, 0.0], {"speed": 80.0}, 60),
        ([0.0, 1.0, 0.0], {"speed": 180.0, "altitude": 1000.0}, 60),
        ([1.0, 0.0, 0.0], {"altitude": 12900.0}, 60),
    ],
)
def test_leaving_the_envelope_ends_the_episode_without_reward(action, start, limit) -> None:
    env = AutopilotEnv()
    env.reset(seed=1)
    state = env.get_state()
    for name, value in start.items():
        state[name] = value
    env.set_state(state)
    for _ in range(limit):
        observation, reward, terminated, _, info = env.step(action)
        if terminated:
            break
    assert terminated and reward == 0.0
    assert info["left_envelope"] and not info["is_success"]
    assert observation in env.observation_space


def test_bad_constant_actions_end_registered_episodes_early_and_good_ones_do_not() -> None:
    env = gym.make_vec("vr_envs/Autopilot-v1", num_envs=64)
    env.reset(seed=0)
    ends = np.zeros((2, 64), bool)
    for _ in range(480):
        _, _, terminated, truncated, _ = env.step(np.tile([[0.0, -1.0, 0.0], [0.0, 0.0, 0.0]], (32, 1)))
        ends |= terminated, truncated
    assert ends[0, 0::2].all() and not ends[0, 1::2].any() and ends[1, 1::2].all()


@pytest.mark.parametrize("scene", ["airliner", "lecture"])
def test_a_controller_reads_from_the_observation_what_the_record_says(scene) -> None:
    world, observations = started(scene, 64)
    rng = np.random.default_rng(0)
    batch = np.zeros((64, 3))
    for _ in range(30):
        earlier, batch = batch, rng.uniform(-1.0, 1.0, (64, 3))
        observations = world.step(batch.copy(), np.ones(64, np.bool_), 10**6)[0]
    s, reading = world.states, read(observations, world.scene)
    thin = scene == "airliner"
    speed = s["speed"] * (np.array([equivalent_share(h) for h in s["altitude"]]) if thin else 1.0)
    error = s["demand"] - np.stack([s["altitude"], speed, s["heading"]], axis=1)
    error[:, 2] = [wrap(e) for e in error[:, 2]]
    rate = np.stack([s["vertical_speed"], s["acceleration"], s["turn_rate"]], axis=1)
    np.testing.assert_allclose(reading.error, error, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(reading.rate, rate, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(reading.demand_rate, s["demand_rate"], rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(reading.speed, speed, atol=1e-4)
    np.testing.assert_allclose(reading.true_speed, s["speed"], atol=1e-3)
    np.testing.assert_allclose(reading.altitude, s["altitude"], atol=2e-3)
    np.testing.assert_allclose(reading.action, batch, atol=1e-7)
    np.testing.assert_allclose(reading.earlier_action, earlier, atol=1e-7)
    change = rate.copy()
    if thin:
        change[:, 1] = [
            airspeed_rate(h, v, climb, a, True)
            for h, v, (climb, a, _) in zip(s["altitude"], speed, rate, strict=True)
        ]  # fmt: skip
    lags = np.array([2.5, 3.5, 1.8]) if thin else np.zeros(3)
    lead = error - lags * (change - s["demand_rate"])
    ahead = lead / (np.array(BAND) + np.abs(lead))
    np.testing.assert_allclose(observations[:, 6:9], ahead, rtol=1e-5, atol=1e-6)
    near = error / (np.array(BAND) + np.abs(error))
    np.testing.assert_allclose(observations[:, 3:6], near, atol=1e-6)


def test_errors_beyond_the_scale_are_clipped_to_the_box() -> None:
    env = AutopilotEnv({"ceiling": 20000.0, "demands": None})
    env.reset(seed=0)
    state = env.get_state()
    state["altitude"], state["demand"][0] = 1.0, 19000.0
    env.set_state(state)
    observation = env.step(LEVEL)[0]
    assert observation[0] == 1.0
    assert read(observation[None], env.world.scene).error[0, 0] == pytest.approx(SPAN[0], rel=1e-12)


def test_a_state_that_turns_faster_than_any_scene_allows_is_refused() -> None:
    """Its ground track would be integrated over as many pieces as it turns radians."""
    env = AutopilotEnv("lecture")
    env.reset(seed=0)
    state = env.get_state()
    state["turn_rate"] = 1e12
    with pytest.raises(ValueError, match="'turn_rate' is not in .-2, 2.; give what get_state"):
        env.set_state(state)


def test_actions_for_undoes_the_scaling_of_the_action() -> None:
    world, observations = started({"lags": None, "turbulence": None, "energy": None}, 32)
    reading = read(observations, world.scene)
    falling, rising = limits(reading, world.scene)
    shares = np.random.default_rng(0).uniform(-1.0, 1.0, (32, 3))
    rates = np.where(shares > 0.0, rising, falling) * shares
    np.testing.assert_allclose(actions_for(rates, falling, rising), shares, rtol=1e-6)
    world.step(shares.copy(), np.ones(32, np.bool_), 10**6)
    flown = np.stack([world.states[name] for name in ("vertical_speed", "acceleration", "turn_rate")], axis=1)
    np.testing.assert_allclose(flown, rates, rtol=1e-5)
    beyond = 1e3 * np.where(shares > 0.0, rising, -falling)
    np.testing.assert_array_equal(actions_for(beyond, falling, rising), np.sign(shares))


@pytest.mark.parametrize(("offset", "inside"), [((14.0, 0.9, 0.4), True), ((30.0, -2.0, 1.5), False)])
def test_metrics_are_means_over_the_episode(offset, inside) -> None:
    env = AutopilotEnv({"atmosphere": None, "turbulence": None, "demands": None})
    env.reset(seed=3)
    state = env.get_state()
    state["heading"] = 3.1  # the demand lies beyond the wrap
    start = state["altitude"], state["speed"], state["heading"]
    state["demand"] = start[0] + offset[0], start[1] + offset[1], wrap(start[2] + math.radians(offset[2]))
    env.set_state(state)
    for _ in range(20):
        env.step(LEVEL)
    found = env.metrics()
    errors = found["altitude_error_m"], found["airspeed_error_m_s"], found["heading_error_deg"]
    assert errors == pytest.approx(np.abs(offset), rel=1e-10)
    assert found["time_in_band"] == float(inside) and found["is_success"] == inside
    assert found["movement"] == 0.0 and not found["left_envelope"]
    env.step([0.3, 0.3, -0.3])
    assert env.metrics()["movement"] == pytest.approx(0.3 / 21, rel=1e-13)


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        ({"altitude_low": 9000.0, "altitude_high": 8000.0}, "altitude_low = 9000 .*altitude_high = 8000"),
        ({"speed_high": 350.0}, "speed_high = 350 .*top_speed = 185"),
        (
            {"altitude_high": 18000.0, "ceiling": 20000.0},
            "speed_low = 75 .*be below the airspeed of atm",
        ),
        # a demand at the edge of the envelope would have to be missed
        ({"altitude_high": 13000.0}, "altitude_high = 13000 .*be below ceiling = 13000"),
        ({"speed_high": 185.0}, "speed_high = 185 .*be below top_speed = 185"),
        ({"atmosphere": {"mach_high": 0.9}}, "mach_high = 0.9 .*be below atmosphere.top_mach = 0.86"),
        ({"altitude_low": 0.0}, "altitude_low = 0"),
        ({"demands": {"hold_low": 2.0}, "dt": 5.0}, "dt = 5 .*not exceed demands.hold_low = 2"),
        ({"speed_low": 50.0}, "stall_speed = 60 .*speed_low = 50"),
        ({"demands": {"hold_low": 200.0}}, "hold_low = 200 .*hold_high = 120"),
        ({"lags": {"vertical": -1.0}}, "lags.vertical = -1.0"),
        ({"turbulent": True}, "did you mean 'turbulence'"),
    ],
)
def test_impossible_scenes_are_refused(scene, message) -> None:
    with pytest.raises(ValueError, match=message):
        AutopilotEnv(scene)


def test_the_ground_track_is_there_where_the_scene_has_it() -> None:
    assert AutopilotEnv("lecture").world.scene.options["track"] is not None
    turn, calm = np.array([0.0, 0.0, 0.2]), {"turbulence": None}
    with_track, _ = fly(turn, {**calm, "track": {"x": 50.0}}, n=3, steps=60)
    without, _ = fly(turn, calm, n=3, steps=60)
    assert np.all(with_track["x"][0] == 50.0) and np.all(without["x"] == 0.0)
    assert np.all(np.hypot(with_track["x"][-1] - 50.0, with_track["z"][-1]) > 1000.0)
    for name in ("altitude", "speed", "heading"):
        np.testing.assert_array_equal(with_track[name], without[name])


@pytest.mark.parametrize("scene", ["airliner", "airliner-rough"])
def test_levels_blow_harder(scene) -> None:
    strengths = [at_level(TASK, resolve(TASK, scene), level).options["turbulence"].sigma for level in TASK.levels]
    assert strengths == sorted(set(strengths)) and strengths[1:] == [1.5, 3.0]
    assert [resolve(TASK, scene).options["demands"] is None for scene in TASK.scenes] == [False] * 3


def test_the_rough_scene_has_every_disturbance() -> None:
    absent = {name for name, option in resolve(TASK, "airliner-rough").options.items() if option is None}
    assert absent == {"plan", "textbook"}
