"""The autopilot task: demands, score, end of an episode, observation and its inverse, scenes."""

import math

import gymnasium as gym
import numpy as np
import pytest

import vr_envs  # noqa: F401 (registers the ids)
from vr_envs.envs.autopilot import TASK, AutopilotBatchEnv, AutopilotEnv
from vr_envs.envs.autopilot_observation import BAND, SPAN, actions_for, limits, read
from vr_envs.envs.scene import resolve
from vr_envs.envs.world import World
from vr_envs.models.autopilot import wrap

LEVEL = np.zeros(3)


def fly(actions, scene=None, n=200, steps=480):  # type: ignore[no-untyped-def]
    """Records after every step, (steps + 1, n), of a batch under a constant action, none of them reset."""
    world = World(TASK, scene, n)
    observations = np.empty((n, world.widths[0]), np.float32)
    world.reset(np.arange(n), np.arange(n, dtype=np.uint64), observations)
    history, rewards = [world.states.copy()], []
    for _ in range(steps):
        batch = np.broadcast_to(actions, (n, 3)).copy()
        rewards.append(world.step(batch, np.ones(n, np.bool_), 10**6)[1])
        history.append(world.states.copy())
    return np.array(history), np.array(rewards)


@pytest.fixture(scope="module")
def level_flight():
    return fly(LEVEL)[0]


def test_demands_do_not_depend_on_the_flight(level_flight) -> None:
    other = fly(np.array([0.3, 0.1, -1.0]))[0]
    np.testing.assert_array_equal(level_flight["demand"], other["demand"])
    assert np.abs(level_flight["altitude"][-1] - other["altitude"][-1]).min() > 100.0


def test_demands_stay_in_the_operating_range(level_flight) -> None:
    altitude, speed, heading = np.moveaxis(level_flight["demand"], -1, 0)
    assert altitude.min() >= 300.0 and altitude.max() <= 11000.0
    assert speed.min() >= 75.0 and speed.max() <= 250.0
    assert heading.min() >= -math.pi and heading.max() < math.pi


def test_demands_change_every_40_to_120_s(level_flight) -> None:
    changes = level_flight["changes"]
    times = [np.flatnonzero(np.diff(changes[:, i])) + 1 for i in range(changes.shape[1])]
    holds = np.concatenate([np.diff([0, *t]) for t in times])
    assert holds.min() >= 40 and holds.max() <= 120
    assert np.mean(holds) == pytest.approx(80.0, abs=3.0)


def test_three_channels_in_four_change_and_one_change_in_four_is_a_ramp(level_flight) -> None:
    first = level_flight[0]
    start = np.stack([first["altitude"], first["speed"], first["heading"]], axis=1)
    ramping = first["demand_rate"] != 0.0
    changed = ramping | (first["demand"] != start)
    n = changed.size
    assert np.mean(changed) == pytest.approx(0.75, abs=4.0 * math.sqrt(0.75 * 0.25 / n))
    assert np.mean(ramping[changed]) == pytest.approx(0.25, abs=4.0 * math.sqrt(0.25 * 0.75 / (0.75 * n)))
    assert np.all(first["demand"][ramping] == start[ramping])


def test_a_change_is_a_share_of_what_can_be_reached(level_flight) -> None:
    first = level_flight[0]
    size = np.abs(first["demand_target"][:, 1] - first["speed"]) / (0.6 * first["next_change"])
    size = size[size > 0.0]
    assert 0.03 - 1e-12 <= size.min() < 0.1 and 0.5 < size.max() <= 0.6 + 1e-12


def test_a_ramp_is_straight_and_ends_at_its_target(level_flight) -> None:
    first = level_flight[0]
    rows = np.flatnonzero(first["demand_rate"][:, 0] != 0.0)
    assert len(rows) > 20
    for i in rows:
        steps = first["next_change"][i]
        demand = level_flight["demand"][:steps, i, 0]
        np.testing.assert_allclose(np.diff(demand), first["demand_rate"][i, 0], rtol=1e-9)
        last = demand[-1] + first["demand_rate"][i, 0]
        assert last == pytest.approx(first["demand_target"][i, 0], rel=1e-13)


def test_without_the_option_the_demands_stay_what_the_flight_starts_with() -> None:
    history, rewards = fly(LEVEL, {"demands": None, "gust": None}, n=5, steps=50)
    np.testing.assert_array_equal(history["demand"][-1], history["demand"][0])
    np.testing.assert_array_equal(rewards, 1.0)


def test_starts_fill_the_operating_range(level_flight) -> None:
    first = level_flight[0]
    for name, low, high in (("altitude", 300.0, 11000.0), ("speed", 75.0, 250.0), ("heading", -math.pi, math.pi)):
        share = (first[name] - low) / (high - low)
        assert 0.0 <= share.min() < 0.05 and 0.95 < share.max() <= 1.0


def test_reward_is_the_mean_closeness_less_the_cost_of_restless_commands() -> None:
    env = AutopilotEnv({"gust": None, "demands": None})
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
        ([0.0, 1.0, 0.0], {"speed": 290.0, "altitude": 1000.0}, 60),
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
    world = World(TASK, scene, 64)
    observations = np.empty((64, 23), np.float32)
    world.reset(np.arange(64), np.arange(64, dtype=np.uint64), observations)
    rng = np.random.default_rng(0)
    batch = np.zeros((64, 3))
    for _ in range(30):
        earlier, batch = batch, rng.uniform(-1.0, 1.0, (64, 3))
        observations = world.step(batch.copy(), np.ones(64, np.bool_), 10**6)[0]
    s, reading = world.states, read(observations, world.scene)
    error = s["demand"] - np.stack([s["altitude"], s["speed"], s["heading"]], axis=1)
    error[:, 2] = [wrap(e) for e in error[:, 2]]
    rate = np.stack([s["vertical_speed"], s["acceleration"], s["turn_rate"]], axis=1)
    np.testing.assert_allclose(reading.error, error, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(reading.rate, rate, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(reading.demand_rate, s["demand_rate"], rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(reading.speed, s["speed"], atol=1e-4)
    np.testing.assert_allclose(reading.altitude, s["altitude"], atol=2e-3)
    np.testing.assert_allclose(reading.action, batch, atol=1e-7)
    np.testing.assert_allclose(reading.earlier_action, earlier, atol=1e-7)
    lags = np.array([2.5, 3.5, 1.8]) if scene == "airliner" else np.zeros(3)
    lead = error - lags * (rate - s["demand_rate"])
    ahead = lead / (np.array(BAND) + np.abs(lead))
    np.testing.assert_allclose(observations[:, 6:9], ahead, rtol=1e-5, atol=1e-6)
    near = error / (np.array(BAND) + np.abs(error))
    np.testing.assert_allclose(observations[:, 3:6], near, atol=1e-6)


def test_errors_beyond_the_scale_are_clipped_to_the_box() -> None:
    env = AutopilotEnv({"ceiling": 20000.0, "altitude_high": 20000.0, "demands": None})
    env.reset(seed=0)
    state = env.get_state()
    state["altitude"], state["demand"][0] = 1.0, 19000.0
    env.set_state(state)
    observation = env.step(LEVEL)[0]
    assert observation[0] == 1.0
    assert read(observation[None], env.world.scene).error[0, 0] == pytest.approx(SPAN[0], rel=1e-12)


def test_actions_for_undoes_the_scaling_of_the_action() -> None:
    world = World(TASK, {"lags": None, "gust": None, "energy": None}, 32)
    observations = np.empty((32, 23), np.float32)
    world.reset(np.arange(32), np.arange(32, dtype=np.uint64), observations)
    reading = read(observations, world.scene)
    falling, rising = limits(reading, world.scene)
    shares = np.random.default_rng(0).uniform(-1.0, 1.0, (32, 3))
    rates = np.where(shares > 0.0, rising, falling) * shares
    np.testing.assert_allclose(actions_for(rates, reading, world.scene), shares, rtol=1e-14)
    world.step(shares.copy(), np.ones(32, np.bool_), 10**6)
    flown = np.stack([world.states[name] for name in ("vertical_speed", "acceleration", "turn_rate")], axis=1)
    np.testing.assert_allclose(flown, rates, rtol=1e-5)
    np.testing.assert_array_equal(
        actions_for(1e3 * np.where(shares > 0.0, rising, -falling), reading, world.scene), np.sign(shares)
    )


@pytest.mark.parametrize(("offset", "success"), [((14.0, 0.9, 0.4), True), ((30.0, -2.0, 1.5), False)])
def test_metrics_are_means_over_the_episode(offset, success) -> None:
    env = AutopilotEnv({"gust": None, "demands": None})
    env.reset(seed=3)
    state = env.get_state()
    state["heading"] = 3.1  # the demand lies beyond the wrap
    start = state["altitude"], state["speed"], state["heading"]
    state["demand"] = start[0] + offset[0], start[1] + offset[1], wrap(start[2] + math.radians(offset[2]))
    env.set_state(state)
    for _ in range(20):
        env.step(LEVEL)
    found = {name: values[0] for name, values in env.world.metrics(np.zeros(1, int)).items()}
    errors = found["altitude_error_m"], found["airspeed_error_m_s"], found["heading_error_deg"]
    assert errors == pytest.approx(np.abs(offset), rel=1e-10)
    assert found["time_in_band"] == float(success) and found["is_success"] == success
    assert found["movement"] == 0.0 and not found["left_envelope"]
    env.step([0.3, 0.3, -0.3])
    assert env.world.metrics(np.zeros(1, int))["movement"][0] == pytest.approx(0.3 / 21, rel=1e-13)


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        ({"altitude_low": 9000.0, "altitude_high": 8000.0}, "altitude_low = 9000 .*altitude_high = 8000"),
        ({"speed_high": 350.0}, "speed_high = 350 .*top_speed = 300"),
        ({"speed_low": 50.0}, "stall_speed = 60 .*speed_low = 50"),
        ({"demands": {"hold_low": 200.0}}, "hold_low = 200 .*hold_high = 120"),
        ({"lags": {"vertical": -1.0}}, "lags.vertical = -1.0"),
        ({"gusts": True}, "did you mean 'gust'"),
    ],
)
def test_impossible_scenes_are_refused(scene, message) -> None:
    with pytest.raises(ValueError, match=message):
        AutopilotEnv(scene)


def test_the_ground_track_is_there_where_the_scene_has_it() -> None:
    assert AutopilotEnv("lecture").world.scene.options["track"] is not None
    with_track, _ = fly(np.array([0.0, 0.0, 0.2]), {"track": {"x": 50.0}}, n=3, steps=60)
    without, _ = fly(np.array([0.0, 0.0, 0.2]), None, n=3, steps=60)
    assert np.all(with_track["x"][0] == 50.0) and np.all(without["x"] == 0.0)
    assert np.all(np.hypot(with_track["x"][-1] - 50.0, with_track["z"][-1]) > 1000.0)
    for name in ("altitude", "speed", "heading"):
        np.testing.assert_array_equal(with_track[name], without[name])


def test_levels_blow_harder() -> None:
    strengths = [
        resolve(TASK, {**level, "base": "airliner"}).options["gust"].vertical for level in TASK.levels.values()
    ]
    assert strengths == [0.7, 1.5, 3.0]


def test_a_control_interval_of_another_length_flies_the_same_demand_times() -> None:
    quick = AutopilotBatchEnv(50, {"dt": 0.5})
    slow = AutopilotBatchEnv(50)
    quick.reset(options={"scenario": 7})
    slow.reset(options={"scenario": 7})
    difference = quick.get_state()["next_change"] * 0.5 - slow.get_state()["next_change"]
    assert np.abs(difference).max() <= 0.5
