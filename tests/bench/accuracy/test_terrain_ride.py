"""The ride of `bench accuracy`: its reference against closed forms, and the orders of what it is compared with."""

import dataclasses
import math

import numpy as np
import pytest
from mpmath import mp, mpf

from vr_envs.bench.accuracy import terrain_ride_scipy
from vr_envs.bench.accuracy.loops import driven, episode_loop
from vr_envs.bench.accuracy.terrain_ride import advance, advance_in_steps, chipmunk, look
from vr_envs.bench.accuracy.terrain_ride_episodes import ENERGY, SCENARIOS, SEEN, TICK, Judge, episode_of
from vr_envs.bench.accuracy.terrain_ride_mujoco import simulated
from vr_envs.bench.accuracy.terrain_ride_reference import DIGITS, Ride, series_root
from vr_envs.bench.accuracy.terrain_ride_scipy import integrated
from vr_envs.models.constants import G

EXACT, STEPPED = episode_loop(advance, look), episode_loop(advance_in_steps, look)
TICKS = 60  # of the episodes here, a change of the suspension and contacts among them


def short(name, ticks=TICKS):
    episode = episode_of(SCENARIOS[name])
    return dataclasses.replace(episode, actions=episode.actions[:ticks])


EPISODES = {name: short(name) for name in SCENARIOS}
JUDGES = {name: Judge(SCENARIOS[name], episode) for name, episode in EPISODES.items()}


def stepped(name, order, each, located=False):
    """What the compiled loop makes of an episode in so many steps per tick."""
    e = EPISODES[name]
    arguments = (e.params, *e.parts, order, TICK / each, located)
    return driven(STEPPED, e.start, e.actions, len(SEEN), 1, arguments)


def orders(name, order, each, located=False):
    """Of all errors, between two numbers of steps per tick."""
    coarse, fine = (np.array(list(JUDGES[name](stepped(name, order, n, located)).values())) for n in each)
    return np.log(coarse / fine) / math.log(each[1] / each[0])


def reference(name):
    e = EPISODES[name]
    return Ride(e.start, e.scene.params, e.scene.options, e.knots)


def test_a_root_is_the_first_one_even_between_samples():
    with mp.workdps(DIGITS):
        dip = [(mpf(0.301) * mpf(0.302)) * mpf(2), -(mpf(0.301) + mpf(0.302)) * 2, mpf(2)]  # two roots close together
        assert abs(series_root(dip, mpf(1)) - mpf(0.301)) < mpf(10) ** -35
        assert series_root([mpf(1), mpf(-1)], mpf(1) / 2) is None
        assert abs(series_root([mpf(0), mpf(1), mpf(-4)], mpf(1)) - mpf(1) / 4) < mpf(10) ** -35  # it begins at 0


def test_the_reference_begins_with_its_digits():
    """Whatever mpmath's own number of digits is."""
    found = []
    for digits in (15, 60):
        with mp.workdps(digits):
            found.append(reference("lecture").y)
    assert found[0] == found[1]
    ride = reference("lecture")
    with mp.workdps(DIGITS):
        true = sum(size * sine for size, _, sine, _ in ride.waves)
        assert abs(ride.y[2] - true) < mpf(10) ** -38


def test_ringing_is_a_damped_cosine():
    ride, actions = reference("ringing"), EPISODES["ringing"].actions
    seen = ride.drive(actions)
    with mp.workdps(DIGITS):
        gamma, w2 = ride.suspension([mpf(-1), mpf(0)])
        w, t = mp.sqrt(w2 - gamma**2 / 4), mpf(TICK) * len(actions)
        start = mpf(0.05)
        true = start * mp.exp(-gamma * t / 2) * (mp.cos(w * t) + gamma / (2 * w) * mp.sin(w * t))
        assert abs(seen.travel[-1] - true) < mpf(10) ** -36


def test_sines_carry_the_steady_ride():
    """Free motion decays, and what is left of it after a step is the transfer function's: their difference is free."""
    ride, e = reference("lecture"), EPISODES["lecture"]
    with mp.workdps(DIGITS):
        gamma, w2 = ride.suspension([mpf(float(a)) for a in e.actions[0]])

        def steady(t):
            height = mp.mpc(0)
            for size, number, sine, cosine in ride.waves:
                rate = number * mpf(e.scene.params.speed)
                wave = size * mp.mpc(sine, -cosine) * mp.expj(rate * t)  # its real part is the ground's height
                height += w2 / (w2 - rate**2 + 1j * gamma * rate) * wave
            return mp.re(height)

        def free(t, x, v):
            w = mp.sqrt(w2 - gamma**2 / 4)
            return mp.exp(-gamma * t / 2) * (x * mp.cos(w * t) + (v + gamma * x / 2) / w * mp.sin(w * t))

        height, velocity = ride.y[:2]
        t = 20 * mpf(TICK)
        true = steady(t) + free(t, height - steady(0), velocity - mp.diff(steady, 0))
        ride.drive(e.actions[:20])
        assert abs(ride.y[0] - true) < mpf(10) ** -30


def test_a_wheel_in_the_air_falls_with_its_mass():
    """Off the ground the centre of both masses is a projectile; on it forces are continuous at lift-off and landing."""
    ride = reference("quarter car")
    ride.drive(EPISODES["quarter car"].actions)
    times = [float(t) for name, t in ride.contacts]
    assert [name for name, _ in ride.contacts] == ["tyre"] * len(times) and len(times) >= 8
    ride = reference("quarter car")
    before = int(times[0] / TICK) + 1
    ride.drive(EPISODES["quarter car"].actions[:before])  # in the air
    assert ride.airborne and times[1] > before * TICK
    params, tyre = ride.params, ride.tyre
    both = params.mass + tyre.unsprung_mass
    with mp.workdps(DIGITS):

        def centre():
            return (params.mass * ride.y[1] + mpf(tyre.unsprung_mass) * ride.y[3]) / both

        first, since = centre(), ride.time
        ride._piece(*ride.suspension([mpf(0), mpf(0)]), mpf(times[1] - before * TICK) / 2)
        assert abs(centre() - first + mpf(G) * (ride.time - since)) < mpf(10) ** -35


@pytest.mark.parametrize("name", ["road with stops", "quarter car"])
def test_the_exact_model_is_right_to_rounding(name):
    e = EPISODES[name]
    seen = driven(EXACT, e.start, e.actions, len(SEEN), 2, (e.params, *e.records.values()))
    found = JUDGES[name](seen)
    assert max(found.values()) < 2e-13 and found["travel"] < 2e-15


def test_orders_of_the_steps():
    assert orders("lecture", 1, (100, 1000)) == pytest.approx(1.0, abs=0.02)
    assert orders("lecture", 4, (2, 8)) == pytest.approx(4.0, abs=0.2)
    assert orders("ringing", 4, (2, 8)) == pytest.approx(5.0, abs=0.1)  # its amplification is off by (w h)^6 a step
    for name in ("road with stops", "quarter car"):
        assert orders(name, 1, (100, 1000)) == pytest.approx(1.0, abs=0.2)
        unaware = orders(name, 4, (8, 1000))
        assert (unaware < 3.0).all() and (unaware > 1.0).all()
        assert orders(name, 4, (8, 64), located=True) == pytest.approx(4.0, abs=0.5)


def test_mujoco_makes_the_same_steps():
    """On a road a slide joint and a tendon move by the same rules as the compiled loops, contacts and all."""
    for name in ("road with stops", "quarter car"):
        for integrator, order in {"Euler": 1, "RK4": 4}.items():
            mine, theirs = stepped(name, order, 4), simulated(EPISODES[name], integrator, TICK / 4)()
            assert np.abs(mine[:, :3] - theirs).max() < 1e-8
    drift = JUDGES["ringing"](simulated(EPISODES["ringing"], "RK4", TICK / 4)())[ENERGY.name]
    assert drift == pytest.approx(JUDGES["ringing"](stepped("ringing", 4, 4))[ENERGY.name], rel=0.01)


@pytest.mark.parametrize("name", SCENARIOS)
def test_scipy_agrees(name):
    work = integrated(EPISODES[name], "DOP853", 1e-11)
    assert max(JUDGES[name](work()).values()) < 1e-7
    assert np.array_equal(work(), work())


def test_a_ride_that_scipy_gives_up_is_infinitely_wrong(monkeypatch):
    class Failed:
        success = False

    work = integrated(EPISODES["quarter car"], "LSODA", 1e-11)
    monkeypatch.setattr(terrain_ride_scipy, "solve_ivp", lambda *_, **__: Failed)
    assert set(JUDGES["quarter car"](work()).values()) == {math.inf}


@pytest.mark.parametrize(("name", "least", "most"), [("lecture", 0.9, 1.1), ("quarter car", 0.9, 2.0)])
def test_chipmunk_converges(name, least, most):
    """To first order; on the tyre that comes and goes, whose contact lasts some steps only, faster at first."""
    works = [chipmunk(SCENARIOS[name], EPISODES[name], step) for step in (1e-3, 1.25e-4)]
    coarse, fine = (JUDGES[name](work()) for work in works)
    assert np.array_equal(works[0](), works[0]())
    for error in coarse:
        assert least < math.log(coarse[error] / fine[error]) / math.log(8.0) < most, error


def test_a_run_that_went_astray_is_infinitely_wrong():
    seen = np.full((TICKS, 3), np.nan)
    assert JUDGES["quarter car"](seen) == dict.fromkeys(("travel", "velocity", "weighted acceleration"), math.inf)
