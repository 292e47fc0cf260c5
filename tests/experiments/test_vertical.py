"""The vertical experiments in small: what they compute with, against closed forms and made-up data."""

import math

import numpy as np
import pytest

from vr_envs.experiments.attractors import MOST, ends, recurrence
from vr_envs.experiments.bifurcation import RATES, SPLIT, edge_of, heights, ramp, split_at, sweep
from vr_envs.experiments.bounce import (
    launches,
    lower_bound,
    orbit_phases,
    period_one_apex,
    period_one_launch,
    period_one_phase,
    upper_bound,
    vertical,
    z_omega,
)
from vr_envs.experiments.camera_trace import CameraTrace, fitted
from vr_envs.experiments.periodic import Setting, in_a_second
from vr_envs.experiments.phase_portrait import exact_misfit, spiral_misfit
from vr_envs.experiments.restitution import RESTITUTION, drop, estimates, seen_bounces
from vr_envs.experiments.runner import silent
from vr_envs.experiments.simulation import scan
from vr_envs.experiments.simulation_kernels import IMPACT
from vr_envs.experiments.stability_bands import band


@pytest.mark.parametrize("restitution", [0.68, 0.75, 0.856])
@pytest.mark.parametrize("m", [1, 2, 3, 4])
def test_bounds_found_by_simulation_are_those_of_luck_and_mehta(restitution, m):
    params = vertical(20.0, restitution)
    low, high = band(params, m)
    assert low == pytest.approx(lower_bound(m, params), rel=0.005)
    assert high == pytest.approx(upper_bound(m, params), rel=0.005)


def test_bounds_do_not_depend_on_the_frequency():
    found = [band(vertical(frequency, 0.75), 2) for frequency in (5.0, 60.0)]
    np.testing.assert_allclose(found[0], found[1], rtol=1e-6)


def bouncing(regions=2, rate=1000.0, noise=0.0):
    """Two heights in turn over a bar at 30 Hz, sampled as the camera does: (trace, maxima, impact times, phases)."""
    rng = np.random.default_rng(4)
    omega, size, phase = 2 * math.pi * 30.0, 3e-4, 0.4
    # flights of two durations between given heights of the bar
    times = np.cumsum(np.tile([0.030, 0.0366667], 12))
    places = size * np.sin(omega * times + phase)
    t = np.arange(0.0, times[-1], 1.0 / rate)
    z, tops = np.zeros_like(t), []
    for a, b, z0, z1 in zip(times[:-1], times[1:], places[:-1], places[1:], strict=True):
        out = (z1 - z0) / (b - a) + 9.81 / 2 * (b - a)
        rows = (t >= a) & (t < b)
        z[rows] = z0 + out * (t[rows] - a) - 9.81 / 2 * (t[rows] - a) ** 2
        tops.append(z0 + out**2 / (2 * 9.81))
    z[t < times[0]] = places[0] + 0.16 * (times[0] - t[t < times[0]])
    z += noise * rng.standard_normal(z.shape)
    bar = size * np.sin(omega * t + phase) + noise * rng.standard_normal(z.shape)
    seen = CameraTrace(t[0::regions], z[0::regions], t[1::regions], bar[1::regions])
    return seen, np.array(tops), times, np.mod(omega * times + phase, 2 * math.pi), omega


@pytest.mark.parametrize(("noise", "place", "turn"), [(0.0, 1e-12, 1e-9), (1e-5, 2e-5, 0.1)])
def test_fits_find_maxima_minima_and_phases(noise, place, turn):
    seen, tops, times, phases, omega = bouncing(noise=noise)
    found = fitted(seen, omega)
    first = np.argmin(np.abs(times - found.impact_times[0]))
    n = len(found.impact_times)
    assert n >= 20
    assert np.abs(found.maxima[1:n] - tops[first : first + n - 1]).max() < place
    apart = np.angle(np.exp(1j * (found.phases - phases[first : first + n])))
    assert np.abs(apart).max() < turn
    assert np.abs(found.minima - 3e-4 * np.sin(phases[first : first + n])).max() < (1e-12 if noise == 0 else 1e-4)


def test_fits_refuse_flights_of_too_few_samples():
    seen, *_, omega = bouncing(rate=150.0)
    with pytest.raises(ValueError, match="sample faster"):
        fitted(seen, omega)


def test_the_camera_sees_the_closed_form_of_period_one():
    setting = Setting(30.0, 10.4, 1, 1000.0, 2)
    params, motion, start = setting.settled(0.68)
    _, bounces = setting.seen(params, motion, start)
    rows = in_a_second(bounces)
    assert rows.stop == 30
    np.testing.assert_allclose(bounces.phases[rows], period_one_phase(10.4, 1, params), atol=1e-8)
    np.testing.assert_allclose(bounces.maxima[rows], period_one_apex(10.4, 1, params), atol=1e-12)
    assert setting.repeats(0.68) == (1, pytest.approx(1.0, abs=1e-9))
    assert setting.repeats(0.856)[0] == 2


def made_up(period, noise=0.0):
    rows = np.zeros((1, 4 * MOST), IMPACT)
    number = np.arange(4 * MOST)
    rows["phase"] = (1.0 + 0.3 * (number % period) + noise * number) % (2 * math.pi)
    rows["normal_out"] = 0.2 + 0.01 * (number % period)
    return rows


@pytest.mark.parametrize("period", [1, 2, 3, 7, MOST])
def test_recurrence_is_the_smallest_period(period):
    assert recurrence(made_up(period))[0] == period
    assert recurrence(made_up(period, noise=1e-5))[0] == 0


def test_a_phase_just_below_a_turn_is_next_to_one_just_above():
    rows = made_up(1)
    rows["phase"][0, ::2] = 1e-9
    rows["phase"][0, 1::2] = 2 * math.pi - 1e-9
    assert recurrence(rows)[0] == 1


def test_a_ball_that_locks_and_one_that_lies_still_have_rested():
    params = vertical(20.0, 0.3)
    for acceleration in (15.0, 5.0):
        motions, states = launches(params, acceleration, 1.0, 0.1)
        kept, counts, _ = scan(params, motions, states, 50, 60)
        found = ends(kept, counts, params)
        assert found.rested.all()
        assert found.period[0] == 0


def test_period_three_stands_beside_period_one():
    params = vertical(30.0, 0.68)
    phases = orbit_phases([0.51, 1.96, 6.21], [1, 0, 2], 11.11, params)
    np.testing.assert_allclose(phases, [0.51, 1.96, 6.21], atol=0.01)
    size = 11.11 / z_omega(params) ** 2
    flight = (phases[1] - phases[0] + 2 * math.pi) / z_omega(params)
    out = size * (math.sin(phases[1]) - math.sin(phases[0])) / flight + 9.81 / 2 * flight
    speed = out - size * z_omega(params) * math.cos(phases[0])
    motions, states = launches(params, 11.11, phases[0], speed + 1e-4)
    kept, counts, _ = scan(params, motions, states, 500, 4 * MOST)
    assert ends(kept, counts, params).period[0] == 3
    motions, states = period_one_launch(params, 11.11, 1, nudge=1e-4)
    kept, counts, _ = scan(params, motions, states, 500, 4 * MOST)
    assert ends(kept, counts, params).period[0] == 1


def test_drops_give_back_the_restitution():
    _, trace = drop(0.02, 0.0, 0)
    by_height, by_time = estimates(seen_bounces(trace)[1])
    np.testing.assert_allclose(by_height, RESTITUTION, atol=1e-9)
    np.testing.assert_allclose(by_time, RESTITUTION, atol=1e-9)
    _, rough = drop(0.02, 0.05, 3)
    assert 0.01 < estimates(seen_bounces(rough)[1])[0].std() < 0.15


def test_the_exact_map_holds_and_the_spiral_is_an_approximation():
    params = vertical(20.0, 0.75)
    gamma = 0.65
    motions, states = launches(params, gamma * math.pi * 9.81, [0.5, 1.5, 4.0], [0.2, 0.3, 0.5])
    kept, _, _ = scan(params, motions, states, 5, 60)
    assert np.abs(exact_misfit(kept, gamma, params)).max() < 1e-13
    assert np.abs(exact_misfit(kept, 1.01 * gamma, params)).max() > 1e-3
    assert spiral_misfit(kept, gamma, params).max() > 1e-2


def test_sweeps_leave_period_one_at_its_bounds():
    params = vertical(20.0, 0.75)
    low, high, period = edge_of(1, params, sweep(1, params, True))
    assert low - 0.02 <= upper_bound(1, params) <= high + 0.02
    assert period == 2
    last, first, _ = edge_of(1, params, sweep(1, params, False))
    assert first - 0.02 <= lower_bound(1, params) <= last + 0.02


def test_heights_of_a_sweep_are_those_of_period_one():
    params = vertical(20.0, 0.75)
    accelerations, kept, counts = sweep(1, params, False)
    tops = heights(kept[:20], counts[:20], params)
    expected = [period_one_apex(a, 1, params) for a in accelerations[:20]]
    np.testing.assert_allclose(tops, np.repeat(expected, tops.shape[1]).reshape(tops.shape), rtol=1e-6)


def test_a_faster_ramp_passes_the_flip_later():
    params = vertical(20.0, 0.75)
    slow, fast = (split_at(*ramp(1, params, rate)) for rate in (5 * RATES[0], 2 * RATES[1]))
    assert upper_bound(1, params) < slow < fast < 13.0


def test_a_split_is_four_uneven_bounces_in_a_row():
    tops = np.ones(40)
    tops[10] += 2 * SPLIT
    tops[21::2] += 2 * SPLIT
    assert split_at(np.arange(40.0), tops) == 20.0
    assert math.isnan(split_at(np.arange(40.0), np.ones(40)))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["period_one", "period_two", "period_one_m2", "period_two_m2"])
def test_every_finding_of_the_figures_agrees(name):
    from vr_envs.experiments import period_figures

    outcome = getattr(period_figures, name)(silent)
    assert [f for f in outcome.findings if not f.agrees] == []
