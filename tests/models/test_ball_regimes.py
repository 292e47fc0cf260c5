"""Impact times in every regime of the bouncing ball against 40 digits, and the release after chatter."""

import dataclasses
import math

import mpmath as mp
import numpy as np
import pytest

from vr_envs.bench.accuracy.ball_on_bar_reference import Reference
from vr_envs.envs.ball_on_bar import TASK
from vr_envs.envs.scene import resolve
from vr_envs.models.ball_on_bar import LOGGED, advance, interval
from vr_envs.models.drive import demanded
from vr_envs.models.record import dtype_of

GRAVITY = 9.81
STILL = np.zeros(6)


@dataclasses.dataclass(frozen=True)
class Regime:
    """A smooth scene, the action held, how the ball starts, and how many cycles have passed before the comparison."""

    scene: dict
    period: int  # impacts after which the orbit repeats, 0 if it does not
    action: np.ndarray = dataclasses.field(default_factory=lambda: STILL)
    height: float = 0.0  # m, apex above the bar's middle in place of the period-one start
    x: float = 0.0
    periods: int = 1  # of z between two impacts at the start
    settled: int = 400
    cycles: int = 26


REGIMES = {
    "period one": Regime({"z_acceleration": 10.4, "restitution": 0.68}, 1),
    "period two": Regime({"z_acceleration": 11.95, "restitution": 0.68}, 2),
    "period three": Regime({"z_acceleration": 11.11, "restitution": 0.68}, 3, height=2.05e-3),
    "m = 2": Regime({"z_acceleration": 11.5, "restitution": 0.75, "frequency": 10.0}, 1, periods=2, cycles=51),
    "chatter, rest and release": Regime({"z_acceleration": 20.0, "restitution": 0.5}, 0, settled=30, cycles=30),
    "tilting bar with x-motion": Regime({}, 0, np.array([0.4, 0, 0.1, 0.5, 0, 0]), x=0.011, settled=0),
    "sphere on a lens, limited grip": Regime(
        {"spin": True, "curve": True, "friction": {"coefficient": 0.05, "restitution": 0.3}},
        0,
        np.array([0.2, -0.1, 0.1, 0.2, 0, 0]),
        x=0.015,
        settled=0,
    ),
    "softening, own frequencies, ramp": Regime(
        {
            "softening": True,
            "frequencies": {"x": 0.7, "tilt": 1.3, "z": 2.0},
            "ramp": {"z_cos": 0.3, "tilt_sin": 5.0},
            "restitution": 0.85,
        },
        0,
        np.array([0.3, 0.1, 0.1, 0.1, 0, 0]),
        x=0.004,
        settled=0,
    ),
}


def begin(regime):
    scene = {"scatter": None, "start_min": regime.x, "start_max": regime.x, **regime.scene}
    params, options = resolve(TASK, scene).records()
    state = np.zeros(1, dtype_of(TASK.state))
    TASK.start(state[0], params, *options)
    if regime.height:
        state["z"], state["w"] = regime.height, 0.0
    if (
        regime.periods > 1
    ):  # Luck and Mehta: launched with g m T/2 where cos(phase) = m pi g (1 - alpha)/(1 + alpha)/Acc
        w, m = 2 * params["omega"], regime.periods
        alpha, acceleration = params["restitution"], params["z_acceleration"]
        phase = math.acos(m * math.pi * GRAVITY * (1 - alpha) / (1 + alpha) / acceleration)
        since, launch = (math.pi / 2 - phase) / w, GRAVITY * m * math.pi / w
        state["z"] = params["z_centre"] * math.sin(phase) + launch * since - GRAVITY / 2 * since**2 + 1e-5
        state["w"] = launch - GRAVITY * since
    for _ in range(regime.settled):
        advance(state[0], regime.action, params, *options)
        state["steps"] += 1
    return params, options, state


def logged_cycle(state, action, params, options):
    log = np.zeros((3000, len(LOGGED)))
    before = int(state["impacts"][0])
    advance(state[0], action, params, *options, log)
    state["steps"] += 1
    return [log[i % len(log)].copy() for i in range(before, int(state["impacts"][0]))]


@pytest.mark.parametrize("name", REGIMES)
def test_impact_times_match_many_digits(name):
    regime = REGIMES[name]
    params, options, state = begin(regime)
    reference = Reference(params, state[0], dict(zip(TASK.options, options, strict=True)))
    new = demanded(regime.action, params)
    compared, worst, phases = 0, 0.0, []
    for _ in range(regime.cycles):
        mine = logged_cycle(state, regime.action, params, options)
        before = len(reference.impacts)
        reference.cycle(new)
        theirs = reference.impacts[before:]
        assert len(mine) <= len(theirs)  # the end of a chatter is summed, not followed
        assert len(mine) == len(theirs) or state["resting"][0] or reference.releases
        # in order; what the kernel has summed are the last impacts before a rest
        for row in mine:
            errors = [float(mp.mpf(row[0]) - time) for time, *_ in theirs]
            k = int(np.argmin(np.abs(errors)))
            worst = max(worst, abs(errors[k]))
            assert abs(mp.mpf(row[1]) - theirs[k][1]) < 1e-13 and abs(mp.mpf(row[2]) - theirs[k][2]) < 1e-13
        compared += len(mine)
        phases += [row[0] * 2 * params["omega"] for row in mine]
    print(f"{name}: {compared} impacts, largest error of the time {worst:.1e} s")
    assert compared >= 50
    assert worst < 1e-13
    if regime.period:
        turned = np.cos(phases)
        assert np.abs(turned[regime.period :] - turned[: -regime.period]).max() < 1e-7
        for shorter in range(1, regime.period):
            assert np.abs(turned[shorter:] - turned[:-shorter]).max() > 1e-2
    if "release" in name:
        assert len(reference.releases) >= 5


@pytest.mark.parametrize("acceleration", [9.9, 10.4, 15.0, 30.0, 100.0])
def test_after_chatter_the_ball_is_released_at_the_phase_of_free_fall(acceleration):
    """The moment of release, found as the moment at which the state ceases to rest: arcsin(g / Acc) to 1e-12."""
    params, options, state = begin(
        Regime({"z_acceleration": acceleration, "restitution": 0.2}, 0, settled=0, height=1e-3)
    )
    motion = demanded(STILL, params)
    found = []
    for _ in range(200):
        before = state.copy()

        def resting(until, before=before):
            state = before.copy()
            interval(state[0], motion, params, *options, None, until)
            return bool(state["resting"][0])

        times = np.linspace(0.0, params["period"], 60)
        flags = [resting(t) for t in times]
        for a, b, was, still in zip(times, times[1:], flags, flags[1:], strict=False):
            if was and not still:
                low, high = a, b
                while high - low > 1e-17 and 0.5 * (low + high) not in (low, high):
                    middle = 0.5 * (low + high)
                    low, high = (middle, high) if resting(middle) else (low, middle)
                found.append(math.fmod(2 * params["omega"] * high + math.pi / 2, 2 * math.pi))
        advance(state[0], STILL, params, *options)
        state["steps"] += 1
        if len(found) > 3:
            break
    assert found
    assert np.abs(np.array(found) - math.asin(GRAVITY / acceleration)).max() < 1e-12
