import math

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from scipy.stats import kstest

import vr_envs  # noqa: F401
from vr_envs.controllers.bell_sink import parabolic_action
from vr_envs.controllers.ladder import baseline_of, ladder
from vr_envs.envs.ball_on_bar import TASK, BallOnBarBatchEnv, BallOnBarEnv
from vr_envs.envs.ball_on_bar_observation import FALL_SCALE, HEIGHT_SCALE, SPEED_SCALE
from vr_envs.envs.scene import resolve
from vr_envs.evaluation.rollout import rollout
from vr_envs.evaluation.scenarios import scenario_set
from vr_envs.models.ball_on_bar import LOGGED

ID = "vr_envs/BallOnBar-v0"
SOURCE, SINK = (parabolic_action(resolve(TASK), 4.0, 50.0, 8.0, sign * 0.5 * math.pi) for sign in (-1, 1))


def impacts_of(env, action):
    """The impacts of the next cycle under `action` as the model logs them, found on a copy of the state."""
    log = np.zeros((1000, len(LOGGED)))
    states = np.array([env.get_state()])
    before = int(states["impacts"][0])
    TASK.advance(states[0], np.clip(np.asarray(action, float), -1.0, 1.0), env.world.params, *env.world.options, log)
    return log[before : int(states["impacts"][0])]


@pytest.mark.parametrize(("scene", "width"), [(None, 0.002), ({"reward_width": 0.005}, 0.005), ("rolling", 0.002)])
def test_reward_is_the_documented_formula(scene, width):
    env = BallOnBarEnv(scene=scene)
    env.reset(seed=1)
    rewards = []
    for _ in range(60):
        _, reward, terminated, _, _ = env.step(SINK)
        assert not terminated
        assert reward == pytest.approx(1.0 / (1.0 + (env.get_state()["x"] / width) ** 2), rel=1e-14)
        rewards.append(reward)
    assert np.ptp(rewards) > 0.1


def test_a_ball_thrown_out_ends_the_episode_with_nothing():
    env = gym.make(ID)
    ball = env.unwrapped
    assert isinstance(ball, BallOnBarEnv)
    for seed in range(5):
        env.reset(seed=seed)
        terminated, info = False, {}
        while not terminated:
            assert info == {}
            _, reward, terminated, truncated, info = env.step(SOURCE)
            assert not truncated
            assert terminated == bool(ball.get_state()["lost"])
            assert (reward == 0.0) == terminated
        assert info["on_bar"] is False and info["is_success"] is False and info["fault"] is False
        # the plane of the bar is met beyond its ends: near 25 mm, for the bar itself moves by less than 2 mm
        assert abs(ball.get_state()["x"]) > 0.023
        with pytest.raises(ResetNeeded):
            env.step(SOURCE)


@pytest.mark.parametrize("scene", ["bell", "rolling", {"hold": 0.5}, {"hold": 3.0}], ids=str)
def test_metrics_are_those_of_the_path(scene):
    env = gym.make(ID, scene=scene)
    ball = env.unwrapped
    assert isinstance(ball, BallOnBarEnv)
    rng = np.random.default_rng(0)
    for seed in range(4):
        env.reset(seed=seed)
        places, impacts, info = [], 0, {}
        while not info:
            action = SINK + rng.uniform(-0.2, 0.2, 6)
            impacts += len(impacts_of(ball, action))
            info = env.step(action)[-1]
            places.append(ball.get_state()["x"])
        assert info["rms_x_mm"] == pytest.approx(1e3 * np.sqrt(np.mean(np.square(places))), rel=1e-13)
        assert info["max_x_mm"] == 1e3 * np.abs(places).max()
        assert info["impacts_per_cycle"] == impacts / (len(places) * ball.world.scene.params.hold) > 1.0
        assert info["on_bar"] == (len(places) == 150)
        assert info["is_success"] == (info["on_bar"] and info["rms_x_mm"] <= 2.0)


@pytest.mark.parametrize(("rms_mm", "flag", "success"), [
    (1.999999, None, True), (2.000001, None, False), (0.5, "lost", False), (0.5, "fault", False),
])  # fmt: skip
def test_success_is_an_rms_of_two_millimetres_on_the_bar(rms_mm, flag, success):
    env = BallOnBarEnv()
    env.reset(seed=0)
    state = env.get_state()
    state["steps"], state["sum_x2"] = 150, 150 * (1e-3 * rms_mm) ** 2
    if flag:
        state[flag] = 1
    env.set_state(state)
    metrics = env.metrics()
    assert metrics["is_success"] is success
    assert metrics["on_bar"] is (flag is None)
    assert metrics["rms_x_mm"] == pytest.approx(rms_mm, rel=1e-14)


def starts(scene=None, n=3000):
    env = BallOnBarBatchEnv(n, scene=scene)
    env.reset(options={"scenario": list(range(n))})
    return env.get_state()


@pytest.mark.parametrize(("scene", "low", "high"), [
    (None, 0.003, 0.015), ({"start_min": 0.0, "start_max": 0.02}, 0.0, 0.02), ("rolling", 0.003, 0.015),
])  # fmt: skip
def test_starts_are_uniform_on_both_sides(scene, low, high):
    x = starts(scene)["x"]
    assert low <= np.abs(x).min() < np.abs(x).max() <= high
    assert kstest(np.abs(x), "uniform", (low, high - low)).pvalue > 0.01
    right = np.abs(x[x > 0])
    assert abs(len(right) / len(x) - 0.5) < 3 * 0.5 / math.sqrt(len(x))
    assert kstest(right, "uniform", (low, high - low)).pvalue > 0.01


@pytest.mark.parametrize("values", [{}, {"z_acceleration": 5.0, "restitution": 0.8}, {"frequency": 25.0}])
def test_the_start_lies_on_the_period_one_orbit(values):
    """Luck and Mehta: cos(phase) = pi g (1 - alpha) / (1 + alpha) / Acc at every impact, two of them a cycle."""
    env = BallOnBarEnv(scene={"scatter": None, **values})
    env.reset(seed=3)
    first, p = env.get_state(), env.world.scene.params
    assert first["u"] == 0.0 and first["spin"] == 0.0
    cosine = math.pi * p.gravity * (1 - p.restitution) / (1 + p.restitution) / p.z_acceleration
    for _ in range(10):
        impacts = impacts_of(env, np.zeros(6))
        assert len(impacts) == 2
        phases = np.mod(2 * p.omega * impacts[:, 0] + math.pi / 2, 2 * math.pi)
        assert phases == pytest.approx(math.acos(cosine), abs=1e-11)
        env.step(np.zeros(6))
        state = env.get_state()
        assert state["x"] == first["x"]
        assert state["z"] == pytest.approx(first["z"], abs=1e-13)
        assert state["w"] == pytest.approx(first["w"], abs=1e-12)


@pytest.mark.parametrize("acceleration", [0.0, 2.0])
def test_a_bar_too_slow_for_the_orbit_still_has_a_start(acceleration):
    env = BallOnBarEnv(scene={"scatter": None, "z_acceleration": acceleration})
    observation, _ = env.reset(seed=0)
    for _ in range(30):
        assert env.observation_space.contains(observation)
        observation, reward, terminated, *_ = env.step(np.zeros(6))
        assert reward > 0.0 and not terminated


@pytest.mark.parametrize(
    ("scene", "said"),
    [
        ({"start_min": 0.016}, "start_min = 0.016, start_max = 0.015"),
        ({"start_max": 0.025}, "give start_min <= start_max < half_length"),
        ({"half_length": 0.015}, "half_length = 0.015"),
        ({"tilt_acceleration": 2700.0}, "tilt_acceleration = 2700 rad/s.2 at frequency = 15 Hz .* at most 0.3 rad"),
        ({"frequency": 2.0}, "frequency = 2 Hz is a tilt of 0.633 rad"),
        ({"restitution": 1.2}, "restitution = 1.2"),
        ({"spin": {"radius": 0.0}}, "spin.radius = 0.0"),
        ({"spni": True}, "did you mean 'spin'"),
        ({"hold": 0.75}, "hold = 0.75 cycles; give 0.5 or a whole number"),
        ({"hold": 0.5, "blend": 0.6}, "give blend <= hold"),
        ({"curve": {"curvature": 50.0}}, "steeper than 45 degrees; give at most 40 1/m"),
        ({"sensing": {"delay": 0.07}}, "sensing looks 0.07 s before .* at most 0.06667 s"),
        ({"camera": {"frame_rate": 10.0}}, "camera looks 0.102 s before"),
        ({"camera": {"height": 10.0}}, "the ball at rest is not in the picture of 256 x 160 pixels"),
        ({"camera": True, "sensing": True}, "sensing and camera exclude each other"),
    ],
)
def test_impossible_scenes_are_refused(scene, said):
    with pytest.raises(ValueError, match=said):
        BallOnBarEnv(scene=scene)


def test_the_tilt_bound_is_the_one_named():
    assert BallOnBarEnv(scene={"tilt_acceleration": 2664.0}).world.scene.params.tilt_span < 0.3


def channels_of(scene):
    return [c.name for c in TASK.observation_channels(resolve(TASK, scene))]


@pytest.mark.parametrize("scene", [None, "rolling", {"half_length": 0.04, "z_acceleration_span": 2.0}])
def test_every_channel_is_its_quantity_over_its_scale(scene):
    env = BallOnBarEnv(scene=scene)
    p, names = env.world.scene.params, channels_of(scene)
    spins = env.world.scene.options["spin"] is not None
    assert len(names) == len(set(names)) == (11 if spins else 10)
    assert env.observation_space.shape == (len(names),)
    rng = np.random.default_rng(5)
    seen, action = [], None
    observation, _ = env.reset(seed=2)
    for _ in range(40):
        s = env.get_state()
        expected = {
            "x": s["x"] / p.half_length,
            "x velocity": s["u"] / SPEED_SCALE,
            "z": s["z"] / HEIGHT_SCALE,
            "z velocity": s["w"] / FALL_SCALE,
            "x in phase": s["motion"][0] / p.x_span,
            "x quadrature": s["motion"][1] / p.x_span,
            "tilt in phase": s["motion"][2] / p.tilt_span,
            "tilt quadrature": s["motion"][3] / p.tilt_span,
            "z in phase": (s["motion"][4] - p.z_centre) / p.z_span,
            "z quadrature": s["motion"][5] / p.z_span,
        }
        if spins:
            expected["spin"] = s["spin"] / SPEED_SCALE
        assert list(expected) == names
        assert observation == pytest.approx(np.clip(list(expected.values()), -1.0, 1.0), abs=1e-7)
        # the bar's motion is shown as the action that asked for it; at the start, as no action
        assert observation[4:10] == pytest.approx(np.zeros(6) if action is None else action, abs=1e-7)
        seen.append(observation)
        action = SINK + rng.uniform(-0.3, 0.3, 6)
        observation, _, terminated, _, _ = env.step(action)
        if terminated:
            observation, _ = env.reset()
            action = None
    assert (np.std(seen, axis=0) > 1e-3).all()


@pytest.mark.parametrize(
    ("field", "channel"), [("x", "x"), ("u", "x velocity"), ("z", "z"), ("w", "z velocity"), ("spin", "spin")]
)
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_channel_is_clipped_at_its_range(field, channel, sign):
    env = BallOnBarEnv(scene="rolling")
    env.reset(seed=0)
    state = env.get_state()
    state[field] = sign * 3.0
    observation, _ = env.reset(options={"state": state})
    assert observation[channels_of("rolling").index(channel)] == sign
    assert env.observation_space.contains(observation)


@pytest.mark.parametrize(
    ("span", "channels"), [("x_acceleration", [4, 5]), ("tilt_acceleration", [6, 7]), ("z_acceleration_span", [8, 9])]
)
def test_a_motion_without_a_range_shows_as_nothing(span, channels):
    env = BallOnBarEnv(scene={span: 0.0})
    observation, _ = env.reset(seed=0)
    others = [k for k in range(4, 10) if k not in channels]
    for _ in range(5):
        assert np.isfinite(observation).all() and not observation[channels].any()
        observation, *_ = env.step(np.full(6, 0.25))
        assert observation[others] == pytest.approx(0.25, abs=1e-7)
    assert not observation[channels].any()


def test_harder_levels_are_harder():
    means = []
    for level in ("nominal", "light", "severe"):
        scenarios = scenario_set(ID, level=level, n=100)
        policy = ladder(TASK, scenarios.scene)[baseline_of(TASK)]
        means.append(rollout(policy, scenarios).scores.mean())
    assert means[0] > means[1] + 0.02 > means[2] + 0.1


def test_actions_beyond_the_box_are_clipped():
    wild, tame = (BallOnBarEnv(scene="rolling") for _ in range(2))
    rng = np.random.default_rng(0)
    for env in (wild, tame):
        env.reset(options={"scenario": 4})
    beyond = 0
    for _ in range(20):
        action = rng.uniform(-2.0, 2.0, 6)
        beyond += (np.abs(action) > 1.0).sum()
        wild.step(action)
        terminated = tame.step(np.clip(action, -1.0, 1.0))[2]
        assert wild.get_state().tobytes() == tame.get_state().tobytes()
        if terminated:
            break
    assert beyond >= 10
