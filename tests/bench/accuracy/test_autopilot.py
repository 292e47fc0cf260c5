"""The aircraft of `bench accuracy`: its reference against closed forms, and the orders of what it is compared with."""

import math

import numpy as np
import pytest
from mpmath import mp, mpf

from vr_envs.bench.accuracy import autopilot_scipy
from vr_envs.bench.accuracy.autopilot import (
    ALTITUDE,
    EPISODES,
    HEADING,
    PARTS,
    SEEN,
    START,
    TRACK,
    advance,
    advance_in_steps,
    judged,
    look,
    start,
)  # fmt: skip
from vr_envs.bench.accuracy.autopilot_reference import DIGITS, Flight
from vr_envs.bench.accuracy.loops import driven, episode_loop
from vr_envs.models.autopilot import Params
from vr_envs.models.autopilot_options import OPTIONS, Energy, Lags, Shear, Track, Turbulence, Wind
from vr_envs.models.record import pack

PARAMS = Params()
MEASURES = (ALTITUDE, HEADING, TRACK)
ACTIONS = np.repeat(np.random.default_rng(4).uniform(-0.6, 0.6, (3, 3)), 2, axis=0)
EXACT, STEPPED = episode_loop(advance, look), episode_loop(advance_in_steps, look)


def records(name):
    return {k: pack(option) for k, option in EPISODES[name][1].items()}


def errors(name, seen):
    """Of `MEASURES`, one number each."""
    reference = Flight(PARAMS, EPISODES[name][1], START).fly(ACTIONS)
    return np.array(list(judged(reference, MEASURES, seen).values()))


def stepped(name, order, step, located=False):
    parts = tuple(records(name).get(k) for k in PARTS)
    return errors(name, driven(STEPPED, start(), ACTIONS, 5, 1, (pack(PARAMS), *parts, order, step, located)))


def orders(name, order, steps, located=False):
    found = [stepped(name, order, step, located) for step in steps]
    return np.log(found[0] / found[-1]) / math.log(steps[0] / steps[-1])


def test_the_lecture_is_an_integral_in_closed_form():
    """x + iz' parts of the integral of (v + a t) e^(i (psi + w t)), by parts."""
    action = np.array([[0.5, -0.75, 0.6]])
    (altitude, speed, heading, x, z) = Flight(PARAMS, {"track": Track()}, START).fly(action)[0]
    with mp.workdps(DIGITS):
        a, w = -mpf(0.75) * mpf(0.6), mpf(0.6) * mpf(PARAMS.turn)
        assert altitude == 3000 + mpf(13) / 2 and abs(speed - (150 + a)) < 1e-37
        assert abs(heading - (mpf(0.5) + w)) < 1e-37
        begin, end = mp.expj(mpf(0.5)), mp.expj(mpf(0.5) + w)
        way = (speed * end - 150 * begin) / (1j * w) + a * (end - begin) / w**2
        assert abs(mp.mpc(z, x) - way) < mpf(10) ** -34


def test_lags_wind_and_shear_satisfy_the_differential_equations():
    """Against mpmath's own integrator over an interval without corners; the energy's share binds the acceleration."""
    lags, wind, shear = Lags(), Wind(), Shear(gradient=0.02, origin=0.7)
    flight = Flight(PARAMS, {"lags": lags, "wind": wind, "shear": shear, "energy": Energy(), "track": Track()}, START)
    action = np.array([[0.25, 0.75, 0.2]])
    found = flight.fly(action)[0]
    with mp.workdps(20):
        goals = [mpf(13) / 4, min(mpf(0.75) * 0.6, mpf(9.80665) / 150 * (13 - mpf(13) / 4)), mpf(0.2) * PARAMS.turn]

        def slopes(_, y):
            gain = y[1] + shear.gradient * y[0] * mp.cos(y[5] - shear.origin)
            x = y[4] * mp.sin(y[5]) - shear.gradient * y[3] * mp.sin(shear.origin) - wind.speed * mp.sin(wind.origin)
            z = y[4] * mp.cos(y[5]) - shear.gradient * y[3] * mp.cos(shear.origin) - wind.speed * mp.cos(wind.origin)
            bends = [(g - r) / c for g, r, c in zip(goals, y, (lags.vertical, lags.along, lags.turn), strict=False)]
            return [*bends, y[0], gain, y[2], x, z]

        ends = mp.odefun(slopes, 0, [0, 0, 0, 3000, 150, mpf(0.5), 0, 0])(1)[3:]
        assert max(abs(a - b) for a, b in zip(found, ends, strict=True)) < mpf(10) ** -14


def test_a_limited_lag_ramps_and_then_closes_in():
    """Full climb from level flight: the limit acts until the gap is what the lag closes at that rate."""
    lags = Lags()
    rows = Flight(PARAMS, {"lags": lags, "track": Track()}, START).fly(np.tile([1.0, 0.0, 0.0], (9, 1)))
    with mp.workdps(DIGITS):
        slew, constant = mpf(lags.vertical_slew), mpf(lags.vertical)
        ramp = 13 / slew - constant
        rest = (1 - mp.exp((ramp - 9) / constant)) * constant
        climbed = slew * ramp**2 / 2 + 13 * (9 - ramp) - slew * constant * rest
        assert abs(rows[-1][0] - 3000 - climbed) < mpf(10) ** -35


@pytest.mark.parametrize("options", [{"turbulence": Turbulence()}, {}])
def test_the_reference_refuses_what_it_does_not_know(options):
    with pytest.raises(ValueError, match="without turbulence"):
        Flight(PARAMS if options else Params(dt=0.5), options, START)


def test_the_exact_model_is_right_to_rounding():
    name, packed = "airliner", records("airliner")
    seen = driven(EXACT, start(), ACTIONS, len(SEEN), 2, (pack(PARAMS), *(packed.get(k) for k in OPTIONS)))
    assert (errors(name, seen) < [5e-12, 2e-15, 1e-11]).all()


def test_orders_of_the_steps():
    """The track of the lecture; with lags the limits bend the rates within a step, unless the corners are met."""
    assert orders("lecture", 1, (1e-2, 1e-3))[2] == pytest.approx(1.0, abs=0.02)
    assert orders("lecture", 4, (1.0, 0.25))[2] == pytest.approx(4.0, abs=0.1)
    assert orders("airliner", 1, (1e-2, 1e-3)) == pytest.approx(1.0, abs=0.1)
    assert orders("airliner", 4, (0.25, 0.0625), located=True) == pytest.approx(4.0, abs=0.2)
    unaware = orders("airliner", 4, (0.25, 0.25 / 64))
    assert (unaware < 3.0).all() and (unaware > 1.3).all()


@pytest.mark.parametrize("method", ["RK45", "DOP853", "LSODA"])
def test_scipy_agrees(method):
    parts = tuple(records("airliner").get(k) for k in PARTS)
    work = autopilot_scipy.integrated(start(), ACTIONS, pack(PARAMS), parts, method, 1e-11)
    assert (errors("airliner", work()) < [1e-7, 1e-9, 1e-6]).all()
    assert np.array_equal(work(), work())


def test_a_flight_that_scipy_gives_up_is_infinitely_wrong(monkeypatch):
    class Failed:
        success = False

    monkeypatch.setattr(autopilot_scipy, "solve_ivp", lambda *_, **__: Failed)
    parts = tuple(records("airliner").get(k) for k in PARTS)
    seen = autopilot_scipy.integrated(start(), ACTIONS, pack(PARAMS), parts, "LSODA", 1e-11)()
    assert (errors("airliner", seen) == math.inf).all()
