import math

import gymnasium as gym
import numpy as np
import pytest

import vr_envs  # noqa: F401
from vr_envs.envs.scene import resolve
from vr_envs.envs.terrain_ride import TASK, TerrainRideBatchEnv, TerrainRideEnv
from vr_envs.envs.terrain_ride_observation import LIMIT

SOFT = np.array([-1.0, -1.0])


def test_an_undisturbed_ride_is_perfect():
    env = TerrainRideEnv(scene={"undulation": {"amplitude": 0.0}, "road": None, "bumps": None, "stop": None,
                                "payload": None, "noise": None})  # fmt: skip
    observation, _ = env.reset(seed=0)
    for _ in range(20):
        assert not observation.any()
        observation, reward, *_ = env.step(np.zeros(2))
        assert reward == 1.0


def test_reward_is_the_documented_formula():
    env = TerrainRideEnv(scene={"comfort": 0.7, "rattle": 0.02})
    env.reset(seed=2)
    for k in range(200):
        reward = env.step(np.array([math.sin(k / 9), math.cos(k / 7)]))[1]
        s = env.get_state()
        touched = s["side"] != 0 or s["touches"] > 0
        formula = 1 / (1 + (s["weighted"] / 0.7) ** 2 + (s["travel"] / 0.02) ** 2)
        assert reward == pytest.approx(0.0 if touched else formula, rel=1e-14)


def test_a_stop_in_contact_scores_nothing_and_a_crushed_one_ends():
    env = TerrainRideEnv(scene={"road": {"iso_class": "E"}})
    for seed in range(5):
        env.reset(seed=seed)
        terminated, touched, info = False, 0, {}
        while not terminated:
            _, reward, terminated, _, info = env.step(SOFT)
            state = env.get_state()
            if state["side"] != 0.0:
                touched += 1
                assert reward == 0.0
                assert abs(state["travel"]) >= 0.08
            assert terminated == (abs(state["travel"]) > 0.08 + 0.015)
        assert touched and info["stop_hits"] >= 1 and not info["is_success"] and not info["fault"]
        assert info["travel_peak_mm"] == 1e3 * abs(env.get_state()["travel"])


def test_contacts_of_the_fastest_motion_that_a_scene_allows_are_all_followed():
    scene = {"mass": 1.0, "spring_rate": 1e7, "modulus_high": 100.0, "damping_low": 1e-3, "payload": None}
    env = TerrainRideEnv(scene=scene)
    env.reset(seed=0)
    state = env.get_state()
    state["velocity"], state["position"] = 1e4, [-1.0, 1.0]
    env.set_state(state)
    _, reward, terminated, _, info = env.step(np.array([-1.0, 1.0]))
    assert (reward, terminated) == (0.0, True)  # a stop was crushed
    assert info["stop_hits"] > 64 and info["fault"] is False and not info["is_success"]


@pytest.mark.parametrize("stop", [None, {"crush": 10.0}])
def test_a_fault_ends_the_episode_with_or_without_a_stop(stop):
    env = TerrainRideEnv(scene={"base": "quarter-car", "stop": stop})
    env.reset(seed=0)
    state = env.get_state()
    state["fault"] = True
    env.set_state(state)
    _, reward, terminated, _, info = env.step(np.zeros(2))
    assert terminated and reward == 0.0 and info["fault"] and not info["is_success"]


def test_episodes_of_the_default_scene_end_both_ways():
    batch = TerrainRideBatchEnv(64, max_episode_steps=1000)
    batch.reset(seed=0)
    rng = np.random.default_rng(0)
    ends, cuts = 0, 0
    for _ in range(1000):
        _, _, terminated, truncated, _ = batch.step(rng.uniform(-1, 1, (64, 2)))
        ends, cuts = ends + terminated.sum(), cuts + truncated.sum()
    assert 2 <= ends <= 40 and cuts >= 30


def test_metrics_are_those_of_the_path():
    env = gym.make("vr_envs/TerrainRide-v0")
    ride = env.unwrapped
    assert isinstance(ride, TerrainRideEnv)
    env.reset(seed=5)
    weighted, travel, steps, hits = [], [], 0, 0
    truncated = terminated = False
    info = {}
    while not (terminated or truncated):
        _, _, terminated, truncated, info = env.step(np.array([0.6, 0.0]))
        s = ride.get_state()
        weighted.append(s["weighted"])
        travel.append(s["travel"])
        steps += 1
        hits += s["touches"]
    assert truncated and steps == 1000
    assert info["acceleration_rms_m_s2"] == pytest.approx(np.sqrt(np.mean(np.square(weighted))), rel=1e-13)
    assert info["travel_rms_mm"] == pytest.approx(1e3 * np.sqrt(np.mean(np.square(travel))), rel=1e-13)
    assert info["travel_peak_mm"] == 1e3 * np.abs(travel).max()
    assert info["stop_hits"] == hits
    assert info["is_success"] == (hits == 0 and info["acceleration_rms_m_s2"] < 1 and info["travel_rms_mm"] < 30)


@pytest.mark.parametrize("scene", [None, {"payload": None}, {"damping": "absolute"}])
def test_changing_the_modulus_does_not_lift_the_mass(scene):
    """About the levelled equilibrium and without payload; a payload sags by push / w2, however hard the spring."""
    flat = {"road": {"iso_class": "A", "spread": 0.0, "cutoff": 1e-4}, "bumps": None, "lag": None}
    env = TerrainRideEnv(scene={**flat, **(scene or {})})
    env.reset(seed=3)
    payload = float(env.get_state()["payload"])
    for modulus in (-1.0, 1.0):
        travel = []
        for _ in range(1500):
            env.step(np.array([0.8, modulus]))
            travel.append(env.get_state()["travel"])
        sag = payload / (16812 / 290 * 2.0**modulus)
        assert np.mean(travel[300:]) == pytest.approx(sag, abs=1.5e-3)


def test_channels_describe_the_observation():
    for scene in (*TASK.scenes, {"preview": {"samples": 4}}):
        env = TerrainRideEnv(scene=scene)
        resolved = resolve(TASK, scene)
        channels = TASK.observation_channels(resolved)
        observation, _ = env.reset(seed=0)
        assert observation.shape == (len(channels),)
        assert len({c.name for c in channels}) == len(channels)
        for _ in range(300):
            observation, _, terminated, _, _ = env.step(env.action_space.sample())
            assert env.observation_space.contains(observation)
            if terminated:
                env.reset()
    assert [c.name for c in TASK.action_channels(resolve(TASK, "active"))] == ["force"]
    assert [c.name for c in TASK.action_channels(resolve(TASK, "journey"))] == ["damping", "modulus", "speed"]
    assert max(c.high for c in channels) == LIMIT


def test_preview_is_the_road_met_later():
    """Sample i of the preview is the rise of the road by the time of the i-th third knot."""
    scene = {"noise": None, "payload": None}
    env = TerrainRideEnv(scene=scene)
    observation, _ = env.reset(seed=8)
    names = [c.name for c in TASK.observation_channels(resolve(TASK, scene))]
    ahead = observation[names.index("road 0.03 s ahead") :] * 0.05
    state = env.get_state()
    heights = state["knots"]
    assert ahead == pytest.approx(heights[3:31:3] - heights[0], abs=1e-8)
    for k in range(30):
        env.step(np.zeros(2))
        after = env.get_state()
        assert after["knot"] == k + 1
        if k % 3 == 2:
            assert ahead[k // 3] == pytest.approx(after["knots"][(k + 1) % 64] - heights[0], abs=1e-8)


def test_preview_over_sines():
    scene = {"base": "lecture", "preview": True, "speed": 7.0}
    env = TerrainRideEnv(scene=scene)
    observation, _ = env.reset(seed=8)
    early = observation[-10:] * 0.05
    rises, amplitudes = [], 0.04 / ((1 + 5**0.5) / 2) ** np.arange(3)
    for _ in range(30):
        before = env.get_state()
        env.step(np.zeros(2))
        after = env.get_state()
        rises.append(float((amplitudes * (after["wave_sin"] - before["wave_sin"])).sum()))
        assert np.hypot(after["wave_sin"], after["wave_cos"]) == pytest.approx(1.0, rel=1e-14)
    assert early == pytest.approx(np.cumsum(rises)[2::3], abs=1e-8)


def test_sensor_errors_have_the_declared_deviation():
    noisy, clean = (TerrainRideBatchEnv(500, scene={"noise": noise}) for noise in (True, None))
    errors = []
    for env in (noisy, clean):
        env.reset(seed=0)
    for _ in range(10):
        a, b = (env.step(np.zeros((500, 2)))[0] for env in (noisy, clean))
        errors.append(a - b)
    errors = np.concatenate(errors)
    scale = np.array([0.0005 / 0.05, 0.02 / 0.5, 0.02 / 0.5, 0.1 / 2.0])
    assert errors[:, :4].std(axis=0) == pytest.approx(scale, rel=0.04)
    assert np.abs(errors[:, :4]).max() < scale.max() * math.sqrt(3) * 1.001
    assert not errors[:, 4:].any()
    assert np.abs(np.corrcoef(errors[:, :4].T) - np.eye(4)).max() < 0.06


def test_what_a_tyre_and_a_choice_of_speed_add_to_the_observation():
    names = {name: [c.name for c in TASK.observation_channels(resolve(TASK, name))] for name in TASK.scenes}
    plain = names["road"]
    assert len(plain) == 17
    assert names["quarter-car"] == [*plain[:5], "tyre deflection", "hub velocity", *plain[5:]]
    assert names["active"] == [*names["quarter-car"][:7], "force actuator", *plain[7:]]
    assert names["journey"][5:9] == ["speed", "lateness", "damping actuator", "modulus actuator"]
    assert (names["journey"][9], names["journey"][-1]) == ("road 1.2 m ahead", "road 24 m ahead")


def test_sensors_of_the_hub_err_as_declared():
    noisy, clean = (TerrainRideBatchEnv(500, scene={"base": "quarter-car", "noise": noise}) for noise in (True, None))
    errors = []
    for env in (noisy, clean):
        env.reset(seed=0)
    for _ in range(10):
        a, b = (env.step(np.zeros((500, 2)))[0] for env in (noisy, clean))
        errors.append(a - b)
    errors = np.concatenate(errors)
    assert errors[:, 5:7].std(axis=0) == pytest.approx([0.0005 / 0.02, 0.05], rel=0.04)
    assert np.abs(np.corrcoef(errors[:, [0, 1, 2, 3, 5, 6]].T) - np.eye(6)).max() < 0.06
    assert not errors[:, 7:].any()


@pytest.mark.parametrize(
    ("scene", "said"),
    [
        ({"damping_low": 10.0}, "damping_low = 10"),
        ({"modulus_high": 0.4}, "modulus_low = 0.5"),
        ({"bumps": {"low": 0.09}}, "bumps.low = 0.09"),
        ({"bumps": {"longest": 25.0}}, "2 bumps.longest = 50"),
        ({"preview": {"horizon": 1.4}}, "speed \\* preview.horizon = 28"),
        ({"road": None, "undulation": True, "stop": None}, "bumps"),
        ({"undulation": True}, "stop"),
        ({"payload": {"size": 5.0}}, "payload.size over the spring = 0.086"),
        ({"road": None, "bumps": None}, "road = null"),
        ({"mass": -1.0}, "mass = -1.0"),
        ({"actuation": "magic"}, "semi_active, active"),
        ({"road": {"iso_class": "Z"}}, "road.iso_class"),
        ({"sped": 3.0}, "did you mean 'speed'"),
        ({"base": "lecture", "cruise": True}, "cruise = .* over an undulation without a tyre"),
        ({"cruise": True, "damping": "absolute"}, "damping = 'absolute' is not allowed with cruise"),
        ({"cruise": {"slowest": 40.0}}, "cruise.slowest = 40"),
        ({"cruise": {"schedule": 50.0}}, "cruise.schedule = 50"),
        ({"dt": 1e-4}, "dt = 0.0001"),
    ],
)
def test_impossible_scenes_are_refused(scene, said):
    with pytest.raises(ValueError, match=said):
        TerrainRideEnv(scene=scene)


def test_harder_levels_are_harder():
    scores = []
    for level in ("nominal", "light", "severe"):
        env = TerrainRideBatchEnv(100, scene=TASK.levels[level], autoreset_mode="SAME_STEP")
        env.reset(seed=0)
        scores.append(np.mean([env.step(np.tile([0.2, 0.0], (100, 1)))[1].mean() for _ in range(500)]))
    assert scores[0] > scores[1] + 0.05 > scores[2] + 0.1


def test_the_lecture_scene_is_the_lectures_model():
    """v' = k_d v + a dt with absolute h (3.89, 3.90, reading A) converges to the exact ride, first order in dt."""
    env = TerrainRideEnv(scene="lecture")
    env.reset(seed=1)
    start = env.get_state()
    seconds, action = 2.0, np.array([0.4, 0.0])
    for _ in range(int(seconds * 100)):
        env.step(action)
    end, p = env.get_state(), resolve(TASK, "lecture").params
    golden = (1 + 5**0.5) / 2
    gamma = math.exp(p.damping_centre + p.damping_half * 0.4)
    phases = np.arctan2(start["wave_sin"], start["wave_cos"])

    def terrain(t):
        return sum(0.04 / golden**i * math.sin(2 * math.pi / 40 * golden**i * 20.0 * t + phases[i]) for i in range(3))

    errors = []
    for steps in (2000, 4000, 8000):
        dt = seconds / steps
        height, velocity = terrain(0.0), 0.0
        for k in range(steps):
            height += velocity * dt
            velocity = math.exp(-gamma * dt) * velocity - p.w2 * (height - terrain((k + 1) * dt)) * dt
        errors.append(height - terrain(seconds) - end["travel"])
    assert errors[0] / errors[1] == pytest.approx(2.0, abs=0.1)
    assert errors[1] / errors[2] == pytest.approx(2.0, abs=0.1)
    assert abs(errors[2]) < 2e-4


def test_the_observation_shows_the_present_positions_and_the_ride_feels_their_mean():
    env = TerrainRideEnv()
    env.reset(seed=0)
    observation = env.step(np.array([1.0, -1.0]))[0]
    whole = 1 - math.exp(-0.01 / 0.015)
    assert observation[5:7] == pytest.approx([whole, -whole], rel=1e-6)
    mean = 1 - 1.5 * whole
    assert env.get_state()["held"] == pytest.approx([mean, -mean], rel=1e-12)
