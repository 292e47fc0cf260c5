import math

import numpy as np
import pytest

from vr_envs.controllers.bar_design import Design
from vr_envs.controllers.bell_sink import BellSink, parabolic_action
from vr_envs.controllers.policy import Constant
from vr_envs.envs.ball_on_bar import TASK, BallOnBarBatchEnv
from vr_envs.envs.scene import resolve
from vr_envs.models.ball_on_bar import demanded

SINK, SOURCE = 0.5 * math.pi, -0.5 * math.pi
BELL = {"x": 4.0, "tilt": 50.0, "z": 8.0, "phase": SINK}


def bell(scene=None, **changes):
    return parabolic_action(resolve(TASK, scene), **{**BELL, **changes})


@pytest.mark.parametrize("scene", [None, "rolling", {"frequency": 22.0, "x_acceleration": 25.0, "z_acceleration": 9.0}])
@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"phase": SOURCE},
        {"x": 7.0, "tilt": 90.0, "z": 10.5, "phase": 0.7},
        {"x": 0.0, "tilt": 0.0, "z": 6.0, "phase": -2.5},
    ],
)
def test_the_motion_is_bells(scene, changes):
    """x = A_x sin(w t + pi/2), z = A_z sin(2 w t + pi/2), tilt = A_tilt sin(w t + phase), over one cycle."""
    resolved = resolve(TASK, scene)
    params, _ = resolved.records()
    xc, xs, tc, ts, zc, zs = demanded(bell(scene, **changes), params)
    p, wanted = resolved.params, {**BELL, **changes}
    w = p.omega
    t = np.linspace(0.0, p.period, 101)
    x = wanted["x"] / w**2 * np.sin(w * t + math.pi / 2)
    tilt = wanted["tilt"] / w**2 * np.sin(w * t + wanted["phase"])
    z = wanted["z"] / (2 * w) ** 2 * np.sin(2 * w * t + math.pi / 2)
    assert np.abs(xc * np.cos(w * t) + xs * np.sin(w * t) - x).max() < 1e-14 * p.x_span
    assert np.abs(tc * np.cos(w * t) + ts * np.sin(w * t) - tilt).max() < 1e-14 * p.tilt_span
    assert np.abs(zc * np.cos(2 * w * t) + zs * np.sin(2 * w * t) - z).max() < 1e-14 * (p.z_centre + p.z_span)


@pytest.mark.parametrize("scene", TASK.scenes)
def test_no_phase_draws_the_ball_in_faster_than_the_computed_one(scene):
    resolved = resolve(TASK, scene)
    law, design = BellSink(resolved), Design(resolved)
    rates = [design.growth(bell(scene, phase=phase)) for phase in np.linspace(-math.pi, math.pi, 50)]
    assert design.growth(law.action) <= min(rates) + 1e-8
    assert max(rates) > min(rates)


def test_the_computed_phase_is_a_sink_where_the_bar_moves_along_x_and_the_ball_does_not_spin():
    rates = {name: Design(resolve(TASK, name)).growth(BellSink(resolve(TASK, name)).action) for name in TASK.scenes}
    assert rates["bell"] < -0.005 and rates["lens"] < 0.0
    assert rates["bell-2dof"] > 0.0 and rates["rolling"] > 0.002


def test_without_a_period_one_orbit_the_phase_is_bells():
    scene = {"z_acceleration": 3.0, "z_acceleration_span": 0.0}
    assert BellSink(resolve(TASK, scene)).action == pytest.approx(bell(scene))


STARTS = np.array([-0.012, -0.006, -0.003, 0.003, 0.006, 0.012])


def run(law, scene, cycles):
    """Records of balls displaced by `STARTS`, from the documented start, after each cycle."""
    env = BallOnBarBatchEnv(len(STARTS), scene=scene, autoreset_mode="DISABLED")
    env.reset(seed=0)
    states = env.get_state()
    states["x"] = STARTS
    env.set_state(states)
    live = np.ones(len(STARTS), bool)
    for _ in range(cycles):
        env.world.step(np.tile(law.action, (len(STARTS), 1)).astype(float), live, cycles + 1)
    return env.get_state()


def test_one_phase_is_a_sink_and_the_other_a_source():
    scene = {"scatter": None}
    sink, source = (run(Constant(bell(scene, phase=phase)), scene, 100) for phase in (SINK, SOURCE))
    assert not sink["lost"].any()
    assert (np.abs(sink["x"]) < 0.5 * np.abs(STARTS)).all()
    assert (np.sign(source["x"]) == np.sign(STARTS)).all()
    assert ((source["lost"] == 1) | (np.abs(source["x"]) > 2.0 * np.abs(STARTS))).all()
    assert source["lost"][[0, -1]].all()


def test_amplitudes_beyond_the_box_are_clipped():
    assert bell(x=50.0, tilt=1e4, z=99.0, phase=-0.75 * math.pi).tolist() == [1.0, 0.0, -1.0, -1.0, 1.0, 0.0]
    assert bell(z=-99.0)[4] == -1.0


def test_both_parts_of_the_tilt_reach_the_corner_of_the_box_within_the_gains():
    largest = BellSink.TUNABLE["tilt_acceleration"][1]
    for phase in (0.25 * math.pi, -0.75 * math.pi):
        assert np.abs(bell(tilt=largest, phase=phase)[2:4]) == pytest.approx([1.0, 1.0], rel=1e-12)


@pytest.mark.parametrize("end", [0, 1, 2])
def test_every_gain_gives_an_action_in_the_box(end):
    law = BellSink(resolve(TASK), **{name: limits[end] for name, limits in BellSink.TUNABLE.items()})
    law.reset(5)
    actions = law(np.zeros((5, 10), np.float32))
    assert actions.shape == (5, 6) and actions.dtype == np.float32
    assert (np.abs(actions) <= 1.0).all() and (actions == actions[0]).all()


@pytest.mark.parametrize(
    ("span", "channels"), [("x_acceleration", [0, 1]), ("tilt_acceleration", [2, 3]), ("z_acceleration_span", [4, 5])]
)
def test_a_motion_without_a_range_is_asked_for_nothing(span, channels):
    free, fixed = (bell(scene, z=9.0, phase=0.7) for scene in (None, {span: 0}))
    others = [k for k in range(6) if k not in channels]
    assert fixed[channels].tolist() == [0.0, 0.0]
    assert (fixed[others] == free[others]).all()
    assert BellSink(resolve(TASK, {span: 0})).action[channels].tolist() == [0.0, 0.0]
