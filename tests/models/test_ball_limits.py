"""Balls that once never came to an end: searches, chatters and rests at the edge of what the kernels bound."""

import numpy as np
import pytest

from vr_envs.envs.ball_on_bar import TASK
from vr_envs.envs.scene import resolve
from vr_envs.models.ball_on_bar import advance
from vr_envs.models.bar import Piece, bounds, frame_at
from vr_envs.models.flight import AIRBORNE, RELEASED, flight
from vr_envs.models.record import dtype_of

STILL_BAR = (0.0,) * 6


def states_of(scene, count, cycles, draw, seed=0, x=0.0):
    """Records of `count` balls after `cycles` intervals of the actions that `draw(generator)` gives."""
    params, options = resolve(TASK, scene).records()
    states = np.zeros(count, dtype_of(TASK.state))
    generator = np.random.default_rng(seed)
    for i, state in enumerate(states):
        state["key"], state["x"], state["z"] = seed + i, x, 0.004
        for _ in range(cycles):
            advance(state, draw(generator), params, *options)
            state["steps"] += 1
    return states


def test_samples_end_where_the_interval_ends():
    _, options = resolve(TASK, {"scatter": None}, engine="textbook").records()
    end = 1.0 / 15.0
    times = np.random.default_rng(0).uniform(0.0, end, 100_000)
    short = times[times + (end - times) < end]
    assert len(short) > 5  # the time left, added again, is rounded to before the end
    piece = Piece(2.0 * np.pi * 15.0, 0.0, 0.0, STILL_BAR, STILL_BAR, None, (0.0, 0.0, 0.0), None)
    for s in short[:20]:
        frame = frame_at(piece, s)
        found = flight(piece, bounds(piece), 0.0, s, frame, end, 0.0, 1.0, 0.0, 0.0, 9.81, AIRBORNE, None, options[-1])
        assert found == (False, end - s)


def test_an_impact_in_the_last_digit_of_an_interval_is_left_to_the_next():
    """A loop without losses, whose impacts fall on the ends of the base cycles."""
    scene = {"restitution": 1.0, "scatter": None, "textbook": True}
    params, options = resolve(TASK, scene).records()
    state = np.zeros((), dtype_of(TASK.state))[()]
    state["z"], state["w"] = 0.00022515818587186362, -0.16350000000000006
    state["motion"][4] = 0.00022515818587186178
    for _ in range(50):
        advance(state, np.zeros(6), params, *options)
        state["steps"] += 1
        assert not state["fault"]
    assert state["impacts"] <= 101


@pytest.mark.slow
def test_the_textbook_engine_moves_every_ball_over_thousands_of_cycles():
    states = states_of({"textbook": True, "half_length": 1.0, "start_max": 0.01}, 1, 5000, lambda g: np.zeros(6))
    assert states["steps"][0] == 5000 and states["impacts"][0] > 9000


def test_a_ball_lies_on_a_bar_that_moves_at_twenty_times_the_base_frequency():
    scene = {"scatter": None, "frequencies": {"x": 20.0}, "tilt_acceleration": 1.0, "z_acceleration": 1.0, "hold": 3.0}
    state = states_of({**scene, "restitution": 0.0}, 1, 4, lambda g: np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]))[0]
    assert state["resting"] and not state["fault"]


@pytest.mark.parametrize("base", ["bell", "rolling"])
def test_a_ball_that_moves_along_a_rough_bar_with_friction_comes_to_rest(base):
    scene = {"base": base, "friction": True, "half_length": 1.0, "scatter": {"normal": 0.004}}
    states = states_of(scene, 40, 40, lambda g: np.array([0.0, 0.0, 1.0, 0.0, -1.0, 0.0]) * g.uniform(0.0, 1.0))
    assert not states["fault"].any()
    assert states["impacts"].max() < 40 * 300


@pytest.mark.parametrize("spin", [None, {"inertia_ratio": 0.4}])
@pytest.mark.parametrize("coefficient", [0.02, 0.3])
def test_friction_in_the_last_of_a_chatter_is_that_of_its_impacts(spin, coefficient):
    scene = {"friction": {"coefficient": coefficient}, "spin": spin, "half_length": 1.0, "z_acceleration": 3.0}
    scene["restitution"] = 0.5
    smooth = {"restitution": 0.0, "normal": 0.0}  # the chatter of a scattered scene is closed earlier

    def end_of(scatter):
        params, options = resolve(TASK, {**scene, "scatter": scatter}).records()
        state = np.zeros((), dtype_of(TASK.state))[()]
        state["z"], state["u"] = 0.001, 0.05
        advance(state, np.array([0.0, 0.0, 0.1, 0.0, 0.0, 0.0]), params, *options)
        state["steps"] += 1
        advance(state, np.array([0.0, 0.0, 0.1, 0.0, 0.0, 0.0]), params, *options)
        assert state["resting"]
        return np.array([state["d"], state["rate"], state["spin"]])

    assert np.abs(end_of(smooth) - end_of(None)).max() < 1e-7


def test_a_rolling_ball_has_the_spin_of_its_place_at_the_end_of_every_interval():
    """With a limit to the grip as without: the next interval would begin with a slip that never was."""
    drawn = {"draw": lambda g: np.array([0.3, 0.0, 0.4, 0.2, -1.0, 0.0]), "x": 0.005}
    scene = {"base": "rolling", "scatter": None, "half_length": 1.0}
    free = states_of(scene, 1, 12, **drawn)[0]
    limited = states_of({**scene, "friction": {"coefficient": 10.0}}, 1, 12, **drawn)[0]
    assert free["resting"] and limited["resting"]
    for name in ("x", "z", "u", "w", "spin", "d", "rate"):
        assert abs(free[name] - limited[name]) < 1e-9, name


def test_a_ball_that_flies_off_a_convex_bar_is_lost():
    """Faster than sqrt(g / curvature), it never meets the parabola."""
    scene = {"scatter": None, "tangential_loss": 0.0, "curve": {"curvature": -40.0}}
    params, options = resolve(TASK, scene).records()
    state = np.zeros((), dtype_of(TASK.state))[()]
    state["x"], state["z"], state["u"] = 0.02, 0.005, 1.0
    advance(state, np.zeros(6), params, *options)
    assert not state["lost"]
    for _ in range(4):
        advance(state, np.zeros(6), params, *options)
    assert state["lost"] and not state["fault"] and state["x"] < 1.0


@pytest.mark.parametrize("excess", [0.0, 2e-15, 1e-11])
@pytest.mark.parametrize("options", [{}, {"spin": True}, {"friction": True}, {"curve": {"curvature": 5.0}}])
def test_a_bar_that_just_reaches_free_fall_is_no_fault(options, excess):
    """The supporting force has a double root at the crest, where the base cycle ends."""
    scene = {"scatter": None, "restitution": 0.0, "z_acceleration": 9.81 + excess, **options}
    params, records = resolve(TASK, scene).records()
    state = np.zeros((), dtype_of(TASK.state))[()]
    state["z"], state["motion"][4] = 0.002, (9.81 + excess) / (60.0 * np.pi) ** 2
    for _ in range(40):
        advance(state, np.zeros(6), params, *records)
        state["steps"] += 1
    assert not state["fault"] and abs(state["x"]) < 1e-12


def test_a_ball_that_may_slip_as_it_leaves_goes_on():
    """Force and grip vanish together; the search for the end of the grip once stood still there."""
    scene = {
        "gravity": 0.9322519888194638, "restitution": 0.0, "start_max": 0.002, "start_min": 0.0, "scatter": None,
        "spin": True, "friction": True, "curve": {"curvature": 20.0},
    }  # fmt: skip
    params, records = resolve(TASK, scene).records()
    state = np.zeros((), dtype_of(TASK.state))[()]
    state["x"], state["z"], state["u"] = -6.188767145798984e-06, 0.0008265436961189614, -0.0003511591072491478
    state["w"], state["spin"] = 0.00023165315844544607, -0.0003151586356481081
    state["motion"][4], state["steps"] = 0.00022515818587186178, 7
    advance(state, np.zeros(6), params, *records)
    assert not state["fault"] and not state["resting"] and state["impacts"] == 1


def test_a_softened_ball_that_moves_along_a_rough_bar_comes_to_rest():
    scene = {"base": "rolling", "friction": True, "half_length": 1.0, "softening": {"speed": 0.003, "exponent": 1.0}}
    states = states_of(scene, 20, 40, lambda g: np.array([0.0, 0.0, 1.0, 0.0, -1.0, 0.0]) * g.uniform(0.0, 1.0))
    assert not states["fault"].any()
    assert states["impacts"].max() < 40 * 300


@pytest.mark.parametrize("before", [1e-4, 1e-6, 1e-8, 1e-10])
def test_a_ball_released_just_before_the_bar_presses_again_is_met_by_it_at_once(before):
    """The gap is -N s^2/2 - N' s^3/6 with N = -N' before: its root is at 3 before, its largest value N' before^3/3."""
    omega, acceleration = 2.0 * np.pi, 20.0
    motion = (0.0, 0.0, 0.0, 0.0, acceleration / (2.0 * omega) ** 2, 0.0)
    piece = Piece(omega, 0.0, 0.0, motion, motion, None, (0.0, 0.0, 0.0), None)
    s = np.arccos(9.81 / acceleration) / (2.0 * omega) - before
    frame = frame_at(piece, s)
    z, w = frame.z[0], frame.z[1]
    hit, ds = flight(piece, bounds(piece), 0.0, s, frame, 1.0, 0.0, z, 0.0, w, 9.81, RELEASED, None, None)
    passed = frame_at(piece, s + ds).z[0] - (z + (w - 0.5 * 9.81 * ds) * ds)
    assert hit and passed < 1e-16
    assert ds == pytest.approx(3.0 * before, rel=1e-2, abs=1e-6)
