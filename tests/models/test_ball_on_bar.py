"""The ball model against 50 digits and against the closed forms of the bouncing ball."""

import math

import numpy as np
import pytest

from vr_envs.bench.accuracy.ball_on_bar_reference import Reference
from vr_envs.envs.ball_on_bar import TASK
from vr_envs.envs.scene import resolve
from vr_envs.models.ball_on_bar import LOGGED, advance
from vr_envs.models.drive import demanded
from vr_envs.models.noise import normal_pair
from vr_envs.models.record import dtype_of


def world(scene, key=7):
    params, options = resolve(TASK, scene).records()
    state = np.zeros(1, dtype_of(TASK.state))
    state["key"] = key
    TASK.start(state[0], params, *options)
    return params, options, state


def run(scene, actions, key=7):
    """States and the log of impacts (cycle, time in the cycle, x, z, normal and tangential approach velocity)."""
    params, options, state = world(scene, key)
    impacts = []
    for cycle, action in enumerate(actions):
        log = np.zeros((30_000, len(LOGGED)))
        before = int(state["impacts"][0])
        advance(state[0], np.asarray(action, float), params, *options, log)
        rows = [log[i % len(log)] for i in range(before, int(state["impacts"][0]))]
        impacts += [(cycle, *row) for row in rows]
    return params, state[0], np.array(impacts)


def varied_actions(n, seed=3):
    """Actions about the sink motion whose orbit stays near period one, another one every cycle."""
    rng = np.random.default_rng(seed)
    return np.array([0.4, 0, 0, 0.5, 0, 0]) + rng.uniform(-0.2, 0.2, (n, 6))


@pytest.mark.parametrize(
    ("scene", "actions"),
    [
        pytest.param("bell", np.zeros((26, 6)), id="default-still"),
        pytest.param("bell", varied_actions(26), id="default-action-every-cycle"),
        pytest.param({"scatter": None}, varied_actions(26, 5), id="smooth-action-every-cycle"),
    ],
)
def test_impact_times_match_fifty_digits(scene, actions):
    params, options, state = world(scene)
    reference = Reference(params, state[0])
    scatter = options[0]

    def draws(i):
        if scatter is None:
            return reference.p["restitution"], 0
        first, second = normal_pair(7, i + 1)
        return min(1.0, max(0.0, params["restitution"] + scatter["restitution"] * first)), scatter["normal"] * second

    for cycle, action in enumerate(actions):
        before = len(reference.impacts)
        reference.cycle(demanded(np.asarray(action, float), params), draws)
        reference.impacts[before:] = [(cycle, *row) for row in reference.impacts[before:]]
    _, _, impacts = run(scene, actions)
    assert len(impacts) == len(reference.impacts) >= 50
    assert np.array_equal(impacts[:, 0], [row[0] for row in reference.impacts])
    error = np.array(
        [
            [float(mine - theirs) for mine, theirs in zip(a[1:4], b[1:4], strict=True)]
            for a, b in zip(impacts, reference.impacts, strict=True)
        ]
    )
    time, x, z = np.abs(error).max(axis=0)
    print(f"largest error over {len(error)} impacts: time {time:.1e} s, x {x:.1e} m, z {z:.1e} m")
    assert np.abs(error[:, 0]).max() < 1e-13
    assert np.abs(error[:, 1:]).max() < 1e-13


GRAVITY = 9.81


def still_frame(acceleration_z, **overrides):
    """A smooth scene whose bar moves up and down only, with peak acceleration `acceleration_z` at action 0."""
    return {"scatter": None, "z_acceleration": acceleration_z, **overrides}


def period_one_phase(acceleration, restitution):
    """Luck and Mehta: cos(phase) = pi g (1 - alpha) / (1 + alpha) / Acc, phase of sin(2 omega t + pi/2)."""
    return math.acos(math.pi * GRAVITY * (1 - restitution) / (1 + restitution) / acceleration)


@pytest.mark.parametrize(("acceleration", "restitution"), [(8.0, 0.75), (5.0, 0.75), (6.0, 0.856), (10.0, 0.68)])
def test_period_one_orbit_is_the_closed_form(acceleration, restitution):
    params, _, impacts = run(still_frame(acceleration, restitution=restitution), np.zeros((400, 6)))
    w = params["omega"]
    phase = np.mod(2 * w * impacts[-50:, 1] + math.pi / 2, 2 * math.pi)
    assert np.abs(phase - period_one_phase(acceleration, restitution)).max() < 1e-13
    # approach velocity: half a z period of free fall either way, less the bar's velocity at the impact
    period = math.pi / w
    bar = acceleration / (2 * w) * math.cos(phase[-1])
    assert impacts[-1, 4] == pytest.approx(-GRAVITY * period / 2 - bar, rel=1e-13)


@pytest.mark.parametrize(("restitution", "bound"), [(0.75, 10.94), (0.856, 10.16), (0.68, 11.74)])
def test_period_one_flips_where_the_formula_says(restitution, bound):
    formula = (
        math.pi
        * GRAVITY
        * math.hypot(
            (1 - restitution) / (1 + restitution), 2 * (1 + restitution**2) / (math.pi * (1 + restitution) ** 2)
        )
    )
    assert formula == pytest.approx(bound, abs=0.01)
    for factor, stable in [(0.995, True), (1.005, False)]:
        _, _, impacts = run(still_frame(factor * formula, restitution=restitution), np.zeros((3000, 6)))
        spread = np.ptp(np.mod(impacts[-8:, 1], 1 / 30))
        assert (spread < 1e-6) == stable


@pytest.mark.parametrize("acceleration", [10.4, 15.0, 20.0])
def test_a_stuck_ball_is_released_at_the_phase_of_free_fall(acceleration):
    """The first impact after a release follows from the release phase arcsin(g / Acc) alone: solve for it here."""
    import mpmath as mp

    scene = still_frame(acceleration, restitution=0.1)
    params, _, impacts = run(scene, np.zeros((60, 6)))
    w = 2 * params["omega"]
    amplitude = acceleration / w**2
    mp.mp.dps = 30
    phase = mp.asin(mp.mpf(GRAVITY) / acceleration)
    t0 = phase / w
    v0 = amplitude * w * mp.cos(phase)

    def gap(t):
        return amplitude * (mp.sin(phase) - mp.sin(w * t)) + v0 * (t - t0) - mp.mpf(GRAVITY) / 2 * (t - t0) ** 2

    step, t = mp.mpf(1) / 15 / 4000, t0 + mp.mpf(1) / 15 / 200
    while gap(t) > 0:
        t += step
    landing = mp.findroot(gap, (t - step, t), solver="illinois", tol=mp.mpf(10) ** -50, verify=False)
    expected = float(mp.fmod(landing * w, 2 * mp.pi))
    phases = np.mod(w * impacts[40:, 1] + math.pi / 2, 2 * math.pi)
    assert np.abs(phases - expected).min() < 1e-12 * max(1.0, expected)
    # every release is the same, so the same landing comes back in every cycle of the locked orbit
    assert (np.abs(phases - expected) < 1e-11).sum() >= 10


def test_a_ball_rests_for_good_where_the_bar_never_falls_away():
    params, state, impacts = run(still_frame(4.0), np.zeros((150, 6)))
    assert state["resting"] == 1
    assert state["lost"] == 0
    assert impacts[-1, 0] < 30
    # it is carried: at the start of a cycle the bar is at its amplitude, at rest
    assert state["z"] == pytest.approx(params["z_centre"], rel=1e-14)
    assert state["w"] == pytest.approx(0.0, abs=1e-15)


def test_elastic_ball_on_a_still_bar_keeps_its_energy():
    scene = still_frame(0.0, restitution=1.0, z_acceleration_span=1.0)
    _, _, impacts = run(scene, np.zeros((150, 6)))
    assert len(impacts) >= 290
    assert np.ptp(impacts[:, 4]) < 1e-14


def test_a_ball_without_restitution_sticks_at_once():
    _, state, impacts = run(still_frame(4.0, restitution=0.0), np.zeros((5, 6)))
    assert len(impacts) == 1
    assert state["resting"] == 1


def test_tangential_loss_takes_its_part_at_each_impact():
    scene = still_frame(8.0, tangential_loss=0.25)
    params, options, state = world(scene)
    state["u"] = 0.01
    before = int(state["impacts"][0])
    advance(state[0], np.zeros(6), params, *options)
    n = int(state["impacts"][0]) - before
    assert n >= 1
    assert state["u"][0] == pytest.approx(0.01 * 0.75**n, rel=1e-14)


def test_a_gripping_sphere_rolls_at_five_sevenths():
    params, options, state = world({"base": "rolling", "scatter": None})
    state["u"] = 0.01
    advance(state[0], np.zeros(6), params, *options)
    assert state["u"][0] == pytest.approx(0.01 * 5 / 7, rel=1e-14)
    assert state["spin"][0] == pytest.approx(0.01 * 5 / 7, rel=1e-14)


def test_a_sphere_at_rest_rolls_down_a_tilted_bar():
    """A bar that oscillates in tilt only, too gently to throw the ball: d'' = (5/7) g sin(tilt) + ..., integrated."""
    from scipy.integrate import solve_ivp

    scene = {"base": "rolling", "scatter": None, "z_acceleration": 0.0, "restitution": 0.0, "start_max": 0.004}
    action = np.array([0, 0, 0.02, 0.03, 0, 0])
    params, options, state = world({**scene, "half_length": 0.05})
    for _ in range(2):
        advance(state[0], action, params, *options)
    assert state["resting"][0]
    d, rate = float(state["d"][0]), float(state["rate"][0])
    w, k, radius = params["omega"], 0.4, options[1]["radius"]
    _, _, cos, sin, _, _ = demanded(action, params)

    def law(t, y):
        tilt = cos * math.cos(w * t) + sin * math.sin(w * t)
        turn = w * (sin * math.cos(w * t) - cos * math.sin(w * t))
        return [y[1], (GRAVITY * math.sin(tilt) + y[0] * turn**2 + k * radius * w**2 * tilt) / (1 + k)]

    advance(state[0], action, params, *options)
    truth = solve_ivp(law, (0, params["period"]), [d, rate], method="DOP853", rtol=1e-13, atol=1e-18).y[:, -1]
    assert state["d"][0] == pytest.approx(truth[0], rel=1e-10)
    assert state["rate"][0] == pytest.approx(truth[1], rel=1e-10)


@pytest.mark.parametrize("scene", ["bell", "rolling"])
def test_the_ball_is_never_inside_the_bar(scene):
    rng = np.random.default_rng(4)
    params, options, state = world(scene)
    for key in range(40):
        state[:] = np.zeros((), state.dtype)
        state["key"] = key
        TASK.start(state[0], params, *options)
        for _ in range(60):
            advance(state[0], rng.uniform(-1, 1, 6), params, *options)
            if state["lost"][0]:
                break
            m = state["motion"][0]
            surface = m[4] - (state["x"][0] - m[0]) * math.tan(m[2])
            assert state["z"][0] - surface > -1e-15
        assert state["fault"][0] == 0
