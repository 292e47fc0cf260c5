import numpy as np
import pytest

from vr_envs.controllers.ladder import baseline_of, ladder
from vr_envs.envs.registry import ids, spec_of, task_of
from vr_envs.envs.scene import resolve
from vr_envs.evaluation.rollout import episode
from vr_envs.models.ball_on_bar import LOGGED, advance
from vr_envs.render import TASKS, painter

SCENES = [(env_id, name) for env_id in ids() for name in task_of(env_id).scenes]
KEY = 20260801


def episode_of(env_id, scene=None, policy=None, steps=40):
    task = task_of(env_id)
    resolved = resolve(task, scene)
    law = ladder(task, resolved)[policy or baseline_of(task)]
    return resolved, list(episode(law, task, resolved, KEY, steps))


def test_every_registered_task_has_pictures():
    assert {task_of(env_id).name for env_id in ids()} == set(TASKS)


@pytest.mark.parametrize(("env_id", "scene"), SCENES)
def test_a_picture_shows_the_state_and_repeats_to_the_byte(env_id, scene):
    resolved, states = episode_of(env_id, scene, "random")
    name = task_of(env_id).name
    first, middle, again = (painter(name, resolved, "rgb_array").draw(states[k]) for k in (0, 20, 20))
    assert first.shape == (400, 640, 3) and first.dtype == np.uint8
    # the paper is one colour; a picture is neither blank nor full
    share = np.mean(np.any(first != first[0, 0], axis=-1))
    assert 0.03 < share < 0.6
    assert np.mean(np.any(first != middle, axis=-1)) > 0.002
    assert middle.tobytes() == again.tobytes()


@pytest.mark.parametrize(("env_id", "scene"), SCENES)
def test_a_painter_does_not_change_the_state(env_id, scene):
    resolved, states = episode_of(env_id, scene, "random", 3)
    artist = painter(task_of(env_id).name, resolved, "rgb_array")
    before = [s.tobytes() for s in states]
    for state in states:
        artist.draw(state)
    assert [s.tobytes() for s in states] == before


@pytest.mark.parametrize("env_id", ids())
def test_going_back_starts_afresh(env_id):
    resolved, states = episode_of(env_id)
    artist = painter(task_of(env_id).name, resolved, "rgb_array")
    first = artist.draw(states[0])
    for state in states[1:]:
        artist.draw(state)
    assert artist.draw(states[0]).tobytes() == first.tobytes()
    # another episode that is farther on
    other = states[-1].copy()
    other["key"] += 1
    for state in states[:-1]:
        artist.draw(state)
    assert artist.draw(other).tobytes() == painter(task_of(env_id).name, resolved, "rgb_array").draw(other).tobytes()


@pytest.mark.filterwarnings("error::RuntimeWarning")
@pytest.mark.parametrize(
    ("env_id", "field", "value"),
    [
        ("BallOnBar-v0", "x", 0.024),
        ("BallOnBar-v0", "z", 0.5),
        ("BallOnBar-v0", "lost", True),
        ("Autopilot-v1", "turn_rate", -0.05),
        ("Autopilot-v1", "vertical_speed", 300.0),
        ("Autopilot-v1", "speed", 0.0),
        ("Autopilot-v1", "lost", True),
        ("TerrainRide-v0", "travel", -0.2),
        ("TerrainRide-v0", "travel", 0.2),
        ("TerrainRide-v0", "side", 1.0),
    ],
)
def test_extreme_states_are_drawn(env_id, field, value):
    resolved, states = episode_of(env_id, steps=1)
    name = task_of(env_id).name
    plain = painter(name, resolved, "rgb_array").draw(states[0])
    state = states[0].copy()
    state[field] = value
    assert painter(name, resolved, "rgb_array").draw(state).tobytes() != plain.tobytes()


@pytest.mark.parametrize("scene", ["bell", "rolling"])
def test_between_two_states_the_ball_flies_as_the_model_says(scene):
    resolved, states = episode_of("BallOnBar-v0", scene, "random", 12)
    artist = painter("ball_on_bar", resolved, "rgb_array")
    params, _ = resolved.records()
    for before, after in zip(states[:-1], states[1:], strict=True):
        moments = list(artist._between(before, after, 16))
        ball = moments[-1].ball
        assert moments[-1].time == after["steps"] * params["period"]
        assert ball["impacts"] == after["impacts"]
        assert ball["motion"].tobytes() == after["motion"].tobytes()
        assert abs(ball["x"] - after["x"]) < 1e-12 and abs(ball["z"] - after["z"]) < 1e-12
        for moment in moments:
            # the ball is on or above the surface: z_bar - (x - x_bar) tan(tilt)
            surface = moment.bar.z[0] - (moment.ball["x"] - moment.bar.x[0]) * np.tan(moment.bar.tilt[0])
            assert moment.ball["z"] > surface - 1e-12


def test_between_two_states_the_ball_flies_as_the_engine_of_the_scene_says():
    scene = {"rigid_body": {"step": 2e-4}}
    resolved, states = episode_of("BallOnBar-v0", scene, "bell-sink", 3)
    artist = painter("ball_on_bar", resolved, "rgb_array")
    for before, after in zip(states[:-1], states[1:], strict=True):
        moments = list(artist._between(before, after, 4))
        assert all(moments[-1].ball[name] == after[name] for name in ("x", "z", "u", "w", "impacts"))
        assert len({float(moment.ball["z"]) for moment in moments}) == 4


def test_a_cycle_stopped_on_the_way_agrees_with_the_impacts_of_the_whole():
    resolved, states = episode_of("BallOnBar-v0", None, "bell-sink", 3)
    params, options = resolved.records()
    log = np.zeros((8, len(LOGGED)))
    ball = states[2].copy()
    action = np.array([0.4, 0.0, 0.5, 0.0, 0.0, 0.0])
    advance(ball, action, params, *options, log)
    count = int(ball["impacts"] - states[2]["impacts"])
    assert count >= 2
    artist = painter("ball_on_bar", resolved, "rgb_array")
    rows = [log[(int(states[2]["impacts"]) + k) % 8] for k in range(count)]
    for k, moment in enumerate(artist._between(states[2], ball, 64), 1):
        done = sum(row[0] < params["period"] * k / 64 for row in rows)
        assert moment.ball["impacts"] - states[2]["impacts"] == done


def test_slow_motion_ends_at_the_state():
    resolved, states = episode_of("BallOnBar-v0", None, "bell-sink", 6)
    artist, other = (painter("ball_on_bar", resolved, "rgb_array") for _ in range(2))
    for state in states[:6]:
        artist.draw(state)
        other.draw(state)
    slow = list(artist.frames(states[5], states[6], 8))
    assert len(slow) == 8
    assert len({picture.tobytes() for picture in slow}) == 8
    assert slow[-1].tobytes() == other.draw(states[6]).tobytes()


def test_the_ground_behind_the_wheel_is_what_was_ahead_of_it():
    resolved, states = episode_of("TerrainRide-v0", None, None, 60)
    artist = painter("terrain_ride", resolved, "rgb_array")
    artist.draw(states[0])
    ahead = dict(artist._knots)
    for state in states[3::3]:
        artist.draw(state)
    passed = [k for k in artist._knots if 0 < k < int(states[-1]["knot"])]
    assert len(passed) > 20
    assert [artist._knots[k] for k in passed] == [ahead.get(k, artist._knots[k]) for k in passed]
    assert min(artist._knots) * 0.2 > 20.0 * 0.6 - 230.0 / artist.x_scale - 0.4


def test_a_tyre_gives_way_and_shows_that_it_is_off_the_ground():
    resolved, states = episode_of("TerrainRide-v0", "quarter-car", None, 3)
    on, squashed, off = (states[0].copy() for _ in range(3))
    squashed["deflection"], off["airborne"] = -0.01, True
    pictures = [painter("terrain_ride", resolved, "rgb_array").draw(state) for state in (on, squashed, off)]
    red = [int((p[..., 0] > 150).sum() - ((p[..., 0] > 150) & (p[..., 1] > 90)).sum()) for p in pictures]
    assert pictures[0].tobytes() != pictures[1].tobytes()
    assert red[2] > red[0] + 200
    assert painter("terrain_ride", resolved, "rgb_array").ahead * 0.1 > 6.0


@pytest.mark.parametrize("env_id", ids())
def test_a_window_shows_the_same_and_can_be_closed(env_id, monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    import pygame

    resolved, states = episode_of(env_id, steps=3)
    name = task_of(env_id).name
    artist = painter(name, resolved, "human")
    assert artist.draw(states[0]) is None
    shown = pygame.surfarray.array3d(pygame.display.get_surface()).swapaxes(0, 1)
    assert shown.tobytes() == painter(name, resolved, "rgb_array").draw(states[0]).tobytes()
    pygame.event.post(pygame.event.Event(pygame.QUIT))
    assert artist.draw(states[1]) is None
    assert not pygame.display.get_init()
    assert artist.draw(states[2]) is None
    artist.close()


@pytest.mark.parametrize("env_id", ids())
def test_the_environment_renders(env_id):
    import gymnasium as gym

    env = gym.make(spec_of(env_id), render_mode="rgb_array")
    env.reset(seed=1)
    first = env.render()
    env.step(env.action_space.sample())
    second = env.render()
    env.close()
    assert first.shape == second.shape == (400, 640, 3)
    assert first.tobytes() != second.tobytes()


def test_arrays_open_no_display(monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "none such")
    resolved, states = episode_of("BallOnBar-v0", steps=1)
    assert painter("ball_on_bar", resolved, "rgb_array").draw(states[0]).any()


def test_refuses_what_it_cannot_draw():
    resolved = resolve(task_of("BallOnBar-v0"), None)
    with pytest.raises(ValueError, match="no pictures of 'toy'.*ball_on_bar"):
        painter("toy", resolved, "rgb_array")
    with pytest.raises(ValueError, match="ascii.*rgb_array, human"):
        painter("ball_on_bar", resolved, "ascii")


@pytest.mark.parametrize("module", ["pygame", "matplotlib"])
def test_a_missing_package_says_what_to_install(module, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, module, None)
    with pytest.raises(ImportError, match=rf"{module}.*pip install '\.\[render\]' in a clone"):
        painter("ball_on_bar", resolve(task_of("BallOnBar-v0"), None), "rgb_array")


@pytest.mark.parametrize("curvature", [-40.0, 40.0])
def test_a_steep_bar_hides_neither_the_heading_nor_the_panels(curvature):
    name = "ball_on_bar"
    pictures = []
    for scene in ({"curve": {"curvature": curvature}}, {}):
        resolved = resolve(task_of("BallOnBar-v0"), scene)
        state = episode_of("BallOnBar-v0", scene, "do-nothing", 1)[1][0]
        pictures.append(painter(name, resolved, "rgb_array").draw(state))
    steep, flat = pictures
    assert (steep[:36, :200] == flat[:36, :200]).all()
    assert (steep[300:] == flat[300:]).all()
