"""Coming to rest, lying and rolling: against impacts followed one by one in many digits, and DOP853."""

import math

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vr_envs.envs.ball_on_bar import TASK
from vr_envs.envs.scene import resolve
from vr_envs.models.ball_on_bar import LOGGED, advance
from vr_envs.models.ball_options import Curve
from vr_envs.models.bar import Piece, frame_at
from vr_envs.models.drive import demanded
from vr_envs.models.record import dtype_of, pack
from vr_envs.models.support import flight_support, forces_at, gripping, support

GRAVITY = 9.81
PLAIN = None, (0.0, 0.0, 0.0), None  # no frequencies of their own, no ramp
SMOOTH = {"scatter": None, "restitution": 0.5, "half_length": 0.5}
LAWS = {
    "loss": {**SMOOTH, "tangential_loss": 0.3},
    "frictionless": {**SMOOTH, "tangential_loss": 0.0},
    "sphere": {**SMOOTH, "base": "rolling"},
}


@pytest.fixture(autouse=True)
def thirty_digits():
    with mp.workdps(30):
        yield


class Bar:
    """The bar of one constant motion, from its definition."""

    def __init__(self, params, motion):
        self.w, self.m = mp.mpf(float(params["omega"])), [mp.mpf(float(v)) for v in motion]

    def at(self, s, order=0):
        """(x, tilt, z), or their derivative of the given order: of a cosine, a cosine a quarter turn on."""
        quarter = order * mp.pi / 2
        values = []
        for i, k in enumerate((1, 1, 2)):
            w = k * self.w
            c, sn = self.m[2 * i], self.m[2 * i + 1]
            values.append(w**order * (c * mp.cos(w * s + quarter) + sn * mp.sin(w * s + quarter)))
        return values


def follow(scene, action, x, height, u):
    """Drop a ball in mpmath and follow its impacts one by one until it is at rest: (time, place, rate, count)."""
    params, options = resolve(TASK, scene).records()
    bar, spin = Bar(params, demanded(action, params)), options[1]
    alpha, c, g = mp.mpf(float(params["restitution"])), mp.mpf(float(params["tangential_loss"])), mp.mpf(GRAVITY)
    bx, tilt, bz = bar.at(mp.mpf(0))
    x, u, w, s, rolled = mp.mpf(x), mp.mpf(u), mp.mpf(0), mp.mpf(0), mp.mpf(0)
    z = bz - (x - bx) * mp.tan(tilt) + mp.mpf(height)

    def gap(t):
        bx, tilt, bz = bar.at(s + t)
        return (x + u * t - bx) * mp.sin(tilt) + (z + w * t - g * t * t / 2 - bz) * mp.cos(tilt)

    guess = None
    for count in range(200):
        if guess is None:
            t = mp.mpf("1e-5")
            while gap(t) > 0:
                t += mp.mpf("1e-5")
            t = mp.findroot(gap, (t - mp.mpf("1e-5"), t), solver="illinois", tol=mp.mpf(10) ** -50, verify=False)
        else:
            t = mp.findroot(gap, (guess, guess * mp.mpf("1.001")), tol=mp.mpf(10) ** -55, verify=False)
            assert t > guess / 2
        x, z, w, s = x + u * t, z + w * t - g * t * t / 2, w - g * t, s + t
        (bx, tilt, bz), (vx, vt, vz) = bar.at(s), bar.at(s, 1)
        sin, cos = mp.sin(tilt), mp.cos(tilt)
        ru, rw = u - vx - vt * (z - bz), w - vz + vt * (x - bx)
        normal, tangent = ru * sin + rw * cos, ru * cos - rw * sin
        after = -alpha * normal
        along = (1 - c) * tangent
        if spin is not None:
            k, radius = mp.mpf(float(spin["inertia_ratio"])), mp.mpf(float(spin["radius"]))
            slip = tangent - (rolled - radius * vt)
            along, rolled = tangent - k / (1 + k) * slip, rolled + slip / (1 + k)
        u += (after - normal) * sin + (along - tangent) * cos
        w += (after - normal) * cos - (along - tangent) * sin
        if after < mp.mpf(10) ** -13:
            return float(s), float((x - bx) / cos), float(along), count + 1
        force = -mp.diff(gap, 0, 2)
        assert force > 0
        if 2 * after / force < mp.mpf("2e-5"):
            guess = 2 * after / force
    raise AssertionError("the ball has not come to rest")


def drop(scene, action, x, height, u, w=0.0):
    """The same ball in the model; the state at the end of the first cycle in which the bar has this motion."""
    params, options = resolve(TASK, scene).records()
    state = np.zeros(1, dtype_of(TASK.state))
    motion = demanded(action, params)
    state["motion"] = motion
    surface = motion[4] - (x - motion[0]) * math.tan(motion[2])
    state["x"], state["z"], state["u"], state["w"] = x, surface + height, u, w
    advance(state[0], action, params, *options)
    return params, options, state[0], motion


def rolled_on(params, spin, motion, start, d, rate):
    """DOP853 of the rolling law from rest's begin to the end of the cycle, from the accelerations of the bar."""
    k, radius = (0.0, 0.0) if spin is None else (float(spin["inertia_ratio"]), float(spin["radius"]))
    w = float(params["omega"])

    def law(t, y):
        cos, sin, cos2, sin2 = math.cos(w * t), math.sin(w * t), math.cos(2 * w * t), math.sin(2 * w * t)
        ax = -(w**2) * (motion[0] * cos + motion[1] * sin)
        tilt, turn = motion[2] * cos + motion[3] * sin, w * (motion[3] * cos - motion[2] * sin)
        az = -4 * w**2 * (motion[4] * cos2 + motion[5] * sin2)
        along = ax * math.cos(tilt) - az * math.sin(tilt)
        pull = GRAVITY * math.sin(tilt) - along + y[0] * turn**2 + k * radius * w**2 * tilt
        return [y[1], pull / (1 + k)]

    return solve_ivp(law, (start, float(params["period"])), [d, rate], "DOP853", rtol=1e-13, atol=1e-18).y[:, -1]


# gentle enough that the ball, once at rest, stays; x and z motion, tilt, and a ball that slides as it lands
ACTION = np.array([0.2, -0.1, 0.05, 0.04, -0.2, 0.3])


@pytest.mark.parametrize("law", LAWS)
def test_a_chatter_ends_where_and_when_its_impacts_do(law):
    scene = {**LAWS[law], "z_acceleration": 4.0}
    start = {"x": 0.004, "height": 2e-5, "u": 0.02}
    time, place, rate, count = follow(scene, ACTION, **start)
    params, options, state, motion = drop(scene, ACTION, **start)
    assert state["resting"] == 1
    assert 5 < state["impacts"] < count  # the rest of the chatter was summed
    if law == "loss":
        assert state["d"] == pytest.approx(place, abs=5e-12)  # STEADY times the way left when the sum is taken
        assert state["rate"] == 0.0
    else:
        d, speed = rolled_on(params, options[1], motion, time, place, rate)
        assert state["d"] == pytest.approx(d, abs=1e-11)
        assert state["rate"] == pytest.approx(speed, abs=1e-10)


def test_a_chatter_is_not_summed_while_the_lost_velocity_changes_the_force():
    """A fast ball on a turning bar feels a Coriolis force of 3 % of its weight, which goes as its impacts slow it."""
    scene = {**LAWS["loss"], "tangential_loss": 0.05, "z_acceleration": 4.0}
    action = np.array([0.2, -0.1, 0.0, 0.9, -0.2, 0.3])
    start = {"x": 0.004, "height": 2e-5, "u": 1.0}
    _, place, _, _ = follow(scene, action, **start)
    _, _, state, _ = drop(scene, action, **start)
    assert state["resting"] == 1
    assert state["d"] == pytest.approx(place, abs=1e-12)


def test_a_bounce_is_no_chatter_because_the_force_is_at_its_extreme():
    """At the bar's lowest point the force has no slope; a ball that leaves with 0.05 m/s flies milliseconds."""
    scene = {**LAWS["loss"], "restitution": 0.75, "z_acceleration": 8.0}
    params, options = resolve(TASK, scene).records()
    state = np.zeros(1, dtype_of(TASK.state))
    motion = demanded(np.array([0, 0, 0, 0, -4.0, 0]), params)  # z_cos = -A: lowest at s = 0
    state["motion"] = motion
    state["z"], state["w"] = motion[4], -0.05 / 0.75
    log = np.zeros((100, len(LOGGED)))
    advance(state[0], np.array([0, 0, 0, 0, -4.0, 0]), params, *options, log)
    assert log[0, 0] == 0.0
    assert state["impacts"][0] > 3
    assert 5e-3 < log[1, 0] < 7e-3


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("speed", [0.0, 5e-13])
def test_a_ball_that_loses_nothing_rests_if_it_is_laid_down(law, speed):
    params, options, state, _ = drop(
        {**LAWS[law], "restitution": 1.0, "z_acceleration": 0.0}, np.zeros(6), 0.01, 0.0, 0.0, -speed
    )
    assert state["resting"] == 1 and state["impacts"] == 1
    assert (state["d"], state["rate"]) == (0.01, 0.0)


@pytest.mark.parametrize("curvature", [None, 13.3, -20.0])
@pytest.mark.parametrize("rate", [0.0, 0.03])
def test_support_is_minus_the_second_and_third_derivative_of_the_gap_in_flight(rate, curvature):
    piece = Piece(2 * math.pi * 15, 0.0, 0.0, (1e-3, 4e-4, 0.01, -0.006, 2e-4, 1e-4), (0.0,) * 6, *PLAIN)
    params = {"omega": piece.omega}
    bar, s, d = Bar(params, piece.base), mp.mpf("0.0171"), mp.mpf("0.012")
    (bx, tilt, bz), (vx, vt, vz) = bar.at(s), bar.at(s, 1)
    cos, sin, k = mp.cos(tilt), mp.sin(tilt), mp.mpf(curvature or 0.0)
    q = k * d * d / 2
    x, z = bx + d * cos + q * sin, bz - d * sin + q * cos
    # moves with the bar's material, and along the surface with `rate`
    along = rate / mp.sqrt(1 + k * k * d * d)
    right, up = along * (cos + k * d * sin), along * (k * d * cos - sin)
    u, w = vx + vt * (z - bz) + right, vz - vt * (x - bx) + up

    def gap(t):
        ax, tilt, az = bar.at(s + t)
        rx, rz = x + u * t - ax, z + w * t - mp.mpf(GRAVITY) * t * t / 2 - az
        p = rx * mp.cos(tilt) - rz * mp.sin(tilt)
        return rx * mp.sin(tilt) + rz * mp.cos(tilt) - k * p * p / 2

    assert abs(mp.diff(gap, 0, 1)) < 1e-15
    curve = None if curvature is None else pack(Curve(curvature))
    force, slope = flight_support(frame_at(piece, float(s)), GRAVITY, float(d), rate, curve)
    assert force == pytest.approx(float(-mp.diff(gap, 0, 2)), rel=1e-13)
    assert slope == pytest.approx(float(-mp.diff(gap, 0, 3)), rel=1e-12)


@pytest.mark.parametrize("curve", [None, pack(Curve(13.3))])
def test_support_of_a_carried_ball_is_its_own_derivative(curve):
    piece = Piece(
        2 * math.pi * 15,
        0.0,
        1 / 30,
        (1e-3, 4e-4, 0.01, -0.006, 2e-4, 1e-4),
        (5e-4, 0, -0.008, 0.002, 1e-4, 0),
        *PLAIN,
    )
    for s in (0.001, 0.012, 0.029):
        h = 1e-6
        ahead, behind = (support(frame_at(piece, s + e), GRAVITY, 0.01, 0.0, 0.0, curve)[0] for e in (h, -h))
        _, slope = support(frame_at(piece, s), GRAVITY, 0.01, 0.0, 0.0, curve)
        assert slope == pytest.approx((ahead - behind) / (2 * h), rel=1e-6)


def test_a_carried_ball_moves_as_the_bars_material_does():
    """Position and velocity at the end of a cycle, on a tilting bar: the velocity is the position's derivative."""
    scene = {**LAWS["loss"], "z_acceleration": 4.0}
    params, _, state, motion = drop(scene, ACTION, 0.1, 1e-6, 0.0)
    bar = Bar(params, motion)

    def place(t):
        bx, tilt, bz = bar.at(t)
        return bx + mp.mpf(float(state["d"])) * mp.cos(tilt), bz - mp.mpf(float(state["d"])) * mp.sin(tilt)

    end = mp.mpf(float(params["period"]))
    assert (state["x"], state["z"]) == pytest.approx([float(v) for v in place(end)], abs=1e-15)
    speeds = [float(mp.diff(lambda t, i=i: place(t)[i], end)) for i in range(2)]
    assert (state["u"], state["w"]) == pytest.approx(speeds, rel=1e-10)


def test_rolling_law_feels_gravity_and_the_bars_acceleration():
    """A bar pushed sideways without tilt leaves a frictionless ball behind: d'' = -x''; a sphere by 5/7 of that."""
    piece = Piece(2 * math.pi * 15, 0.0, 0.0, (1e-3, 0, 0, 0, 0, 0), (0.0,) * 6, *PLAIN)
    frame = frame_at(piece, 0.003)

    def rolling(frame, inertia_ratio, radius):
        return gripping(forces_at(frame, GRAVITY), 0.0, 0.0, inertia_ratio, radius, None)

    assert rolling(frame, 0.0, 0.0) == pytest.approx(-frame.x[2], rel=1e-14)
    assert rolling(frame, 0.4, 0.003) == pytest.approx(-frame.x[2] * 5 / 7, rel=1e-14)
    level = frame_at(Piece(2 * math.pi * 15, 0.0, 0.0, (0, 0, 0.02, 0, 0, 0), (0.0,) * 6, *PLAIN), 0.0)
    inertia = 0.4 * 0.003 * level.tilt[2] / 1.4
    assert rolling(level, 0.4, 0.003) == pytest.approx(GRAVITY * math.sin(0.02) / 1.4 - inertia, rel=1e-14)


@pytest.mark.parametrize("frequency", [0.5, 1.0, 5.0, 6.351, 50.0, 200.0])
@pytest.mark.parametrize("law", LAWS)
def test_no_search_ends_undecided_at_any_frequency(frequency, law):
    """Where a unit in the last place of the time is longer or shorter than at 15 Hz."""
    size = (15.0 / frequency) ** 2
    params, options = resolve(
        TASK, {**LAWS[law], "frequency": frequency, "half_length": 10.0, "tilt_acceleration": 50.0 / max(1.0, size)}
    ).records()
    rng = np.random.default_rng(6)
    state = np.zeros(1, dtype_of(TASK.state))
    for key in range(20):
        state[:] = np.zeros((), state.dtype)
        state["key"] = key
        TASK.start(state[0], params, *options)
        for _ in range(20):
            advance(state[0], rng.uniform(-1, 1, 6), params, *options)
            assert state["fault"][0] == 0
