import math

import numpy as np
import pytest
from scipy.integrate import quad_vec
from scipy.linalg import expm, solve_continuous_are

from vr_envs.controllers.terrain_ride_design import optimal_feedback, plant_of, rises_ahead, transition
from vr_envs.envs.scene import resolve
from vr_envs.envs.terrain_ride import TASK, TerrainRideEnv
from vr_envs.envs.terrain_ride_observation import read

PLAIN = {"bumps": None, "stop": None, "payload": None, "lag": None, "noise": None}
CAR = plant_of(resolve(TASK, "quarter-car"))
ACTIVE = plant_of(resolve(TASK, "active"))
FOLLOWER = plant_of(resolve(TASK, {"actuation": "active"}))


@pytest.mark.parametrize("tyre", [None, True])
def test_the_linear_ride_is_the_environments(tyre):
    """Force, payload and a slope of the road: one interval of the environment is `transition`, to rounding."""
    scene = {**PLAIN, "actuation": "active", "tyre": tyre, "passive_damping": 2.0, "dt": 0.013, "preview": None}
    env = TerrainRideEnv(scene=scene)
    env.reset(seed=0)
    plant = plant_of(env.world.scene)
    free, force, load, road = transition(plant, 0.013)
    state = env.get_state()
    x = np.array([0.01, 0.1, -0.002, 0.2])[: plant.width]
    state["travel"], state["velocity"], state["payload"] = x[0], x[1], 0.7
    if tyre:
        state["deflection"], state["hub_velocity"] = x[2], x[3]
    state["knots"] = 0.02 * np.arange(len(state["knots"]))
    env.set_state(state)
    env.step(np.array([-0.4]))
    after = env.get_state()
    rise = 0.02 / 0.2 * 20.0 * 0.013
    expected = free @ x - 0.4 * env.world.scene.params.push * force + 0.7 * load + rise * road
    found = [after[name] for name in ("travel", "velocity", "deflection", "hub_velocity")][: plant.width]
    assert found == pytest.approx(expected, rel=1e-11, abs=1e-13)


@pytest.mark.parametrize(
    ("travel", "tyre", "gain"),
    [
        (400.0, 16000.0, (-11012, 1842.6, -1761.1, -640.7)),
        (1e3, 1e4, (-7641.4, 2289.6, 2736.1, -523.8)),
        (1e4, 1e5, (12188, 4242.5, -13313, -1522)),
    ],
)
def test_gain_of_a_quarter_car(travel, tyre, gain):
    """290/59 kg, 16812 and 190000 N/m, no damper, in N, without holding: extrapolated to an interval of 0."""
    coarse, fine = (optimal_feedback(CAR, travel, tyre, dt, 0)[0] for dt in (2e-5, 1e-5))
    assert 290 * (2 * fine - coarse) == pytest.approx(gain, rel=1e-4)


def test_gain_tends_to_the_continuous_one_with_the_interval():
    felt, weight = ACTIVE.felt[:, None], np.diag([1000.0, 0, 1e4, 0])
    cost = solve_continuous_are(ACTIVE.a, ACTIVE.force[:, None], felt @ felt.T + weight, np.eye(1), s=felt)
    exact = ACTIVE.force @ cost + ACTIVE.felt
    errors = [np.abs(optimal_feedback(ACTIVE, 1000.0, 1e4, dt, 0)[0] - exact).max() for dt in (4e-4, 2e-4, 1e-4)]
    assert errors[0] / errors[1] == pytest.approx(2.0, abs=0.1)
    assert errors[1] / errors[2] == pytest.approx(2.0, abs=0.05)


def test_gain_over_a_following_wheel_is_a_closed_form():
    """With all of v' to choose: v' = -sqrt(q) u - sqrt(2 sqrt(q)) v, so f is that less spring and damper."""
    q = 1111.0
    found, _ = optimal_feedback(FOLLOWER, q, 0.0, 1e-6, 0)
    w2, gamma = 16812 / 290, 1.0
    assert found == pytest.approx([math.sqrt(q) - w2, math.sqrt(2 * math.sqrt(q)) - gamma], rel=1e-4)


@pytest.mark.parametrize("plant", [ACTIVE, FOLLOWER], ids=["quarter car", "follower"])
@pytest.mark.parametrize("lag", [None, 0.015])
def test_gains_are_the_minimum_by_least_squares(plant, lag):
    """The best first command over 3 s, all 150 of them free, the road in view and then level; and the cost there."""
    dt, steps, samples, travel, tyre = 0.02, 150, 8, 1111.0, 2e4
    n = plant.width + (lag is not None)
    rng = np.random.default_rng(3)
    y0, rises = rng.normal(size=n) * [0.02, 0.1, 0.005, 0.2, 1.0][:n], 0.01 * rng.normal(size=samples)
    a = np.zeros((n + 2, n + 2))
    a[: plant.width, : plant.width], a[: plant.width, n + 1] = plant.a, plant.road / dt
    pusher = n if lag is None else n - 1
    a[: plant.width, pusher] = plant.force
    if lag is not None:
        a[n - 1, n - 1], a[n - 1, n] = -1 / lag, 1 / lag
    felt = np.zeros(n + 2)
    felt[: plant.width], felt[pusher], felt[n + 1] = plant.felt, 1.0, plant.jolt / dt
    outputs = np.zeros((3, n + 2))
    outputs[0], outputs[1, 0] = felt, math.sqrt(travel)
    if plant.width > 2:
        outputs[2, 2] = math.sqrt(tyre)
    nodes, shares = np.polynomial.legendre.leggauss(8)
    watch = np.concatenate([math.sqrt(0.5 * dt * s) * outputs @ expm(a * 0.5 * dt * (t + 1))
                            for t, s in zip(nodes, shares, strict=True)])  # fmt: skip
    step = expm(a * dt)
    # state = known part + matrix @ commands
    known, matrix = y0, np.zeros((n, steps))
    rows, constants = [], []
    for k in range(steps):
        rise = rises[k] if k < samples else 0.0
        command = np.zeros(steps)
        command[k] = 1.0
        constants.append(watch[:, :n] @ known + watch[:, n + 1] * rise)
        rows.append(watch[:, :n] @ matrix + np.outer(watch[:, n], command))
        known = step[:n, :n] @ known + step[:n, n + 1] * rise
        matrix = step[:n, :n] @ matrix + np.outer(step[:n, n], command)
    best = np.linalg.lstsq(np.concatenate(rows), -np.concatenate(constants), rcond=None)[0]
    gain, ahead = optimal_feedback(plant, travel, tyre, dt, samples, lag)
    assert -gain @ y0 - ahead @ rises == pytest.approx(best[0], rel=1e-6)


def test_cost_of_the_closed_loop_is_the_riccati_equations():
    """The integral of the cost along the motion from x is x'P x, and a gain that is off costs more."""
    felt, weight = CAR.felt[:, None], np.diag([400.0, 0, 16000.0, 0])
    cost = solve_continuous_are(CAR.a, CAR.force[:, None], felt @ felt.T + weight, np.eye(1), s=felt)
    x = np.array([0.02, 0.1, -0.004, 0.3])

    def spent(gain):
        loop, seen = CAR.a - np.outer(CAR.force, gain), CAR.felt - gain
        rate = lambda t: (lambda y: (seen @ y) ** 2 + y @ weight @ y)(expm(loop * t) @ x)  # noqa: E731
        return sum(quad_vec(rate, t, t + 0.25, epsrel=1e-10)[0] for t in np.arange(0, 12, 0.25))

    gain = optimal_feedback(CAR, 400.0, 16000.0, 1e-5, 0)[0]
    assert spent(gain) == pytest.approx(x @ cost @ x, rel=1e-6)
    assert spent(1.1 * gain) > 1.0001 * spent(gain)


def test_rises_are_those_of_the_preview():
    scene = resolve(TASK)
    row = np.zeros((1, 17))
    heights = np.arange(1, 11) ** 2 / 1000.0
    row[0, 7:] = heights / 0.05
    reading = read(row, scene)
    fine = rises_ahead(reading, scene, 0.03 * np.arange(12))
    assert fine[0] == pytest.approx(np.diff([0.0, *heights, heights[-1]]), abs=1e-12)
    half = rises_ahead(reading, scene, 0.015 * np.arange(4))
    assert half[0] == pytest.approx(np.diff([0.0, 0.0005, 0.001, 0.0025]), abs=1e-12)
    slow = rises_ahead(reading._replace(speed=np.array([10.0])), scene, 0.06 * np.arange(3))
    assert slow[0] == pytest.approx(fine[0, :2], abs=1e-12)
