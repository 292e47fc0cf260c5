"""Closed forms of the period one on a lens against the exact dynamics."""

import dataclasses
import math

import numpy as np
import pytest

from vr_envs.experiments.lens_orbit import (
    apex_swings,
    from_apex,
    horizontal_map,
    impact_phase,
    lens_strength,
    period_one_start,
    travel_frequency,
)
from vr_envs.experiments.lens_simulation import simulate
from vr_envs.experiments.simulation import ball, bar_motion
from vr_envs.experiments.simulation import simulate as bar_simulate
from vr_envs.models.ball_on_bar import Params as BarParams
from vr_envs.models.ball_on_lens import Params, State, cycle
from vr_envs.models.ball_options import Curve, Spin
from vr_envs.models.lens_flight import surface_height
from vr_envs.models.record import dtype_of, pack


def lens_of(beta, restitution=0.8, **overrides):
    """A scene with kappa g T^2 = beta; a cycle starts at the top of a flight."""
    params = Params(
        restitution=restitution, frequency=20.0, acceleration=6.0, half_aperture=1e-3, ball_radius=1e-4, **overrides
    )
    kappa = beta / (params.gravity * params.period**2)
    params = dataclasses.replace(params, curvature=kappa / (1.0 + kappa * params.ball_radius))
    return from_apex(params)


def exact_map(params, spin, size=1e-7):
    """Derivative of the exact cycle map by (x, y, T u, T v, and R spin T if there is one), at the lens's centre."""
    names = ("x", "y", "u", "v", "spin_x", "spin_y")[: 4 if spin is None else 6]
    scales = np.array([1.0, 1.0, *[params.period] * 4])[: len(names)]
    record, option = pack(params), None if spin is None else pack(spin)
    columns = []
    for name, scale in zip(names, scales, strict=True):
        ends = []
        for sign in (1.0, -1.0):
            start = dataclasses.replace(period_one_start(params), **{name: sign * size / scale})
            state = np.array([pack(start)], dtype_of(State))[0]
            cycle(state, record, option, None)
            assert state["impacts"] == 1
            ends.append(np.array([state[n] for n in names]) * scales)
        columns.append((ends[0] - ends[1]) / (2.0 * size))
    return np.array(columns).T


@pytest.mark.parametrize("beta", [-0.5, 0.2, 1.0, 3.0, 4.5])
@pytest.mark.parametrize(("loss", "spin"), [(0.0, None), (0.3, None), (1.0, None), (0.0, Spin()), (0.0, Spin(2 / 3))])
def test_the_linear_map_is_that_of_the_exact_dynamics(beta, loss, spin):
    params = lens_of(beta, tangential_loss=loss)
    assert lens_strength(params) == pytest.approx(beta, rel=1e-12)
    expected = np.sort_complex(np.tile(np.linalg.eigvals(horizontal_map(params, spin)), 2))
    found = np.sort_complex(np.linalg.eigvals(exact_map(params, spin)))
    # coefficients of the characteristic polynomial: eigenvalues that nearly coincide are ill-conditioned
    assert np.poly(found) == pytest.approx(np.poly(expected), abs=1e-6)


@pytest.mark.parametrize("beta", [0.1, 0.5, 1.0, 2.0, 3.9])
def test_a_frictionless_ball_is_neutral_below_four(beta):
    values = np.linalg.eigvals(horizontal_map(lens_of(beta)))
    assert np.abs(values) == pytest.approx([1.0, 1.0], abs=1e-12)
    # 2 cos(angle) = 2 - beta
    assert math.cos(2 * math.pi * travel_frequency(lens_of(beta)) / 20.0) == pytest.approx(1 - beta / 2, abs=1e-12)


@pytest.mark.parametrize(("beta", "stable"), [(3.96, True), (4.04, False), (-0.04, False)])
def test_a_frictionless_ball_stays_or_leaves_as_the_formula_says(beta, stable):
    params = lens_of(beta)
    run = simulate(params, period_one_start(params, x=1e-8), 200)
    assert (np.abs(run.impacts["x"]).max() < 1e-6) == stable


def test_a_flat_lens_carries_the_ball_along_at_its_velocity():
    params = dataclasses.replace(Params(curvature=0.0, half_aperture=10.0))
    run = simulate(params, period_one_start(params, u=0.01), 50)
    assert np.all(run.impacts["u"] == 0.01)


@pytest.mark.parametrize("beta", [0.2, 1.0, 2.25, 4.4])
def test_full_stick_without_spin(beta):
    """x' = (1 - beta alpha / (1 + alpha)) x; the ball is on the axis at once for beta = (1 + alpha) / alpha."""
    params = lens_of(beta, tangential_loss=1.0)
    factor = 1 - beta * 0.8 / 1.8
    values = np.linalg.eigvals(horizontal_map(params))
    assert np.sort(np.abs(values)) == pytest.approx([0.0, abs(factor)], abs=1e-12)
    x = simulate(params, period_one_start(params, x=1e-6), 4).impacts["x"]
    assert x[1:] / x[:-1] == pytest.approx(factor, abs=1e-6)


@pytest.mark.parametrize(("beta", "radius"), [(0.2, 0.987), (0.5, 0.968), (1.0, 0.934), (2.0, 0.864), (4.0, 0.7015)])
def test_a_spinning_sphere_comes_to_the_axis(beta, radius):
    found = np.abs(np.linalg.eigvals(exact_map(lens_of(beta), Spin()))).max()
    assert found == pytest.approx(radius, abs=5e-4)


def test_a_spinning_sphere_is_stable_up_to_a_little_more_than_four():
    radii = [np.abs(np.linalg.eigvals(horizontal_map(lens_of(beta), Spin()))).max() for beta in (4.12, 4.14)]
    assert radii[0] < 1.0 < radii[1]


def period_one_impacts(**overrides):
    params = from_apex(Params(**overrides))
    return params, simulate(params, period_one_start(params, 1e-4, 0.0, 0.0, 5e-4), 2000).impacts


@pytest.mark.parametrize(
    "overrides",
    [
        {},
        {"frequency": 20.0},
        {"curvature": 30.0, "half_aperture": 0.02},
        {"restitution": 0.856, "acceleration": 6.0},
        {"restitution": 0.68, "acceleration": 10.4},
    ],
)
def test_apex_heights_swing_as_the_second_order_theory_says(overrides):
    params, i = period_one_impacts(**overrides)
    kept = slice(1000, None)  # what the start left of the vertical motion has gone
    angle = 2 * math.pi * travel_frequency(params) * params.period
    number = np.arange(len(i["x"]))[kept]

    def phasor(values, turn):
        basis = np.column_stack([np.ones(len(number)), np.cos(turn * number), -np.sin(turn * number)])
        (_, real, imaginary), *_ = np.linalg.lstsq(basis, values[kept])
        return real + 1j * imaginary

    raw, adjusted = apex_swings(params, phasor(i["x"], angle), phasor(i["y"], angle))
    up = i["w"] / params.gravity
    height = i["z"] + 0.5 * i["w"] * up
    place = np.hypot(i["x"] + i["u"] * up, i["y"] + i["v"] * up)
    lens = np.array([surface_height(d, params.path_curvature) for d in place])
    tolerance = 1e-3 * abs(raw)
    assert abs(phasor(height, 2 * angle) - raw) < tolerance
    assert abs(phasor(height - lens, 2 * angle) - adjusted) < tolerance
    assert abs(raw) > 1e-9


def test_too_gentle_a_lens_has_no_period_one():
    with pytest.raises(ValueError, match="needs a peak acceleration"):
        impact_phase(Params(acceleration=1.0))


@pytest.mark.parametrize("spin", [None, 0.4])
def test_near_its_centre_the_lens_is_the_curved_bar(spin):
    """Two models that share no search: a parabola of the same curvature in the plane, z at twice 15 Hz."""
    bar_params = BarParams(frequency=15.0, restitution=0.75, tangential_loss=0.0)
    motion = bar_motion(bar_params, z=8.0, z_phase=0.5)
    lens_params = Params(phase=0.5)
    options = {"curve": Curve(curvature=lens_params.path_curvature)}
    if spin is not None:
        options["spin"] = Spin(inertia_ratio=spin)
    start = period_one_start(lens_params, x=1e-5, u=2e-5)
    on_bar = bar_simulate(bar_params, motion, ball(motion, x=start.x, z=start.z, u=start.u, w=start.w), 30, options)
    on_lens = simulate(lens_params, start, 60, None if spin is None else Spin(spin))
    assert len(on_bar.impacts) == len(on_lens.times) == 60
    # sphere and parabola differ by x^4 kappa^3 / 8, 1e-8 of the height at 10 micrometres
    assert on_lens.times == pytest.approx(on_bar.seconds(on_bar.impacts), abs=1e-14)
    assert on_lens.impacts["x"] == pytest.approx(on_bar.impacts["x"], abs=1e-11)
    assert np.ptp(on_lens.impacts["x"]) > 1e-5
