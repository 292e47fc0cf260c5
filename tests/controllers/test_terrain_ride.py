"""What holds for every law of the ride."""

import math

import numpy as np
import pytest

from tests.controllers.ride_case import observation, run
from vr_envs.controllers.ladder import ladder, laws_of
from vr_envs.controllers.terrain_ride import BASELINE, LAWS
from vr_envs.controllers.terrain_ride_law import CATCH_UP
from vr_envs.envs.scene import resolve
from vr_envs.envs.terrain_ride import TASK, TerrainRideBatchEnv
from vr_envs.envs.terrain_ride_observation import distances_ahead, read

SCENES = [*TASK.scenes, {"actuation": "active"}, {"preview": None}, {"base": "quarter-car", "damping": "absolute"}]


@pytest.mark.parametrize("scene", SCENES)
def test_actions_are_bounded_over_the_whole_box_and_every_gain(scene):
    resolved = resolve(TASK, scene)
    width = len(TASK.action_channels(resolved))
    rows = np.random.default_rng(0).uniform(-5, 5, (500, len(TASK.observation_channels(resolved)))).astype(np.float32)
    rows[0] = 0
    for law in laws_of(TASK, resolved).values():
        for end in (0, 1, 2):
            policy = law(resolved, **{name: limits[end] for name, limits in law.TUNABLE.items()})
            policy.reset(500)
            actions = policy(rows)
            assert actions.shape == (500, width) and actions.dtype == np.float32
            assert (np.abs(actions) <= 1).all()


@pytest.mark.parametrize("dt", [0.001, 1.0, 10.0])
@pytest.mark.parametrize("scene", ["road", "active"])
def test_laws_can_be_made_for_every_control_interval(scene, dt):
    resolved = resolve(TASK, {"base": scene, "dt": dt})
    rows = np.random.default_rng(0).uniform(-1, 1, (5, len(TASK.observation_channels(resolved)))).astype(np.float32)
    for law in laws_of(TASK, resolved).values():
        policy = law(resolved)
        policy.reset(5)
        assert np.isfinite(policy(rows)).all()


@pytest.mark.parametrize(
    ("scene", "absent"),
    [
        ("road", {"linear-quadratic"}),
        ("quarter-car", {"linear-quadratic"}),
        ({"preview": None}, {"linear-quadratic", "preview"}),
        ("active", {"skyhook-two-state", "sh-add", "clipped-optimal"}),
        ("lecture", set(LAWS) - {BASELINE}),
    ],
)
def test_a_law_is_absent_where_it_makes_no_sense(scene, absent):
    resolved = resolve(TASK, scene)
    assert set(LAWS) - set(laws_of(TASK, resolved)) == absent
    assert set(ladder(TASK, resolved)) & set(LAWS) == set(LAWS) - absent
    assert laws_of(TASK) is LAWS


@pytest.mark.parametrize(
    ("scene", "order"),
    [
        ("road", ["lecture", "sh-add", "skyhook", "clipped-optimal", "preview"]),
        ("active", ["lecture", "skyhook", "linear-quadratic", "preview"]),
    ],
)
def test_the_better_informed_law_wins(scene, order):
    """Paired, by three standard errors and 0.01 at least; sh-add and skyhook are about even."""
    policies = ladder(TASK, resolve(TASK, scene))
    scores = [run(policies[name], scene=scene) for name in order]
    for worse, better, name in zip(scores, scores[1:], order[1:], strict=False):
        gain = better - worse
        if name != "skyhook" or scene != "road":
            assert gain.mean() > max(0.01, 3 * gain.std() / math.sqrt(len(gain))), name


def test_the_best_law_of_a_quarter_car_beats_the_lectures():
    policies = ladder(TASK, resolve(TASK, "quarter-car"))
    gain = run(policies["preview"], scene="quarter-car") - run(policies[BASELINE], scene="quarter-car")
    assert gain.mean() > max(0.05, 3 * gain.std() / math.sqrt(len(gain)))


def test_every_law_keeps_to_the_schedule():
    scene = resolve(TASK, "journey")
    cruise = scene.options["cruise"]
    for law in LAWS.values():
        if law.serves(scene):
            policy = law(scene)
            for share in (0.0, 0.8, -0.8):
                policy.reset(1)
                action, metres = policy(observation(scene, lateness=share))[0, -1], share * cruise.lateness
                speed = cruise.slowest + 0.5 * (action + 1) * (cruise.fastest - cruise.slowest)
                assert speed == pytest.approx(cruise.schedule + metres / CATCH_UP, rel=1e-6)


@pytest.mark.parametrize("scene", ["quarter-car", "journey", "active"])
def test_reading_inverts_the_observation(scene):
    env = TerrainRideBatchEnv(8, scene={"base": scene, "noise": None})
    observations, _ = env.reset(seed=1)
    width = env.action_space.shape[1]
    for _ in range(50):
        observations, *_ = env.step(np.full((8, width), 0.3))
    reading, states = read(observations, env.world.scene), env.get_state()
    names = ["travel", "travel_rate", "velocity", "acceleration", "weighted", "speed"]
    if env.world.scene.options["tyre"] is not None:
        names += ["deflection", "hub_velocity"]
    for name in names:
        assert getattr(reading, name) == pytest.approx(states[name], rel=1e-6, abs=1e-9)
    assert reading.position == pytest.approx(states["position"][:, : reading.position.shape[1]], rel=1e-6)
    cruise = env.world.scene.options["cruise"]
    late = 0.0 if cruise is None else 0.5 * cruise.schedule - states["distance"]
    assert reading.lateness == pytest.approx(late, rel=1e-5, abs=1e-6)
    assert reading.ahead.shape == (8, len(distances_ahead(env.world.scene)))
