"""The autopilot's analytic laws: what each of them promises, and their order on paired flights."""

import math

import numpy as np
import pytest

from tests.controllers.autopilot_world import STILL, flown, world_at
from vr_envs.controllers.autopilot import LAWS
from vr_envs.controllers.autopilot_channels import capture, climb_per_acceleration, power_limits
from vr_envs.controllers.autopilot_linear_quadratic import LinearQuadratic, channel_matrices
from vr_envs.controllers.autopilot_proportional_integral import ProportionalIntegral
from vr_envs.controllers.autopilot_square_root import SquareRoot
from vr_envs.controllers.autopilot_total_energy import TotalEnergy
from vr_envs.controllers.linear_quadratic import riccati
from vr_envs.envs.autopilot import TASK
from vr_envs.envs.autopilot_observation import BAND
from vr_envs.envs.scene import resolve
from vr_envs.evaluation.rollout import rollout
from vr_envs.evaluation.scenarios import scenario_set
from vr_envs.models.lag import clamped_lag

# nothing couples the channels, nothing disturbs them
SEPARATE = {"turbulence": None, "energy": None, "envelope": None, "atmosphere": None, "demands": None}
# and their slews limit nothing
LINEAR = {**SEPARATE, "lags": {"vertical_slew": 50.0, "jerk": 50.0, "roll_in": 0.01}}
SMALL = np.array([5.0, 0.4, 0.003])


@pytest.mark.parametrize("name", list(LAWS))
def test_gains_have_their_defaults_inside_their_ranges_and_actions_are_in_the_box(name) -> None:
    law = LAWS[name]
    assert all(low <= default <= high for low, high, default in law.TUNABLE.values())
    for scene in TASK.scenes:
        policy = law(resolve(TASK, scene))
        policy.reset(8)
        rows = np.random.default_rng(0).uniform(-1.0, 1.0, (8, 23)).astype(np.float32)
        for _ in range(3):
            actions = policy(rows)
            assert actions.shape == (8, 3) and actions.dtype == np.float32
            assert np.all(np.abs(actions) <= 1.0)


@pytest.mark.parametrize("law", [ProportionalIntegral, LinearQuadratic, SquareRoot, TotalEnergy])
def test_a_demand_that_ramps_is_followed_without_an_error(law) -> None:
    world = world_at(np.zeros((1, 3)), {**STILL, "envelope": None})
    world.states["demand_rate"], world.states["next_change"] = [[2.0, 0.05, 0.01]], 1000.0
    world.states["demand_target"] = world.states["demand"] + 1000.0 * world.states["demand_rate"]
    policy = law(world.scene)
    policy.reset(1)
    errors = []
    for _ in range(150):
        world.step(policy(world.observe()).astype(float), np.ones(1, np.bool_), 10**6)
        observed = policy.channels.flight(world.observe())
        errors.append(observed.error[0] / BAND)
    assert np.abs(errors[-1]).max() < 0.3


def test_capture_is_the_curve_of_constant_deceleration_with_a_linear_end() -> None:
    gain, deceleration = np.array([0.2, 0.2, 0.2]), np.array([1.5, 0.15, np.inf])
    error = np.array([[100.0, 10.0, 3.0], [-20.0, 0.5, -1e-3], [0.0, 0.0, 0.0]])
    found = capture(error, gain, np.broadcast_to(deceleration, error.shape))
    np.testing.assert_allclose(found[0], [math.sqrt(2 * 1.5 * (100.0 - 18.75)), math.sqrt(0.3 * (10 - 1.875)), 0.6])
    np.testing.assert_allclose(found[1], [-4.0, 0.1, -2e-4])
    np.testing.assert_array_equal(found[2], 0.0)
    # value and slope are continuous where the pieces meet, at A / k^2 = 37.5 m
    near = capture(np.array([[37.5 - 1e-6] * 3, [37.5] * 3, [37.5 + 1e-6] * 3]), gain, np.full((3, 3), 1.5))[:, 0]
    np.testing.assert_allclose(np.diff(near), 0.2e-6, rtol=1e-4)


@pytest.mark.parametrize("lag", [0.0, 0.3, 2.5])
def test_the_matrices_of_a_channel_are_the_exact_motion(lag) -> None:
    a, b = channel_matrices(lag, 0.7)
    error, rate, last, change = 3.0, 1.2, 0.9, -0.4
    after = a @ [error, rate, last] + b[:, 0] * change
    command = last + change
    if lag:
        expected_rate, gain = clamped_lag(rate, command, lag, 1e9, 0.7)
    else:
        expected_rate, gain = command, 0.7 * command
    np.testing.assert_allclose(after, [error - gain, expected_rate, command], rtol=1e-13)


def test_the_linear_quadratic_law_costs_what_riccati_says() -> None:
    """In flight, without clamps: sum of (e / band)^2 + effort (change / limit)^2 from a small error."""
    world = world_at(SMALL, LINEAR)
    efforts = {"altitude_effort": 2e4, "speed_effort": 3e3, "heading_effort": 1e4}
    law = LinearQuadratic(world.scene, **efforts)
    history, actions = flown(world, law, 600)
    value = np.stack([history[name][:, 0] for name in ("altitude", "speed", "heading")], axis=1)
    errors = history["demand"][0, 0] - value
    # the loop sees float32 actions, whose size depends on the sign only for the climb rate
    commands = np.where(actions[:, 0] > 0.0, 1.0, [10.0 / 13.0, 1.0, 1.0]) * actions[:, 0]
    changes = np.diff(commands, axis=0, prepend=0.0)
    limits = np.array([13.0, 0.6, math.radians(3.0)])
    for k, effort in enumerate(efforts.values()):
        cost = np.sum((errors[:-1, k] / BAND[k]) ** 2) + effort * np.sum(changes[:, k] ** 2)
        a, b = channel_matrices(law.channels.lag[k], 1.0)
        p, _ = riccati(a, b, np.diag([BAND[k] ** -2, 0.0, 0.0]), np.array([[effort / limits[k] ** 2]]))
        assert cost == pytest.approx(p[0, 0] * SMALL[k] ** 2, rel=1e-4)


def test_the_square_root_law_closes_in_with_its_time_constant() -> None:
    world = world_at(SMALL, LINEAR)
    law = SquareRoot(world.scene, altitude_time=9.0, speed_time=11.0, heading_time=7.0)
    law.lead = law.channels.lag
    history, _ = flown(world, law, 60)
    value = np.stack([history[name][:, 0] for name in ("altitude", "speed", "heading")], axis=1)
    errors = (history["demand"][0, 0] - value)[30:40]
    # held for an interval the lead cancels the lag but for its square: e(k + 1) / e(k) is that of the sampled loop
    for k, time in enumerate((9.0, 11.0, 7.0)):
        gain = -math.expm1(-1.0 / time)
        a, b = channel_matrices(law.channels.lag[k], 1.0)
        row = np.array([gain, -gain * law.channels.lag[k], 0.0])
        closed = a[:, :2] @ np.eye(2, 3) + b @ row[None]  # the new command is the row, not a change
        slowest = np.abs(np.linalg.eigvals(closed[:2, :2])).max()
        np.testing.assert_allclose(errors[1:, k] / errors[:-1, k], slowest, rtol=2e-3)
        assert -1.0 / math.log(slowest) == pytest.approx(time, rel=0.25)


@pytest.mark.parametrize("law", [ProportionalIntegral, LinearQuadratic, SquareRoot, TotalEnergy])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_step_that_saturates_the_command_ends_without_overshoot(law, sign) -> None:
    step = sign * np.array([600.0, 15.0, math.radians(90.0)])
    world = world_at(step, SEPARATE)
    history, actions = flown(world, law(world.scene), 200)
    assert np.all(np.abs(actions[3:10]) == 1.0)
    value = np.stack([history[name][:, 0] for name in ("altitude", "speed", "heading")], axis=1)
    left = (history["demand"][0, 0] - value) / step
    assert left.min() > -np.max(np.array(BAND) / np.abs(step)) * 0.5  # half the band
    assert np.all(np.abs(left[-1] * step) < BAND)


def test_without_anti_windup_the_integral_overshoots() -> None:
    """What the integral law's zone and conditional integration are for."""
    step = np.array([600.0, 15.0, math.radians(90.0)])
    errors = []
    for zone in (3.0, 1e9):
        world = world_at(step, SEPARATE)
        law = ProportionalIntegral(world.scene, integral_time=20.0)
        law.zone = law.zone * zone / 3.0
        if zone > 3.0:  # and integrate through the limits
            law.channels.flight = lambda rows, flight=law.channels.flight: flight(rows)._replace(
                falling=np.full((1, 3), 1e9), rising=np.full((1, 3), 1e9)
            )
            law.channels.actions = lambda commands, _: np.clip(
                commands / [13.0, 0.6, math.radians(3.0)], -1.0, 1.0
            ).astype(np.float32)
        history, _ = flown(world, law, 300)
        errors.append((history["demand"][0, 0, 0] - history["altitude"][:, 0]).min())
    assert errors[0] > -BAND[0] and errors[1] < -100.0


def test_the_integral_removes_the_error_of_a_steady_disturbance() -> None:
    errors = []
    for time in (60.0, 1e9):
        world = world_at(np.zeros((1, 3)), SEPARATE)
        law = ProportionalIntegral(world.scene, integral_time=time)
        law.reset(1)
        for _ in range(400):
            world.step(law(world.observe()).astype(float), np.ones(1, np.bool_), 10**6)
            world.states["altitude"] -= 1.0  # sinking air
        errors.append(abs(world.states["demand"][0, 0] - world.states["altitude"][0]))
    assert errors[0] < 0.1 and errors[1] > 5.0


def test_the_total_energy_law_never_asks_for_more_than_the_power() -> None:
    scene = resolve(TASK, "airliner")
    law = TotalEnergy(scene)
    law.reset(4000)
    rows = np.random.default_rng(1).uniform(-1.0, 1.0, (4000, 23)).astype(np.float32)
    flight = law.channels.flight(rows)
    commands = law.commands(flight)
    power = commands[:, 0] + commands[:, 1] * climb_per_acceleration(flight)
    lowest, highest = power_limits(flight, scene)
    plain = flight.clipped(SquareRoot(scene).commands(flight))
    asked = plain[:, 0] + plain[:, 1] * climb_per_acceleration(flight)
    assert np.all(power <= highest + 1e-9) and np.all(power >= lowest - 1e-9)
    bound = (asked > highest) | (asked < lowest)
    assert 0.1 < bound.mean() < 0.9
    np.testing.assert_allclose(commands[~bound], plain[~bound], rtol=1e-12)
    # all of the power is used where more is asked, and no command grows or changes its sign
    np.testing.assert_allclose(power[bound], np.where(asked > highest, highest, lowest)[bound], rtol=1e-9)
    assert np.all(commands * plain >= 0.0) and np.all(np.abs(commands) <= np.abs(plain) + 1e-12)


@pytest.mark.parametrize(("priority", "first"), [(4.0, 1), (-4.0, 0)])
def test_the_priority_says_who_climbs_or_accelerates_first(priority, first) -> None:
    """1000 m are further than 5 m/s, which are 77 m of energy height."""
    world = world_at([1000.0, 5.0, 0.0], {**STILL, "demands": None})
    law = TotalEnergy(world.scene, priority=priority)
    flight = law.channels.flight(world.observe())
    wanted, given = flight.clipped(SquareRoot.commands(law, flight))[0], law.commands(flight)[0]
    assert given[first] == pytest.approx(wanted[first], rel=1e-3) and given[1 - first] < 0.8 * wanted[1 - first]


def test_late_instruments_are_made_good_for() -> None:
    """In calm air, with perfect but late instruments, the law flies almost as with prompt ones."""
    perfect = dict.fromkeys(("altitude", "airspeed", "heading", "vertical_speed", "acceleration", "turn_rate"), 0.0)
    scores = []
    for delay in (0, 4):
        scene = {"turbulence": None, "sensing": {**perfect, "delay": delay}}
        scenarios = scenario_set("Autopilot", scene, n=24, side="training")
        scores.append(rollout(TotalEnergy(scenarios.scene), scenarios).scores)
        if delay:
            blind = TotalEnergy(scenarios.scene)
            blind.channels.delay = 0
            scores.append(rollout(blind, scenarios).scores)
    prompt, late, ignorant = np.mean(scores, axis=1)
    assert late == pytest.approx(prompt, abs=0.015) and ignorant < prompt - 0.03


def test_channels_are_carried_on_by_the_very_motion_of_the_aircraft() -> None:
    perfect = dict.fromkeys(("altitude", "airspeed", "heading", "vertical_speed", "acceleration", "turn_rate"), 0.0)
    world = world_at([[500.0, 10.0, 1.0]], {"turbulence": None, "sensing": {**perfect, "delay": 3}})
    world.states["past"][:] = 0.0
    world.states["past"][:, 0, :3] = [5000.0, world.states["demand"][0, 1] - 10.0, 0.0]
    law = SquareRoot(world.scene)
    law.reset(1)
    for _ in range(12):
        world.step(law(world.observe()).astype(float), np.ones(1, np.bool_), 10**6)
    flight = law.channels.flight(world.observe())
    state = world.states[0]
    assert flight.error[0, 0] == pytest.approx(state["demand"][0] - state["altitude"], rel=1e-3)
    assert flight.error[0, 2] == pytest.approx(state["demand"][2] - state["heading"], rel=1e-3)
    rates = [state[name] for name in ("vertical_speed", "acceleration", "turn_rate")]
    assert flight.rate[0] == pytest.approx(rates, rel=1e-2)


def test_stronger_laws_score_more_on_paired_flights() -> None:
    scenarios = scenario_set("Autopilot", STILL, n=48, side="training")
    scores = {name: rollout(law(scenarios.scene), scenarios).scores for name, law in LAWS.items()}
    lecture, integral, root, energy = (
        scores[name] for name in ("lecture", "proportional-integral", "square-root", "total-energy")
    )
    assert np.mean(integral - lecture) > 0.1 and np.mean(root - lecture) > 0.2
    assert np.mean(energy - root) > 0.0
