import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vr_envs.models.record import dtype_of, pack
from vr_envs.models.ride_options import TICK, ActuatorLag
from vr_envs.models.ride_pieces import ride
from vr_envs.models.road import start_road
from vr_envs.models.road_options import Bumps, Road
from vr_envs.models.terrain import Undulation, start_undulation, wave
from vr_envs.models.terrain_ride import Params, State, advance, suspension
from vr_envs.models.travel_stop import TravelStop

STEPS = 1000
OPTIONS = (
    "undulation", "road", "profile", "bumps", "obstacle", "wheel", "tyre", "stop", "lag", "cruise", "textbook",
    "metrics",
)  # fmt: skip


def move(state, action, params, **options):
    """`advance` by one control interval, with the options given."""
    advance(state, action, params, *(options.get(name) for name in OPTIONS))


def fresh(key=5, u=0.02, v=-0.3):
    state = np.zeros(1, dtype_of(State))[0]
    state["key"], state["travel"], state["velocity"] = key, u, v
    return state


def actions(seed=0, width=2):
    """Smooth, over the whole range."""
    t = np.arange(STEPS)[:, None] * TICK
    rng = np.random.default_rng(seed)
    return np.sin(rng.uniform(1, 9, width) * t + rng.uniform(0, 6, width))


def integrate(y, t, suspended, payload, relative, height, slope):
    """zeta, zeta' after the time t by DOP853 at 1e-13; height(s) and slope(s) of the terrain in time."""

    gamma, w2, force = suspended

    def equation(s, y):
        return y[1], force + payload - gamma * (y[1] - relative * slope(s)) - w2 * (y[0] - height(s))

    return solve_ivp(equation, (0, t), y, "DOP853", rtol=1e-13, atol=1e-15).y[:, -1]


def assert_close(got, expected, relative):
    got, expected = np.array(got), np.array(expected)
    assert np.abs(got - expected).max() < relative * np.abs(expected).max()


@pytest.mark.parametrize("damping", ["relative", "absolute"])
def test_over_sines_agrees_with_an_integrator_for_a_whole_episode(damping):
    settings = Params(damping=damping)
    params, sines = pack(settings), pack(Undulation())
    state = fresh()
    start_undulation(state)
    phases = np.arctan2(state["wave_sin"], state["wave_cos"])
    terms = [(*wave(i, sines), p) for i, p in enumerate(phases)]
    now, path = 0.0, []

    def height(s):
        return sum(a * math.sin(k * settings.speed * (now + s) + p) for a, k, p in terms)

    def slope(s):
        return sum(a * k * settings.speed * math.cos(k * settings.speed * (now + s) + p) for a, k, p in terms)

    y = np.array([state["travel"] + height(0.0), state["velocity"]])
    for step, action in enumerate(actions()):
        now = step * TICK
        move(state, action, params, undulation=sines)
        y = integrate(y, TICK, suspension(state, params), 0.0, settings.relative, height, slope)
        path.append((state["travel"] + height(TICK), state["velocity"], *y))
    path = np.array(path)
    assert_close(path[:, :2], path[:, 2:], 1e-11)


@pytest.mark.parametrize("damping", ["relative", "absolute"])
@pytest.mark.parametrize("spacing", [0.2, 0.07])
def test_over_a_road_agrees_with_an_integrator_for_a_whole_episode(damping, spacing):
    settings = Params(damping=damping)
    params, road, bumps = pack(settings), pack(Road(knot_spacing=spacing)), pack(Bumps())
    state = fresh()
    start_road(state, road, None, bumps, None, None)
    state["payload"] = 0.7
    y = np.array([state["travel"] + state["knots"][0], state["velocity"]])
    place, path = 0.0, []
    for action in actions():
        knots, first = state["knots"].copy(), int(place)
        move(state, action, params, road=road, bumps=bumps)
        end, size = place + settings.speed * TICK / spacing, len(knots)
        if abs(end - round(end)) < 1e-9:
            end = round(end)
        while place < end:
            k = int(place)
            stop = min(k + 1, end)
            assert stop - first < size - 1
            left, rise = knots[k % size], knots[(k + 1) % size] - knots[k % size]
            time = (stop - place) * spacing / settings.speed
            y = integrate(
                y,
                time,
                suspension(state, params),
                state["payload"],
                settings.relative,
                lambda s, gone=place - k, left=left, rise=rise: left + rise * (gone + s * settings.speed / spacing),
                lambda s, rise=rise: rise * settings.speed / spacing,
            )
            place = stop
        k = int(place)
        here = knots[k % size] + (knots[(k + 1) % size] - knots[k % size]) * (place - k)
        path.append((state["travel"] + here, state["velocity"], *y))
    path = np.array(path)
    assert_close(path[:, :2], path[:, 2:], 1e-11)


SCENES = {
    "sines": {"undulation": Undulation()},
    "road": {"road": Road(), "bumps": Bumps()},
    "both": {"undulation": Undulation(), "road": Road(knot_spacing=0.07)},
    "stop": {"road": Road(iso_class="E", knot_spacing=0.13), "bumps": Bumps(), "stop": TravelStop()},
}


@pytest.mark.parametrize("scene", SCENES)
def test_half_steps_give_the_same_state(scene):
    params = pack(Params())
    ground = ("undulation", "road", "profile", "bumps", "obstacle", "wheel", "tyre", "stop", "cruise")
    options = tuple(pack(SCENES[scene][name]) if name in SCENES[scene] else None for name in ground)
    whole, halves = fresh(), fresh()
    for state in (whole, halves):
        if options[0] is not None:
            start_undulation(state)
        if options[1] is not None:
            start_road(state, *options[1:6])
    for gamma in np.exp(np.random.default_rng(0).uniform(-1, 3, STEPS)):
        ride(whole, 0.01, gamma, 58.0, 0.3, 20.0, params, *options)
        ride(halves, 0.005, gamma, 58.0, 0.3, 20.0, params, *options)
        ride(halves, 0.005, gamma, 58.0, 0.3, 20.0, params, *options)
        assert halves["travel"] == pytest.approx(whole["travel"], abs=1e-12)
        assert halves["velocity"] == pytest.approx(whole["velocity"], abs=1e-12)
    assert halves["touches"] == whole["touches"]
    assert (whole["touches"] > 10) == (scene == "stop")


def test_a_stop_out_of_reach_changes_no_bit():
    params, road = pack(Params()), pack(Road())
    without, with_stop = fresh(), fresh()
    for state in (without, with_stop):
        start_road(state, road, None, None, None, None)
    for action in actions():
        move(without, action, params, road=road)
        move(with_stop, action, params, road=road, stop=pack(TravelStop(travel=10.0)))
        assert without.tobytes() == with_stop.tobytes()


def test_steady_ride_over_a_sine_has_the_textbook_gain():
    """Long after the start the amplitude is |w2 + i gamma W| / |w2 - W^2 + i gamma W|."""
    params, sines = pack(Params(speed=10.0)), pack(Undulation(wavelength=9.0))
    gamma, w2 = 3.0, 58.0
    state = fresh()
    start_undulation(state)
    for _ in range(2000):
        ride(state, 0.01, gamma, w2, 0.0, 10.0, params, sines, *[None] * 8)
    velocity = 0.0
    for i in range(3):
        a, k = wave(i, sines)
        w = 10.0 * k
        gain = (w2 + 1j * gamma * w) / (w2 - w**2 + 1j * gamma * w)
        velocity += (1j * w * a * gain * (state["wave_cos"][i] + 1j * state["wave_sin"][i])).imag
    assert state["velocity"] == pytest.approx(velocity, rel=1e-10)


def test_flat_ground_and_payload_settle_at_the_static_sag():
    state, params = fresh(u=0.0, v=0.0), pack(Params())
    state["payload"] = -1.0
    for _ in range(6000):
        move(state, np.zeros(2), params)
    assert state["travel"] == pytest.approx(-290.0 / 16812.0, rel=1e-12)
    assert state["velocity"] == pytest.approx(0.0, abs=1e-13)


@pytest.mark.parametrize("time_constant", [1e-4, 0.004, 0.015, 0.3])
def test_actuator_lag_delays_a_step_by_its_time_constant(time_constant):
    """The integral of (command - position held) after a step is T times the step, and each hold is the exact mean."""
    state, params, lag = fresh(), pack(Params()), pack(ActuatorLag(time_constant=time_constant))
    state["position"] = start = np.array([-0.4, 0.9])
    command, missing, before = np.array([1.0, -0.5]), np.zeros(2), start
    for step in range(1200):
        move(state, command, params, lag=lag)
        missing += (command - state["held"]) * TICK
        if step < 5:
            s = (np.arange(20000) + 0.5) / 20000 * TICK
            mean = np.exp(-s / time_constant).mean()
            assert state["held"] == pytest.approx(command + (before - command) * mean, rel=1e-4, abs=1e-12)
        before = state["position"].copy()
    assert missing == pytest.approx(time_constant * (command - start), rel=1e-12)


def test_without_lag_the_command_is_held():
    state = fresh()
    move(state, np.array([0.3, -0.7]), pack(Params()))
    assert state["held"].tolist() == state["position"].tolist() == [0.3, -0.7]


def test_actuator_lag_is_exact_at_the_control_instants():
    state, params, lag = fresh(), pack(Params()), pack(ActuatorLag(time_constant=0.015))
    for step in range(1, 20):
        move(state, np.array([1.0, -0.5]), params, lag=lag)
        filled = 1.0 - math.exp(-step * TICK / 0.015)
        assert state["position"] == pytest.approx([filled, -0.5 * filled], rel=1e-14)


def test_action_maps_to_the_declared_limits():
    settings = Params()
    params, state = pack(settings), fresh()
    for position, damping, modulus in ((-1, 0.3, 0.5), (0, math.sqrt(3.0), 1.0), (1, 10.0, 2.0)):
        state["held"] = position
        assert suspension(state, params) == pytest.approx((damping, modulus * 16812 / 290, 0.0), rel=1e-14)


def test_active_force_is_a_push_beside_the_passive_spring():
    settings = Params(actuation="active")
    params, state = pack(settings), fresh(u=0.0, v=0.0)
    state["payload"] = 0.25
    move(state, np.array([-1.0]), params)
    assert suspension(state, params) == pytest.approx((1.0, 16812 / 290, -1450 / 290))
    assert state["acceleration"] == pytest.approx(-4.75, rel=0.02)


def test_mean_acceleration_and_travel_rate_are_differences():
    params, road = pack(Params()), pack(Road())
    state = fresh()
    start_road(state, road, None, None, None, None)
    before = state.copy()
    move(state, np.array([0.3, -0.2]), params, road=road)
    assert state["acceleration"] * 0.01 == pytest.approx(state["velocity"] - before["velocity"], rel=1e-13)
    assert state["travel_rate"] * 0.01 == pytest.approx(state["travel"] - before["travel"], rel=1e-13)
