"""Every trial in small, and that what judges can fail: broken kernels and broken states are told."""

import dataclasses
import importlib.util
import sys

import numpy as np
import pytest
from numba.core.caching import NullCache

from vr_envs.bench.stress import autopilot, ball_gap, ball_grazing, ball_on_bar, ball_walk, ride_check, same_bytes
from vr_envs.bench.stress.rows_walk import UNIFORM, Settings, judge, nothing
from vr_envs.bench.stress.trial import UNTRACED, Outcome, share_below, slowest_step
from vr_envs.bench.stress.trials import TRIALS
from vr_envs.envs.scene import resolve
from vr_envs.envs.terrain_ride import TASK as RIDE
from vr_envs.models.jit import kernel
from vr_envs.models.record import dtype_of

# which other tests compile, or which compile soon; the loops of the others take half a minute
LIGHT = {
    "ball-grazing": 20, "ball-chatter": 40, "ball-losses": 6, "ball-motions": 1, "ball-speeds": 10, "ball-dropped": 6,
    "ball-lens": 20, "aircraft-turns": 2, "same-bytes": 5,
}  # fmt: skip


@pytest.mark.parametrize(
    "name", [name if name in LIGHT else pytest.param(name, marks=pytest.mark.slow) for name in TRIALS]
)
def test_a_trial_finds_no_failure(name):
    trial = TRIALS[name]
    outcome = trial.run(0, LIGHT.get(name, 3), UNTRACED)
    assert outcome.failures == [] and outcome.count > 0
    assert outcome.met > 0 or not trial.met
    if outcome.times.any():
        assert 0.0 < share_below(outcome.times, 0.5) <= 1.1 * outcome.slowest[0][0]


@pytest.mark.parametrize("name", ["ball-grazing", "ball-speeds"])
def test_a_case_follows_from_its_number_alone(name):
    run = TRIALS[name].run
    together, parts = run(3, 4, UNTRACED), Outcome()
    for first, number in ((5, 2), (3, 2)):
        parts.add(run(first, number, UNTRACED))
    assert (together.count, together.worst, together.worst_seed) == (parts.count, parts.worst, parts.worst_seed)
    assert together.times.sum() == parts.times.sum()


def test_the_slowest_step_is_the_least_of_several_runs():
    trial = TRIALS["ball-grazing"]
    outcome = trial.run(0, 5, UNTRACED)
    seconds, seed = slowest_step(trial, outcome)
    assert 0 <= seed < 5 and 0.0 < seconds < 1.0


def copy_of(module, monkeypatch, **patched):
    """A copy of a module whose kernels are compiled with other globals, and not taken from the cache."""
    spec = importlib.util.spec_from_file_location(f"{module.__name__}_broken", module.__file__)
    copied = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, copied)
    spec.loader.exec_module(copied)
    for value in vars(copied).values():
        if hasattr(value, "py_func") and value.py_func.__module__ == spec.name:
            value._cache = NullCache()
    vars(copied).update(patched)
    return copied


@kernel
def blind(piece, limits, tan, s, frame, end, x, z, u, w, gravity, contact, curve, textbook):
    return False, end - s


@kernel
def early(piece, limits, tan, s, frame, end, x, z, u, w, gravity, contact, curve, textbook):
    return True, 1e-3 * (end - s)


@pytest.mark.parametrize(("broken", "reason"), [(blind, "missed"), (early, "no contact")])
def test_a_search_that_misses_contacts_or_makes_them_up_is_told(broken, reason, monkeypatch):
    outcome = copy_of(ball_grazing, monkeypatch, flight=broken).run(7, 3, UNTRACED)
    assert {failure.seed for failure in outcome.failures} <= {7, 8, 9}
    assert any(reason in failure.reason for failure in outcome.failures)


def test_how_deep_a_flight_goes_is_found_to_the_tolerance():
    """A ball of 2 m/s over a still bar that comes down by 1e-6 m more than it rose."""
    still = (0.0,) * 6
    course = ball_gap.Course(94.0, 0.0, 0.03, still, still, 0.0)
    back = 2.0 * 2.0 / 9.81
    flight = ball_gap.Flight(0.0, 0.1, 0.0, 0.3, 2.0, 9.81)
    assert ball_gap.deepest(course, flight, 0.0, back, 1e-12) < 1e-15
    depth = ball_gap.deepest(course, flight, 0.0, back + 5e-7, 1e-3)
    assert depth == pytest.approx(1e-6, rel=1e-5)
    assert 1e-12 < ball_gap.deepest(course, flight, 0.0, back + 5e-7, 1e-12) < 1.1e-6


def test_a_ride_that_is_not_where_it_should_be_is_told():
    """A mass on its spring, swinging freely: 0.01 s of a cosine."""
    scene = resolve(RIDE, {**dict.fromkeys(("bumps", "payload", "lag", "preview", "noise")), "damping_low": 1e-3})
    params, _ = scene.records()
    before = np.zeros(1, dtype_of(RIDE.state))[0]
    before["travel"], before["to_knot"] = 0.03, 0.1
    action, facts = np.array([-1.0, 0.0]), ride_check.facts_of(scene)
    angle = np.sqrt(scene.params.w2) * 0.01

    def judged(**changes):
        after = before.copy()
        after["travel"], after["velocity"] = 0.03 * np.cos(angle), -0.03 * np.sqrt(scene.params.w2) * np.sin(angle)
        for name, change in changes.items():
            after[name] += change
        return ride_check.check(before, after, action, params, facts)

    code, apart, _ = judged()
    assert code == 0 and apart < 1e-5  # of the damping, 1e-3 1/s
    assert ride_check.REASONS[judged(travel=1e-5)[0] - 1].startswith("the motion")
    assert ride_check.REASONS[judged(side=1.0)[0] - 1].startswith("a stop")


def lowered(number):
    """A kernel that moves the ball as `advance` does, and in an interval that is judged in full puts it elsewhere."""

    @kernel
    def broken(
        state, action, params, scatter, spin, friction, softening, curve, frequencies, ramp, sensing, camera, textbook,
        log,
    ):  # fmt: skip
        ball_walk.advance(
            state, action, params, scatter, spin, friction, softening, curve, frequencies, ramp, sensing, camera,
            textbook, log,
        )  # fmt: skip
        if state.steps == ball_walk.RESTS and number == 0:
            state.z -= 1e-9
        elif state.steps == ball_walk.RESTS and number == 1:
            state.w += 1e-9
        elif state.steps == ball_walk.RESTS:
            state.lost = True

    broken._cache = NullCache()
    return broken


@pytest.mark.slow
@pytest.mark.parametrize(
    ("number", "reason"),
    [(0, "a flight does not end"), (1, "a flight does not end"), (2, "lost, but over the bar")],
)
def test_a_ball_that_is_not_where_it_should_be_is_told(number, reason, monkeypatch):
    broken = copy_of(ball_walk, monkeypatch, advance=lowered(number))
    monkeypatch.setattr(ball_on_bar, "judge", broken.judge)
    monkeypatch.setattr(ball_on_bar, "Settings", broken.Settings)
    failures = ball_on_bar.runs(ball_on_bar.dropped)(0, 6, UNTRACED).failures
    assert failures and all(failure.reason.startswith(reason) for failure in failures)


@kernel
def undefined(state, settings, step):
    if step == 2:
        state.travel = np.nan


@kernel
def never_content(before, state, action, params, facts):
    return 1, 0.5, True


@kernel
def content(before, state, action, params, facts):
    return 0, 0.5, True


@pytest.mark.parametrize(
    ("prepare", "check", "reason"),
    [
        (undefined, content, "a reward is not in [0, 1], at step 2"),
        (nothing, never_content, "so it is, at step 0"),
        (nothing, content, ""),
    ],
)
def test_a_walk_tells_numbers_that_are_not_finite_and_what_the_check_says(prepare, check, reason):
    outcome = Outcome()
    judge(
        RIDE, {"base": "lecture"}, Settings(5, 8, UNIFORM, 1, (0.0,)), outcome, UNTRACED, prepare, check, ("so it is",)
    )
    assert [failure.seed for failure in outcome.failures] == [5] * bool(reason)
    assert all(failure.reason.startswith(reason) for failure in outcome.failures)
    assert outcome.worst == 0.5 and outcome.met == outcome.judged > 0


def wrong_at_first():
    """A kernel that observes zeros, but something undefined at the start of an episode."""

    @kernel
    def observe(state, row, params, *options):
        row[:] = 0.0
        if state.steps == 0:
            row[0] = np.nan

    observe._cache = NullCache()
    return observe


@pytest.mark.slow
def test_an_observation_that_is_wrong_at_a_reset_alone_is_told():
    task, outcome = dataclasses.replace(RIDE, observe=wrong_at_first()), Outcome()
    judge(task, {"base": "lecture"}, Settings(5, 8, UNIFORM, 1, (0.0,)), outcome, UNTRACED, nothing, content, ())
    assert [failure.reason.partition(" is")[0] for failure in outcome.failures] == ["a number of the observation"]


def test_flights_that_differ_or_are_undefined_are_told():
    before, one, many = (np.zeros(2, dtype_of(autopilot.TASK.state)) for _ in range(3))
    one["heading"], many["heading"], one["altitude"] = np.pi, -np.pi, 3.0
    many["altitude"] = 3.0 + 4e-6
    assert autopilot.difference(before, one, many) == pytest.approx(1e-6)
    many["speed"][1] = one["speed"][1] = np.nan
    assert not autopilot.difference(before, one, many) < 1e-9


def test_one_other_byte_is_told():
    flight = same_bytes.Flight(np.zeros((4, 3, 2)), np.zeros((4, 3)), np.zeros((4, 3), bool), np.zeros(3))
    assert same_bytes.same(flight, flight, slice(None))
    for part in range(4):
        other = same_bytes.Flight(*(array.copy() for array in flight))
        other[part].view(np.uint8).flat[-1] ^= 1
        assert not same_bytes.same(flight, other, slice(None))
