"""What a scene may add to the ball on a bar: against plain scenes, closed forms and DOP853."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vr_envs.envs.ball_on_bar import TASK
from vr_envs.envs.scene import resolve
from vr_envs.models.ball_on_bar import LOGGED, advance, interval
from vr_envs.models.drive import demanded
from vr_envs.models.record import dtype_of

GRAVITY = 9.81
ACTION = np.array([0.3, -0.2, 0.2, 0.1, 0.4, -0.3])


def world(scene, key=7):
    params, options = resolve(TASK, scene).records()
    state = np.zeros(1, dtype_of(TASK.state))
    state["key"] = key
    TASK.start(state[0], params, *options)
    return params, options, state


def run(scene, steps, action=ACTION, key=7):
    params, options, state = world(scene, key)
    for _ in range(steps):
        advance(state[0], action, params, *options)
        state["steps"] += 1
    return state[0]


def places(state):
    return [state[name] for name in ("x", "z", "u", "w")]


@pytest.mark.parametrize("scene", ["bell", {"frequencies": {"x": 0.3, "tilt": 1.7, "z": 2.1}, "ramp": True}])
def test_an_action_held_for_two_cycles_is_the_same_action_twice(scene):
    overrides = {"base": scene} if isinstance(scene, str) else scene
    once, twice = run(overrides, 10), run({**overrides, "hold": 2.0}, 5)
    assert places(once) == places(twice)
    assert once["impacts"] == twice["impacts"] > 10


def test_an_action_held_for_half_a_cycle_is_the_same_action_twice():
    whole, half = run({"scatter": None}, 5), run({"scatter": None, "hold": 0.5}, 10)
    assert places(half) == pytest.approx(places(whole), abs=1e-14)


def test_half_cycles_blend_from_where_they_begin():
    """The bar's motion is continuous when the action changes in the middle of a cycle: the ball rests on it."""
    scene = {"scatter": None, "hold": 0.5, "z_acceleration": 3.0, "z_acceleration_span": 1.0, "restitution": 0.0}
    params, options, state = world(scene)
    rng = np.random.default_rng(2)
    for _ in range(20):
        before = state.copy()
        new = demanded(0.3 * rng.uniform(-1, 1, 6), params)
        interval(state[0], new, params, *options, None, 1e-9)
        if before["resting"][0]:
            assert places(state[0]) == pytest.approx(places(before[0]), abs=1e-8)
        state[:] = before
        interval(state[0], new, params, *options)
        state["steps"] += 1
    assert state["resting"][0]


def test_the_usual_frequencies_are_the_plain_bar():
    plain, free = run({"scatter": None}, 30), run({"scatter": None, "frequencies": True}, 30)
    assert places(free) == pytest.approx(places(plain), abs=1e-12)


@pytest.mark.parametrize("scene", ["bell", "rolling"])
def test_a_bar_that_is_hardly_curved_is_the_flat_one(scene):
    """The two gaps, the flat bar's and the curved one's, are different formulas; the place differs by curvature."""
    curved = run({"base": scene, "scatter": None, "curve": {"curvature": 1e-10}}, 12)
    assert places(curved) == pytest.approx(places(run({"base": scene, "scatter": None}, 12)), abs=1e-11)


def test_many_samples_find_what_the_certified_search_finds():
    plain, sampled = run({"scatter": None}, 30), run({"scatter": None, "textbook": {"samples": 200}}, 30)
    assert places(sampled) == pytest.approx(places(plain), abs=1e-12)


def test_what_is_seen_is_the_state_of_a_moment_ago():
    params, options, state = world({"sensing": {"delay": 0.02}})
    before = state.copy()
    advance(state[0], ACTION, params, *options)
    interval(before[0], demanded(ACTION, params), params, *options, None, params["period"] - 0.02)
    x, u, z, w = (before[name][0] for name in ("x", "u", "z", "w"))
    assert state["seen"][0, :4] == pytest.approx([x, u, z, w], abs=1e-15)


def test_sensing_noise_has_its_size_and_follows_from_the_record():
    position, velocity = 2e-4, 0.03
    params, options, state = world({"sensing": {"position": position, "velocity": velocity, "delay": 0.0}})
    noise = []
    for _ in range(600):
        row, again = np.zeros((2, 10), np.float32)
        TASK.observe(state[0], row, params, *options)
        TASK.observe(state[0], again, params, *options)
        assert row.tobytes() == again.tobytes()
        seen = row[:4] * np.array([params["half_length"], 0.5, 0.02, 1.0])
        noise.append(seen - [state[name][0] for name in ("x", "u", "z", "w")])
        advance(state[0], np.zeros(6), params, *options)
        state["steps"] += 1
    # 600 numbers: the standard deviation is known to 2.9 %
    assert np.std(noise, axis=0) == pytest.approx([position, velocity, position, velocity], rel=0.12)
    assert np.abs(np.corrcoef(np.transpose(noise)) - np.eye(4)).max() < 0.17


class OnBar:
    """Motion of a ball on the bar's surface from Newton's law in vectors: r = c + M(tilt) (p, curvature p^2/2)."""

    def __init__(self, params, motion, curvature=0.0, inertia_ratio=0.0, radius=0.0, friction=0.0):
        self.w, self.m, self.k = params["omega"], motion, curvature
        self.inertia_ratio, self.radius, self.friction = inertia_ratio, radius, friction

    def bar(self, t):
        """(value, first, second derivative) of x, tilt, z."""
        rows = []
        for i, w in enumerate((self.w, self.w, 2 * self.w)):
            c, s = self.m[2 * i], self.m[2 * i + 1]
            cos, sin = math.cos(w * t), math.sin(w * t)
            rows.append((c * cos + s * sin, w * (s * cos - c * sin), -w * w * (c * cos + s * sin)))
        return rows

    def forces(self, t, p, rate):
        """Specific force at p'' = 0 along the tangent and the normal, the steepness, tilt' and tilt''."""
        (_, _, ax), (tilt, turn, turning), (_, _, az) = self.bar(t)
        axes = np.array([[math.cos(tilt), math.sin(tilt)], [-math.sin(tilt), math.cos(tilt)]])
        quarter = np.array([[0.0, 1.0], [-1.0, 0.0]])  # of a positive tilt
        place, slope = axes @ [p, self.k * p * p / 2], axes @ [1.0, self.k * p]
        force = np.array([ax, az + GRAVITY]) + turning * quarter @ place - turn**2 * place
        force += 2 * turn * rate * quarter @ slope + rate**2 * axes @ [0.0, self.k]
        tangent = slope / np.linalg.norm(slope)
        normal = np.array([-tangent[1], tangent[0]])
        return force @ tangent, force @ normal, np.linalg.norm(slope), turn, turning

    def rolling(self, t, y):
        p, rate = y[:2]
        along, _, steep, _, turning = self.forces(t, p, rate)
        bent = self.k**2 * p * rate**2 / steep
        pull = -(along + self.inertia_ratio * (bent + self.radius * turning)) / ((1 + self.inertia_ratio) * steep)
        return [rate, pull, 0.0]

    def slip(self, t, y):
        _, _, steep, turn, _ = self.forces(t, *y[:2])
        return steep * y[1] - (y[2] - self.radius * turn if self.inertia_ratio else 0.0)

    def sliding(self, t, y, direction):
        along, across, steep, _, _ = self.forces(t, *y[:2])
        drag = direction * self.friction * across
        return [y[1], -(along + drag) / steep, drag / self.inertia_ratio if self.inertia_ratio else 0.0]


def rest_on(scene, d, rate, rim, action):
    """A ball put at rest on the bar, and the model of it."""
    params, options, state = world({"scatter": None, "z_acceleration": 2.0, "half_length": 0.05, **scene})
    motion = demanded(action, params)
    state["motion"], state["resting"] = motion, True
    state["d"], state["rate"], state["spin"] = d, rate, rim
    named = dict(zip(TASK.options, options, strict=True))
    spin, curve, friction = named["spin"], named["curve"], named["friction"]
    model = OnBar(
        params,
        motion,
        0.0 if curve is None else curve["curvature"],
        0.0 if spin is None else spin["inertia_ratio"],
        0.0 if spin is None else spin["radius"],
        0.0 if friction is None else friction["coefficient"],
    )
    return params, options, state, model


@pytest.mark.parametrize("scene", [{"spin": True}, {"tangential_loss": 0.0}], ids=["sphere", "frictionless"])
@pytest.mark.parametrize("curvature", [13.3, -9.0])
def test_a_ball_rolls_on_a_curved_bar_as_newtons_law_says(scene, curvature):
    action = np.array([0.1, 0.2, 0.05, 0.1, -0.2, 0.1])
    params, options, state, model = rest_on({**scene, "curve": {"curvature": curvature}}, 0.012, 0.05, 0.0, action)
    truth = solve_ivp(
        model.rolling, (0, params["period"]), [0.012, 0.05, 0.0], method="DOP853", rtol=1e-13, atol=1e-18
    ).y[:, -1]
    advance(state[0], action, params, *options)
    assert state["resting"][0]
    assert (state["d"][0], state["rate"][0]) == pytest.approx(tuple(truth[:2]), rel=1e-10)


def test_a_frictionless_ball_in_a_still_bowl_keeps_its_energy():
    scene = {"tangential_loss": 0.0, "z_acceleration": 0.0, "curve": {"curvature": 20.0}}
    params, options, state, model = rest_on(scene, 0.02, 0.0, 0.0, np.zeros(6))
    for _ in range(150):
        advance(state[0], np.zeros(6), params, *options)
    d, rate = state["d"][0], state["rate"][0]
    energy = 0.5 * rate**2 * (1 + (20 * d) ** 2) + GRAVITY * 10 * d**2
    assert energy == pytest.approx(GRAVITY * 10 * 0.02**2, rel=1e-11)


@pytest.mark.parametrize("scene", [{"spin": True}, {"spin": True, "curve": True}, {}], ids=["flat", "lens", "no spin"])
def test_a_sliding_ball_slides_until_it_grips(scene):
    """Coulomb friction at rest: DOP853 to the moment at which the slip is zero, and gripping from there."""
    action = np.array([0.1, 0.1, 0.02, 0.05, 0.0, 0.0])
    params, options, state, model = rest_on({**scene, "friction": {"coefficient": 0.3}}, -0.01, 0.08, 0.0, action)
    y = [-0.01, 0.08, 0.0]
    direction = math.copysign(1.0, model.slip(0.0, y))

    def stopped(t, y, direction=None):
        return model.slip(t, y)

    stopped.terminal = True
    end = params["period"]
    slid = solve_ivp(
        lambda t, y: model.sliding(t, y, direction), (0, end), y, "DOP853", events=stopped, rtol=1e-13, atol=1e-18
    )
    assert slid.status == 1
    y, t = slid.y[:, -1], slid.t[-1]
    assert 1e-3 < t < 0.8 * end
    gripping = model.rolling if scene else lambda t, y: [0.0, 0.0, 0.0]  # without spin it sticks
    y = solve_ivp(gripping, (t, end), y if scene else [y[0], 0.0, 0.0], "DOP853", rtol=1e-13, atol=1e-18).y[:, -1]
    advance(state[0], action, params, *options)
    assert state["resting"][0]
    assert (state["d"][0], state["rate"][0]) == pytest.approx((y[0], y[1]), rel=1e-9, abs=1e-12)


def test_a_bar_that_shakes_harder_than_friction_holds_makes_the_ball_slip():
    """x at 4 m/s^2 over a limit of 0.1 g: the ball moves less than the bar, and never by more than the limit."""
    action = np.array([0.4, 0, 0, 0, -1.0, 0])
    scene = {"friction": {"coefficient": 0.1}, "z_acceleration": 1e-9, "z_acceleration_span": 0.0}
    params, options, state, _ = rest_on(scene, 0.0, 0.0, 0.0, action)
    speeds = []
    for k in range(1, 400):
        part = state.copy()
        interval(part[0], demanded(action, params), params, *options, None, params["period"] * k / 400)
        speeds.append(part["u"][0])
    pulls = np.abs(np.diff(speeds)) / (params["period"] / 400)
    assert pulls.max() == pytest.approx(0.1 * GRAVITY, rel=1e-6)


def test_restitution_one_with_scatter_is_no_fault():
    """Its clipped scatter takes energy on average, so a chatter ends, and is closed with that average."""
    rng = np.random.default_rng(3)
    for key in range(10):
        params, options, state = world({"restitution": 1.0, "scatter": True}, key)
        for _ in range(150):
            advance(state[0], 0.3 * rng.uniform(-1, 1, 6), params, *options)
            state["steps"] += 1
        assert not state["fault"][0]


def test_too_many_events_are_reported():
    """A ball that loses nothing and bounces a nanometre high meets the bar more often than the limit allows."""
    params, options, state = world(
        {"restitution": 1.0, "scatter": None, "z_acceleration": 0.0, "z_acceleration_span": 0.0}
    )
    state["z"], state["w"] = 1e-11, 0.0
    advance(state[0], np.zeros(6), params, *options)
    assert state["fault"][0]
    reward, terminated = TASK.outcome(state[0], np.zeros(6), params, *options)
    assert terminated and reward == 0.0


def test_a_ramp_that_stands_the_bar_upright_is_reported():
    """At the bar's middle a ball may lie at any tilt; the gap, measured vertically, ends at a right angle."""
    tilt = 1000.0 / (2 * math.pi * 15) ** 2  # rad/s
    params, options, state = world({"scatter": None, "z_acceleration": 1.0, "ramp": {"tilt_cos": 1000.0, "z_cos": 0}})
    state["resting"] = True
    while not state["fault"][0]:
        advance(state[0], np.array([0, 0, 0, 0, -0.25, 0]), params, *options)
        state["steps"] += 1
        assert state["steps"][0] < 300
    assert state["steps"][0] * params["period"] * tilt == pytest.approx(1.5, rel=0.02)


EVERYTHING = {"scatter": True, "spin": True, "friction": True, "softening": True, "curve": True}


@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.9, 1.0])
@pytest.mark.parametrize("peak", [0.0, 9.81, 30.0, 100.0])
def test_every_law_at_once_from_rest_to_ten_g(restitution, peak):
    """The ball stays on or above the surface, finite, without a fault, whatever restitution and acceleration."""
    overrides = {"friction": {"coefficient": 0.1, "restitution": 0.5}, "scatter": {"restitution": 0.02}}
    scene = {**EVERYTHING, **overrides, "restitution": restitution, "half_length": 0.05}
    params, options, state = world({**scene, "z_acceleration": peak, "z_acceleration_span": 0.3 * peak})
    rng = np.random.default_rng(int(peak * 10 + restitution * 100))
    curvature = options[list(TASK.options).index("curve")]["curvature"]
    for key in range(4):
        state[:] = np.zeros((), state.dtype)
        state["key"] = key
        TASK.start(state[0], params, *options)
        for _ in range(40):
            advance(state[0], rng.uniform(-1, 1, 6), params, *options)
            state["steps"] += 1
            assert not state["fault"][0]
            if state["lost"][0]:
                break
            m = state["motion"][0]
            rx, rz = state["x"][0] - m[0], state["z"][0] - m[4]
            along = rx * math.cos(m[2]) - rz * math.sin(m[2])
            across = rx * math.sin(m[2]) + rz * math.cos(m[2])
            assert across - curvature * along**2 / 2 > -1e-14
            assert np.isfinite([state[k][0] for k in ("x", "z", "u", "w", "spin")]).all()


def test_the_log_tells_the_velocities_after_an_impact():
    params, options, state = world({"scatter": None, "tangential_loss": 0.3})
    log = np.zeros((10, len(LOGGED)))
    advance(state[0], ACTION, params, *options, log)
    rows = log[: int(state["impacts"][0])]
    assert len(rows) >= 2
    assert rows[:, 5] == pytest.approx(-params["restitution"] * rows[:, 3], rel=1e-14)
    assert rows[:, 6] == pytest.approx(0.7 * rows[:, 4], rel=1e-13)
