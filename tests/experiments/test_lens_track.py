"""What a track of the ball on a lens shows, each estimate on a motion whose answer is known."""

import dataclasses
import math

import numpy as np
import pytest

from vr_envs.experiments.lens_orbit import horizontal_map, lens_strength, travel_frequency
from vr_envs.experiments.lens_simulation import Run
from vr_envs.experiments.lens_track import (
    RATE,
    Track,
    adjusted,
    elliptic,
    fitted_apexes,
    invariant,
    line_frequency,
    recursion,
    scene,
    true_apexes,
)
from vr_envs.models.ball_options import Spin


def places_on_a_spiral(size, angle, n=80):
    turns = np.arange(n)
    return {name: 5e-3 * size**turns * np.cos(angle * turns + phase) for name, phase in (("x", 0.3), ("y", 1.4))}


@pytest.mark.parametrize(("size", "angle"), [(1.0, 0.3), (0.98, 0.7)])
def test_the_recursion_finds_size_and_angle(size, angle):
    run = elliptic(scene(0.15, 30.0), 1e-3, 80)
    run = dataclasses.replace(run, impacts={**run.impacts, **places_on_a_spiral(size, angle)})
    assert recursion(run) == pytest.approx((size, angle), rel=1e-9)


@pytest.mark.parametrize("frequency", [1.3, 1.8346, 2.7])
def test_the_spectrum_finds_a_line(frequency):
    times = np.arange(2600) / RATE
    rng = np.random.default_rng(1)
    angle = 2 * np.pi * frequency * times
    places = 1e-3 * np.column_stack([8 * np.cos(angle), 4 * np.sin(angle)]) + rng.normal(0, 2e-5, (2600, 2)) + 0.004
    assert line_frequency(times, places) == pytest.approx(frequency, rel=1e-3)


def small(spin=None):
    return elliptic(scene(0.15, 30.0), 1e-5, 150, spin)


def test_small_travel_is_that_of_the_linear_map():
    run = small()
    size, angle = recursion(run)
    assert size == pytest.approx(1.0, abs=1e-6)
    assert angle * 30 / (2 * math.pi) == pytest.approx(travel_frequency(run.params), rel=1e-5)
    assert np.ptp(invariant(run)) < 1e-6 * invariant(run).mean()
    gripped = small(Spin())
    expected = np.abs(np.linalg.eigvals(horizontal_map(run.params, Spin()))).max()
    assert recursion(gripped)[0] == pytest.approx(expected, abs=1e-6)


def test_the_invariant_is_the_form_that_the_linear_map_keeps():
    params = scene(0.2, 20.0)
    beta = lens_strength(params)
    form = np.array([[beta, -beta / 2], [-beta / 2, 1.0]])
    step = horizontal_map(params)
    assert step.T @ form @ step == pytest.approx(form, abs=1e-12)


def noisy_track(noise, seed=2):
    run = elliptic(scene(0.15, 30.0), 8e-3, 60)
    times = np.arange(int(59.5 / 30 * RATE)) / RATE
    true = run.position(times)
    return Track(run, times, true, true + np.random.default_rng(seed).normal(0, noise, true.shape))


def test_fitted_apexes_are_the_true_ones_without_noise():
    track = noisy_track(0.0)
    assert fitted_apexes(track, track.true[:, 2])[0] == pytest.approx(true_apexes(track.run)[:-1, 2], abs=1e-15)
    heights = adjusted(track.run.params, track.true)
    expected = adjusted(track.run.params, true_apexes(track.run)[:-1])
    # the highest point of the adjusted flight is not quite under that of the flight: fourth order in the place
    assert np.abs(fitted_apexes(track, heights)[0] - expected).max() < 1e-6


def test_the_error_of_fitted_apexes_is_as_told():
    errors = []
    for seed in range(20):
        track = noisy_track(1e-5, seed)
        apexes, factor = fitted_apexes(track, track.seen[:, 2])
        errors.append(apexes - true_apexes(track.run)[:-1, 2])
    # 20 x 58 independent errors: their standard deviation is known to 2 %
    assert np.std(errors) == pytest.approx(1e-5 * factor, rel=0.07)


def test_adjusting_takes_away_the_height_of_the_lens():
    run: Run = elliptic(scene(0.15, 30.0), 8e-3, 60)
    places = np.column_stack([run.impacts[name] for name in "xyz"])
    assert adjusted(run.params, places) == pytest.approx(run.lens_height(run.times), abs=1e-15)
