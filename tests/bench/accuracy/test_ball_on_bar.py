"""The ball's reference, its opponents' convergence, and how a run is judged."""

import dataclasses
import math

import mpmath as mp
import numpy as np
import pytest

from vr_envs.bench.accuracy import ball_on_bar, ball_on_bar_mujoco, ball_on_bar_scipy
from vr_envs.bench.accuracy.ball_on_bar_chipmunk import direct, rigid_body
from vr_envs.bench.accuracy.ball_on_bar_episodes import ENERGY, GROWTH, PLACE, TIME, Track, apart, episodes
from vr_envs.bench.accuracy.ball_on_bar_loops import AT_END, CHORD, ROOT, bar
from vr_envs.bench.accuracy.ball_on_bar_reference import Reference
from vr_envs.bench.accuracy.front import order
from vr_envs.bench.accuracy.points import Method, Point
from vr_envs.bench.timing import Spread

RAMP = "x_cos", "x_sin", "tilt_cos", "tilt_sin", "z_cos", "z_sin"
SHORT = {episode.name: episode for episode in episodes(3)}
ORBIT, TILTING = SHORT["period one"], SHORT["tilting bar, an action each cycle"]


@pytest.mark.parametrize(("name", "cycles", "impacts"), [("chaotic", 15, 11), ("chatter and rest", 3, 130)])
def test_reference_has_thirty_digits(name, cycles, impacts):
    """More digits change nothing before the thirtieth, where errors grow and where a chatter is followed to its end."""
    episode, found = {e.name: e for e in episodes(cycles)}[name], []
    for digits in (60, 90):
        reference = Reference(episode.params, episode.states()[0], digits=digits)
        for motion in episode.motions[1:]:
            reference.cycle(motion.tolist())
        assert len(reference.impacts) >= impacts and mp.mp.dps < 60
        assert all(normal < 0 for *_, normal in reference.impacts)
        found.append([number for impact in reference.impacts for number in impact] + [reference.x, reference.z])
    assert max(abs(a - b) for a, b in zip(*found, strict=True)) < mp.mpf(10) ** -30


def test_the_references_bar_moves_as_it_says():
    """Its derivatives against difference quotients, with all that can change its motion."""
    options = {
        "ramp": np.array([(0.1, -0.2, 0.3, 0.05, 0.2, 0.1)], [(k, float) for k in RAMP])[0],
        "frequencies": np.array([(1.1, 0.9, 2.2)], [(k, float) for k in ("x", "tilt", "z")])[0],
    }
    for chosen in ({}, options):
        reference = Reference(TILTING.params, TILTING.states()[0], chosen)
        reference.old = [mp.mpf(v) for v in TILTING.motions[1].tolist()]
        new, reference.number = [mp.mpf(v) for v in TILTING.motions[2].tolist()], 3
        with mp.workdps(60):
            for s in (mp.mpf("0.01"), mp.mpf("0.06")):  # while the motion changes, and after it
                for order in (1, 2):
                    true = [mp.diff(lambda t, i=i: reference.bar(new, t)[i], s, order) for i in range(3)]  # noqa: B023
                    found = reference.bar(new, s, order)
                    assert max(abs(a - b) for a, b in zip(found, true, strict=True)) < mp.mpf(10) ** -25


def test_reference_of_period_one_is_the_closed_form():
    omega, gravity = 2.0 * ORBIT.params["omega"], ORBIT.params["gravity"]
    phase = mp.acos(mp.pi * gravity * (mp.mpf(1) - 0.75) / 1.75 / 8.0)
    true = [
        (k // 2, (phase + mp.mpf(1.5 if k % 2 == 0 else 3.5) * mp.pi) / omega) for k in range(12)
    ]  # z = A sin(omega s + pi/2)
    impacts = ORBIT.reference.impacts
    assert len(impacts) == 12 and np.array_equal(impacts[:, 0], [cycle for cycle, _ in true])
    # the start is rounded, and so is the cycle: to 1e-17 s
    assert max(abs(float(s) - own) for (_, s), own in zip(true, impacts[:, 1], strict=True)) < 3e-17


def test_reference_of_the_elastic_ball_is_the_closed_form():
    episode = {e.name: e for e in episodes(5)}["elastic"]
    fall = math.sqrt(2.0 * 0.01 / 9.81)
    period = float(episode.params["period"])
    times = episode.reference.impacts[:, 0] * period + episode.reference.impacts[:, 1]
    assert times == pytest.approx([fall, 3.0 * fall, 5.0 * fall, 7.0 * fall][: len(times)], rel=1e-14)
    assert len(times) == 4


def points_of(episode, runs):
    """Points without a cost: method by value of the step -> track."""
    method = Method("any", "fixed step", "step", fixed_step=True)
    return [Point(method, episode.name, h, Spread(1.0, 1.0, 1.0), episode.judge(track)) for h, track in runs]


def stepped(episode, location, steps):
    work, _ = ball_on_bar.stepped(episode, location, steps)
    return work()


@pytest.mark.parametrize("measure", [TIME, PLACE], ids=lambda m: m.name)
@pytest.mark.parametrize(("location", "expected"), [(AT_END, 1.0), (CHORD, 2.0)])
def test_split_steps_converge_at_their_order(location, expected, measure):
    period = float(TILTING.params["period"])
    runs = [(period / n, stepped(TILTING, location, n)) for n in np.geomspace(101, 30001, 24).astype(int)]
    assert order(points_of(TILTING, runs), measure) == pytest.approx(expected, abs=0.15)


def test_a_step_split_at_the_root_is_exact_until_it_misses_an_impact():
    fine = TILTING.judge(stepped(TILTING, ROOT, 64))
    assert fine[TIME.name] < 1e-15 and fine[PLACE.name] < 1e-15
    assert TILTING.judge(stepped(TILTING, ROOT, 8))[TIME.name] > 1e-3


@pytest.mark.parametrize(
    ("simulate", "least", "most"),
    [
        (lambda episode, n: rigid_body(episode, float(episode.params["period"]) / n * (1.0 + 1e-9))(), 0.8, 1.2),
        (lambda episode, n: direct(episode, n)(), 0.8, 1.2),
        (lambda episode, n: ball_on_bar_mujoco.simulated(episode, n)(), 0.4, 1.2),
    ],
    ids=["rigid_body", "pymunk", "MuJoCo"],
)
def test_physics_engines_converge(simulate, least, most):
    period = float(TILTING.params["period"])
    points = points_of(
        TILTING, [(period / n, simulate(TILTING, n)) for n in (151, 211, 307, 433, 601, 853, 1201, 1709)]
    )
    assert least < order(points, TIME) < most
    assert least < order(points, PLACE) < most


@pytest.mark.parametrize("solver", ["RK45", "DOP853"])
@pytest.mark.parametrize("name", ["tilting bar, an action each cycle", "chatter and rest", "source"])
def test_scipy_is_right(name, solver):
    found = SHORT[name].judge(ball_on_bar_scipy.simulate(SHORT[name], solver, 1e-9))
    assert all(error < 1e-13 for error in found.values())


@pytest.mark.parametrize("name", SHORT)
def test_exact_is_right(name):
    work, _ = ball_on_bar.compiled(SHORT[name], {})
    found = SHORT[name].judge(work())
    assert set(found) == {measure.name for measure in SHORT[name].judged}
    assert all(error < 1e-14 for error in found.values())
    assert SHORT[name].judge(work()) == found  # a call does not change what the next one begins from


def test_the_opponents_bar_is_the_references():
    reference = Reference(TILTING.params, TILTING.states()[0])
    reference.old = [mp.mpf(v) for v in TILTING.motions[1].tolist()]
    new = [mp.mpf(v) for v in TILTING.motions[2].tolist()]
    omega, period = float(TILTING.params["omega"]), float(TILTING.params["period"])
    for s in period * np.array([0.0, 0.1, 0.3, 0.5, 0.51, 0.8, 1.0]):
        found = bar(tuple(TILTING.motions[1]), tuple(TILTING.motions[2]), s, omega, 0.5 * period)
        true = [*reference.bar(new, mp.mpf(s)), *reference.bar(new, mp.mpf(s), 1)]
        assert found == pytest.approx([float(v) for v in true], rel=1e-12, abs=1e-16)


def test_a_simulator_begins_anew_at_every_call():
    for work in (direct(TILTING, 200), rigid_body(TILTING, 5e-4), ball_on_bar_mujoco.simulated(TILTING, 200)):
        first, second = work(), work()
        assert np.array_equal(first.ends, second.ends) and np.array_equal(first.impacts, second.impacts)


@pytest.mark.parametrize("ratio", [0.0, 0.05, 0.3, 0.8])
def test_rebound_of_a_spring_and_damper(ratio):
    """Against a thousandth of a step of the midpoint rule."""
    restitution, time = ball_on_bar_mujoco.rebound(ratio)
    x, v, h, t = 0.0, -1.0, 1e-4, 0.0
    while x + 2.0 * ratio * v < 0.0 or t == 0.0:
        middle = x + 0.5 * h * v, v - 0.5 * h * (x + 2.0 * ratio * v)
        x, v, t = x + h * middle[1], v - h * (middle[0] + 2.0 * ratio * middle[1]), t + h
    assert (restitution, time) == pytest.approx((v, t), abs=2e-4)


def test_contact_without_a_damper_to_match_is_refused():
    with pytest.raises(ValueError, match="restitution = 0.1"):
        ball_on_bar_mujoco.contact_of(0.1, 1e-4)


def test_impacts_that_are_missed_or_invented_show():
    true = np.array([[0.0, 0.01, -0.2], [0.0, 0.05, -0.2], [1.0, 0.01, -0.01]])
    assert apart(true, true, 0.1, 0.0) == 0.0
    assert apart(true, true[:2], 0.1, 0.0) == pytest.approx(0.06)  # the last is missed
    assert apart(true, true[:2], 0.1, 0.05) == 0.0  # but too slow to count
    assert apart(true, true[:0], 0.1, 0.0) == math.inf
    late = true + [0.0, 1e-12, 0.0]
    assert apart(true, late, 0.1, 0.0) == pytest.approx(1e-12, rel=1e-3)


def test_judges_measure_what_they_say():
    episode = dataclasses.replace(SHORT["source"], judged=(TIME, PLACE, GROWTH, ENERGY))
    true = episode.reference
    assert {k: v for k, v in episode.judge(true).items() if k != ENERGY.name} == {
        TIME.name: 0.0,
        PLACE.name: 0.0,
        GROWTH.name: 0.0,
    }
    moved = Track(true.impacts, true.ends * [math.exp(0.3), 1.0, 1.0, 1.0])
    assert episode.judge(moved)[GROWTH.name] == pytest.approx(0.3 / episode.seconds, rel=1e-12)
    assert episode.judge(moved)[PLACE.name] == pytest.approx(
        (math.exp(0.3) - 1.0) * np.abs(true.ends[:, 0]).max(), rel=1e-12
    )
    assert set(episode.judge(Track(true.impacts, true.ends * math.nan)).values()) == {math.inf}
    beyond = Track(true.impacts, true.ends * [-1.0, 1.0, 1.0, 1.0])
    assert episode.judge(beyond)[GROWTH.name] == episode.judge(Track(true.impacts, 0.0 * true.ends))[GROWTH.name]
    assert episode.judge(beyond)[GROWTH.name] == math.inf
    rest = SHORT["elastic"]
    below = Track(rest.reference.impacts, np.array([[0.0, -0.01, 0.0, 0.2]] * 3))
    assert rest.judge(below)[ENERGY.name] == math.inf
    faster = Track(rest.reference.impacts, np.array([[0.0, 0.01, 0.0, 0.2]] * 3))
    assert rest.judge(faster)[ENERGY.name] == pytest.approx(0.02, rel=1e-12)
