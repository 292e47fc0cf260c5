"""The Chipmunk space against the exact model, which it does not know: its motion, contact laws and order."""

import subprocess
import sys

import numpy as np
import pytest

from vr_envs.envs.ball_on_bar import TASK
from vr_envs.envs.world import World
from vr_envs.models.ball_on_bar import interval
from vr_envs.models.drive import bar_at, demanded
from vr_envs.rigid_body.ball_on_bar import SAGITTA, Bounces

STILL = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
AT_EASE = np.zeros(6)  # the bar moves up and down only
ASKEW = np.array([0.4, 0.3, 0.5, -0.2, 0.1, 0.0])
COMPARED = ("x", "z", "u", "w", "spin", "seen")
LAWS = [{}, {"tangential_loss": 0.0}, {"tangential_loss": 1.0}, {"spin": True}]
SLIPPERY, REBOUNDING = {"coefficient": 0.03}, {"coefficient": 10.0, "restitution": 0.6}
OTHERS = [
    {"friction": SLIPPERY},
    {"spin": True, "friction": SLIPPERY},
    {"friction": REBOUNDING},
    {"spin": True, "friction": REBOUNDING},
    {"softening": {"speed": 0.2, "exponent": 0.5}},
    {"curve": True, "spin": True},
    {"curve": {"curvature": -20.0}},
    {"frequencies": {"x": 1.5, "tilt": 0.7, "z": 2.2}},
    {"ramp": {"z_cos": 5.0, "x_sin": 5.0, "tilt_cos": 20.0}},
    {"hold": 0.5, "blend": 0.3},
    {"hold": 2.0},
    {"sensing": True},
]


def world(step=None, **scene):
    """One ball in the default scene without scatter, moved by the space with steps of `step` s or, None, exactly."""
    engine = {} if step is None else {"rigid_body": {"step": step}}
    return World(TASK, {"scatter": None, **scene, **engine}, 1)


def moved(world, action, cycles=1, **start):
    """The state after `cycles` with one action, from `start`."""
    state = world.states[0]
    for name, value in start.items():
        state[name] = value
    for _ in range(cycles):
        if world.simulator is None:
            TASK.advance(state, action, world.params, *world.options)
        else:
            world.simulator.advance(state, action)
        state["steps"] += 1
    return state.copy()


def starts(n, seed=0):
    """Balls a few millimetres above a bar in its period-one motion, falling or rising, moving sideways, spinning."""
    rng = np.random.default_rng(seed)
    for _ in range(n):
        yield {
            "x": rng.uniform(-0.012, 0.012),
            "z": rng.uniform(0.001, 0.003),
            "u": rng.uniform(-0.03, 0.03),
            "w": rng.uniform(-0.1, 0.1),
            "spin": rng.uniform(-0.1, 0.1),
            "motion": demanded(AT_EASE, world().params),
        }


@pytest.mark.parametrize("step", [5e-4, 2e-5])
def test_free_flight_is_exact(step):
    balls = world(step)
    fallen = moved(balls, ASKEW, 3, x=0.001, z=0.1, u=0.05, w=0.7)
    t = 3 * balls.scene.params.period
    g = balls.scene.params.gravity
    assert fallen["impacts"] == 0
    assert abs(fallen["x"] - (0.001 + 0.05 * t)) < 1e-13 and abs(fallen["u"] - 0.05) < 1e-13
    assert abs(fallen["z"] - (0.1 + (0.7 - 0.5 * g * t) * t)) < 1e-13 and abs(fallen["w"] - (0.7 - g * t)) < 1e-12


@pytest.mark.parametrize(
    "sensor",
    [{"sensing": {"delay": 0.01234}}, {"camera": {"frame_rate": 8765.0, "noise": 0.0}}],
    ids=["sensing", "camera faster than the steps"],
)
def test_a_sensor_looks_between_the_steps_too(sensor):
    flying = {"x": 0.001, "z": 0.01, "u": 0.05, "w": 0.327}
    found, exact = (moved(world(step, **sensor), AT_EASE, **flying) for step in (5e-4, None))
    assert exact["impacts"] == found["impacts"] == 0 and np.abs(exact["seen"][:4]).min() > 1e-4
    assert np.abs(found["seen"] - exact["seen"]).max() < 1e-12


def test_the_bar_is_where_its_motion_says_at_the_end_of_every_step():
    balls = world(1e-4)
    old, new = (demanded(action, balls.params) for action in (ASKEW, -ASKEW))
    for steps in (1, 100, 333, balls.simulator.steps):
        state = balls.states[0].copy()
        state["motion"] = old
        space = Bounces(balls.simulator, state, new)
        space.run(steps)
        s = steps * balls.simulator.dt
        frame = bar_at(old, new, s, 0.0, 0, balls.params, None, None)
        assert np.allclose([*space.bar.position, -space.bar.angle], [frame.x[0], frame.z[0], frame.tilt[0]], 0, 1e-14)


@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.75, 1.0])
def test_restitution_is_the_scenes(restitution):
    """On a still bar the velocity after an impact, less what gravity adds, is that before it, reversed and scaled."""
    balls = world(1e-6, restitution=restitution, gravity=0.1, z_acceleration=0.0, z_acceleration_span=0.0)
    out = moved(balls, AT_EASE, z=0.004, w=-0.2, motion=STILL)
    speed = np.sqrt(0.2**2 + 2 * 0.1 * 0.004)
    falling = (speed - 0.2) / 0.1
    expected = restitution * speed - 0.1 * (balls.scene.params.period - falling)
    assert out["impacts"] == 1
    if restitution > 0.0:
        assert abs(out["w"] - expected) < 1e-6
    else:
        assert abs(out["z"]) < 1e-9 and abs(out["w"]) < 1e-6


@pytest.mark.parametrize(
    ("law", "action"), [(law, AT_EASE) for law in LAWS] + [(law, ASKEW) for law in (*LAWS, *OTHERS)], ids=str
)
def test_the_error_of_one_interval_is_of_first_order(law, action):
    """Median over starts: where in a step an impact falls is a matter of chance, and grazing balls go their own way."""
    exact = [moved(world(**law), action, **start) for start in starts(32)]
    errors = []
    for step in (2e-4, 2e-5):
        found = [moved(world(step, **law), action, **start) for start in starts(32)]
        errors.append(
            [np.median([np.abs(a[k] - b[k]).max() for a, b in zip(found, exact, strict=True)]) for k in COMPARED]
        )
    coarse, fine = np.array(errors)
    # an impact that is a step late: at the speeds (m/s) and accelerations (m/s^2) of the scene
    assert (coarse < 2e-4 * np.array([0.5, 0.5, 10.0, 40.0, 10.0, 40.0])).all(), coarse
    felt = coarse > 1e-12  # a frictionless level bar does not touch x
    assert felt[[1, 3]].all()
    order = np.log10(coarse[felt] / fine[felt])
    assert (order > 0.7).all() and (order < 1.4).all(), order


def test_the_period_one_bounce_has_its_apex_at_the_default_step():
    """The orbit attracts, so errors do not add up: the apex is within what the launch covers in one step."""
    heights = {}
    for name, engine in {"exact": {}, "default": {"rigid_body": True}, "fine": {"rigid_body": {"step": 1e-5}}}.items():
        balls = World(TASK, {"scatter": None, **engine}, 1)
        balls.reset(np.zeros(1, np.intp), np.array([3], np.uint64), balls.observe())
        apexes = []
        for _ in range(45):
            state = moved(balls, AT_EASE)
            assert state["impacts"] == 2 * (len(apexes) + 1)
            apexes.append(state["z"] + state["w"] ** 2 / (2 * balls.scene.params.gravity))
        heights[name] = np.array(apexes[20:])
    expected = heights["exact"].mean()
    assert np.ptp(heights["exact"]) < 1e-5 * expected
    # the flight takes half a cycle, and begins above the bar's mean height
    params = balls.scene.params
    launch = params.gravity * params.period / 4
    assert 0.0 < expected - launch**2 / (2 * params.gravity) < params.z_centre
    assert abs(heights["default"] - expected).max() < launch * 1e-4
    assert abs(heights["fine"] - expected).max() < launch * 1e-5


def test_impacts_scatter_as_in_the_exact_model():
    """The same draws: with them the two engines stay together, while without them the exact ball is elsewhere."""
    wide = {"scatter": {"restitution": 0.05, "normal": 0.02}}
    near, far = [], []
    for key, start in enumerate(starts(12), 1):
        found = moved(world(2e-5, **wide), AT_EASE, 2, key=key, **start)
        twin, plain = (moved(world(**scene), AT_EASE, 2, key=key, **start) for scene in (wide, {}))
        near.append(abs(found["u"] - twin["u"]))
        far.append(abs(plain["u"] - twin["u"]))
    assert np.median(near) < 0.01 * np.median(far)


@pytest.mark.parametrize("law", [*LAWS, {"curve": True, "spin": True}, {"friction": {"coefficient": 1.0}}], ids=str)
def test_a_ball_that_hardly_bounces_comes_to_rest_on_the_bar(law):
    start = {"x": 0.003, "z": 0.002, "motion": demanded(AT_EASE, world().params)}
    exact = moved(world(restitution=0.2, **law), 0.2 * ASKEW, 12, **start)
    found = moved(world(2e-5, restitution=0.2, **law), 0.2 * ASKEW, 12, **start)
    assert exact["resting"] and not exact["lost"]
    assert abs(found["z"] - exact["z"]) < (SAGITTA if "curve" in law else 1e-7)
    assert abs(found["x"] - exact["x"]) < 2e-5
    assert found["impacts"] < 12  # not one per step


def test_a_ball_that_passes_the_end_of_the_bar_is_lost_where_the_exact_one_is():
    start = {"x": 0.02, "z": 0.003, "u": 0.05, "motion": demanded(AT_EASE, world().params)}
    for cycles, lost in ((1, False), (10, True)):
        exact, found = (moved(world(step, tangential_loss=0.0), AT_EASE, cycles, **start) for step in (None, 2e-5))
        assert exact["lost"] == found["lost"] == lost
        assert abs(found["x"] - exact["x"]) < 1e-5
    again = moved(world(2e-5), AT_EASE, 3, **{name: found[name] for name in found.dtype.names})
    again["steps"] = found["steps"]
    assert again.tobytes() == found.tobytes()


def test_a_cycle_stopped_on_the_way_is_on_the_way():
    balls = world(2e-5)
    new = demanded(ASKEW, balls.params)
    whole, half = (moved(balls, ASKEW, 0, **next(starts(1))) for _ in range(2))
    balls.simulator.interval(half, new, 0.5 * balls.scene.params.period)
    exact = world()
    part = moved(exact, ASKEW, 0, **next(starts(1)))
    interval(part, new, exact.params, *exact.options, None, 0.5 * exact.scene.params.period)
    assert abs(half["x"] - part["x"]) < 1e-5 and abs(half["z"] - part["z"]) < 1e-5
    balls.simulator.interval(whole, new, balls.scene.params.period)
    whole["steps"] += 1
    assert whole.tobytes() == moved(world(2e-5), ASKEW, 1, **next(starts(1))).tobytes()


def test_the_exact_engine_does_not_import_pymunk():
    code = (
        "import sys, gymnasium, vr_envs; env = gymnasium.make('vr_envs/BallOnBar-v0'); env.reset(seed=0); "
        "print('pymunk' in sys.modules); gymnasium.make('vr_envs/BallOnBar-v0', engine='rigid_body'); "
        "print('pymunk' in sys.modules)"
    )
    printed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert printed.split() == ["False", "True"]
