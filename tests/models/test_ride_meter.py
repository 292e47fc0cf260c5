"""The meter against the same quantities of a recorded path."""

import numpy as np
import pytest

from vr_envs.envs.terrain_ride import TerrainRideBatchEnv, TerrainRideEnv
from vr_envs.models.constants import G

# without stops no episode ends
SCENES = [*({"base": name, "stop": None} for name in ("quarter-car", "active")), {"damping": "absolute", "lag": None}]


@pytest.mark.parametrize("scene", SCENES)
def test_metrics_are_those_of_the_path(scene):
    env = TerrainRideBatchEnv(4, scene=scene, max_episode_steps=10**6)
    env.reset(seed=2)
    p, tyre = env.world.scene.params, env.world.scene.options["tyre"]
    rng = np.random.default_rng(0)
    path = []
    for k in range(300):
        if k % 20 == 0:
            actions = rng.uniform(-0.5, 0.5, env.action_space.shape)
        env.step(actions)
        path.append(env.get_state())
    column = lambda name: np.array([s[name] for s in path])  # noqa: E731
    found = env.world.metrics(np.arange(4))
    weighted, acceleration, travel = column("weighted"), column("acceleration"), column("travel")
    rms = lambda x: np.sqrt(np.mean(x**2, axis=0))  # noqa: E731
    assert found["acceleration_rms_m_s2"] == pytest.approx(rms(weighted), rel=1e-12)
    assert found["unweighted_rms_m_s2"] == pytest.approx(rms(acceleration), rel=1e-12)
    assert found["vdv_m_s175"] == pytest.approx((0.01 * np.sum(weighted**4, axis=0)) ** 0.25, rel=1e-12)
    changes = np.diff(acceleration, axis=0, prepend=0.0)
    assert found["jerk_rms_m_s3"] == pytest.approx(rms(changes / 0.01), rel=1e-12)
    assert found["travel_rms_mm"] == pytest.approx(1e3 * rms(travel), rel=1e-12)
    assert found["travel_peak_mm"] == pytest.approx(1e3 * np.abs(travel).max(axis=0), rel=1e-12)
    held = column("held")
    if p.active:
        force = p.force * held[:, :, 0]
    else:
        rate = column("travel_rate") if p.relative else column("velocity")
        force = p.mass * np.exp(p.damping_centre + p.damping_half * held[:, :, 0]) * rate
    assert found["force_rms_n"] == pytest.approx(rms(force), rel=1e-9)
    if tyre is None:
        assert (found["tyre_load_rms"] == 0).all() and (found["airborne_fraction"] == 0).all()
    else:
        load = np.maximum(-1.0, -column("deflection") * tyre.rate / ((p.mass + tyre.unsprung_mass) * G))
        assert found["tyre_load_rms"] == pytest.approx(rms(load), rel=1e-12)
        assert found["airborne_fraction"] == pytest.approx(column("airborne_time")[-1] / 3.0, rel=1e-12)
        assert found["airborne_fraction"].max() > 0.0
    assert found["mean_speed_m_s"] == pytest.approx(np.full(4, 20.0))
    assert (found["lateness_m"] == 0.0).all()


@pytest.mark.parametrize("dt", [0.002, 0.05])
def test_no_metric_depends_on_the_control_interval(dt):
    """The same ride in steps of 10 ms and of dt, damping held: the same numbers, but for rounding."""
    shows = []
    for interval in (0.01, dt):
        scene = {"base": "quarter-car", "lag": None, "noise": None, "dt": interval}
        env = TerrainRideBatchEnv(4, scene=scene, max_episode_steps=10**6)
        env.reset(seed=2)
        for _ in range(round(3.0 / interval)):
            env.step(np.full((4, 2), 0.2))
        shows.append(env.world.metrics(np.arange(4)))
    for name, values in shows[0].items():
        assert shows[1][name] == pytest.approx(values, rel=1e-9, abs=1e-12), name


def test_a_ride_that_is_late_earns_less_and_the_meter_says_so():
    env = TerrainRideBatchEnv(2, scene={"base": "journey", "noise": None}, max_episode_steps=10**6)
    env.reset(seed=0)
    p, cruise = env.world.scene.params, env.world.scene.options["cruise"]
    for k in range(200):
        _, rewards, terminated, _, _ = env.step(np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]))
        states = env.get_state()
        late = np.maximum(0.0, cruise.schedule * (k + 1) * 0.01 - states["distance"])
        calm = 1 / (1 + (states["weighted"] / p.comfort) ** 2 + (states["travel"] / p.rattle) ** 2)
        touched = (states["side"] != 0) | (states["touches"] > 0)
        expected = np.where(touched, 0.0, calm / (1 + (late / cruise.lateness) ** 2))
        assert rewards == pytest.approx(expected, rel=1e-12)
        if terminated.any():
            break
    assert late[0] > 5.0 and late[1] == 0.0
    found = env.world.metrics(np.arange(2))
    assert found["lateness_m"] == pytest.approx(late, rel=1e-12)
    assert found["mean_speed_m_s"] == pytest.approx(states["distance"] / (0.01 * (k + 1)), rel=1e-12)
    assert list(found)[:5] == ["is_success", "acceleration_rms_m_s2", "travel_rms_mm", "lateness_m", "stop_hits"]


def test_a_tyre_that_is_never_down_is_off_the_ground_all_the_time_at_any_interval():
    env = TerrainRideEnv(scene={"base": "quarter-car", "dt": 0.0037})
    env.reset(seed=0)
    state = env.get_state()
    state["deflection"], state["airborne"] = 0.5, True
    env.set_state(state)
    for _ in range(5):
        env.step(np.zeros(2))
    assert env.world.metrics(np.arange(1))["airborne_fraction"] == pytest.approx(1.0, rel=1e-12)


def test_a_ride_without_metrics_is_the_same_ride():
    """Observations and rewards need the weighted acceleration alone; nothing is summed, and nothing is told."""
    pair = [TerrainRideBatchEnv(4, {"base": "lecture", "metrics": m}, max_episode_steps=30) for m in (True, None)]
    for env in pair:
        env.reset(seed=1)
    rng = np.random.default_rng(0)
    for _ in range(30):
        actions = rng.uniform(-1.0, 1.0, (4, 2))
        judged, bare = (env.step(actions) for env in pair)
        for one, other in zip(judged[:4], bare[:4], strict=True):
            assert one.tobytes() == other.tobytes()
    assert judged[4]["acceleration_rms_m_s2"].min() > 0.0 and bare[4] == {}
    full, empty = (env.get_state() for env in pair)
    summed = ("ticks", "weighted_squares", "weighted_fourths", "acceleration_squares", "jump_squares",
              "travel_squares", "travel_peak", "force_squares")  # fmt: skip
    for name in full.dtype.names:
        if name in summed:
            assert (full[name] > 0).all() and (empty[name] == 0).all(), name
        elif name != "measured":
            assert full[name].tobytes() == empty[name].tobytes(), name
