"""The simulation of the ball on a lens: what a run hands back."""

import numpy as np
import pytest

from vr_envs.experiments.lens_orbit import period_one_start
from vr_envs.experiments.lens_simulation import simulate
from vr_envs.models.ball_on_lens import Params, State
from vr_envs.models.ball_options import Spin
from vr_envs.models.lens_flight import surface_height


def test_a_run_knows_where_the_ball_is_at_any_time():
    params = Params()
    run = simulate(params, period_one_start(params, x=0.008, v=0.05), 30)
    places = run.position(run.times)
    assert np.allclose(places[:, 0], run.impacts["x"], rtol=0, atol=1e-15)
    just_before = run.position(run.times - 1e-9)
    assert np.abs(just_before - places).max() < 1e-9
    end = run.position(np.array([30 * params.period, 30 * params.period + 1e-9]))
    assert end[0] == pytest.approx([run.end["x"], run.end["y"], run.end["z"]], abs=1e-15)
    assert np.isnan(end[1]).all()
    start = run.position(np.array([0.0]))[0]
    assert start == pytest.approx([run.start.x, run.start.y, run.start.z], abs=0)
    assert run.lens_height(run.times) == pytest.approx(run.impacts["z"] - surface_heights(run), abs=1e-15)


def surface_heights(run):
    distances = np.hypot(run.impacts["x"], run.impacts["y"])
    return np.array([surface_height(d, run.params.path_curvature) for d in distances])


def test_a_start_inside_the_glass_is_refused():
    with pytest.raises(ValueError, match="about 0.001 m inside the lens"):
        simulate(Params(), State(z=-1e-3), 1)


def test_a_scene_or_a_start_that_is_no_number_is_refused():
    with pytest.raises(ValueError, match="params.frequency = 0.0 is not allowed"):
        simulate(Params(frequency=0.0), State(z=1e-3), 1)
    with pytest.raises(ValueError, match="start.u = nan is not allowed"):
        simulate(Params(), State(z=1e-3, u=float("nan")), 1)


def test_two_radii_of_one_ball_are_refused():
    with pytest.raises(ValueError, match="spin.radius = 0.002 m and params.ball_radius = 0.0025 m"):
        simulate(Params(), State(z=1e-3), 1, Spin(radius=0.002))
