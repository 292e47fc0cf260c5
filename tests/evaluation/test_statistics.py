import math

import numpy as np
import pytest
import scipy.stats

from vr_envs.evaluation.statistics import bootstrap, difference, estimate, iqm, mean, normalised


@pytest.mark.parametrize("n", [2, 3, 4, 5, 7, 8, 100, 201])
def test_iqm_is_the_quarter_trimmed_mean(n):
    values = np.random.default_rng(n).standard_cauchy((3, n))
    assert iqm(values) == pytest.approx(scipy.stats.trim_mean(values, 0.25, axis=-1), rel=1e-14)


def test_iqm_ignores_the_outer_quarters():
    assert iqm(np.array([-1e9, 1.0, 2.0, 1e9])) == 1.5


def test_interval_of_a_mean_has_the_textbook_width():
    values = np.random.default_rng(0).normal(3.0, 2.0, 400)
    found = estimate(values)
    half = 1.959964 * values.std() / math.sqrt(400)
    assert found.value == values.mean()
    assert found.low == pytest.approx(found.value - half, abs=0.06 * half)
    assert found.high == pytest.approx(found.value + half, abs=0.06 * half)


def test_interval_agrees_with_scipys_bootstrap():
    values = np.random.default_rng(1).exponential(1.0, 150)
    theirs = scipy.stats.bootstrap(
        (values,), np.mean, n_resamples=20_000, method="percentile", rng=np.random.default_rng(2)
    ).confidence_interval
    found = estimate(values)
    width = theirs.high - theirs.low
    assert abs(found.low - theirs.low) < 0.04 * width
    assert abs(found.high - theirs.high) < 0.04 * width


def test_intervals_cover_the_truth_95_times_in_100():
    generator = np.random.default_rng(3)
    covered = 0
    for _ in range(400):
        found = estimate(generator.normal(0.0, 1.0, 60))
        covered += found.low <= 0.0 <= found.high
    # binomial sd 0.011; the percentile interval of 60 values covers 94.3 %
    assert 0.91 < covered / 400 < 0.975


def test_same_numbers_same_interval():
    values = np.random.default_rng(4).normal(size=50)
    assert estimate(values) == estimate(values.copy())
    assert bootstrap(mean, values, seed=1) != bootstrap(mean, values, seed=2)


def test_pairing_removes_what_scenarios_share():
    generator = np.random.default_rng(5)
    hard = generator.normal(0.0, 10.0, 200)
    found = difference(hard + 1.0, hard)
    assert found.low == pytest.approx(1.0) == found.high
    assert estimate(hard).high - estimate(hard).low > 2.0


def test_values_that_are_not_known_are_left_out():
    assert estimate(np.array([1.0, math.nan, 3.0])).value == 2.0
    assert all(map(math.isnan, estimate(np.array([math.nan, math.nan]))))


def test_normalised_score_is_zero_for_nothing_and_one_for_the_baseline():
    generator = np.random.default_rng(6)
    nothing = generator.uniform(0.1, 0.3, 100)
    baseline = nothing + generator.uniform(0.2, 0.4, 100)
    assert normalised(nothing, nothing, baseline) == (0.0, 0.0, 0.0)
    assert normalised(baseline, nothing, baseline) == (1.0, 1.0, 1.0)
    halfway = normalised((nothing + baseline) / 2.0, nothing, baseline)
    assert halfway == pytest.approx((0.5, 0.5, 0.5))


def test_normalised_score_does_not_see_scale_and_offset():
    generator = np.random.default_rng(7)
    scores, nothing, baseline = generator.normal([[0.7], [0.2], [0.5]], 0.1, (3, 100))
    plain = normalised(scores, nothing, baseline)
    assert normalised(5 * scores + 2, 5 * nothing + 2, 5 * baseline + 2) == pytest.approx(plain, rel=1e-12)
    assert plain.value == pytest.approx((scores.mean() - nothing.mean()) / (baseline.mean() - nothing.mean()))
    assert plain.low < plain.value < plain.high


@pytest.mark.parametrize("gap", [0.0, -0.2, 0.001])
def test_no_scale_where_the_baseline_is_not_clearly_better_than_nothing(gap):
    generator = np.random.default_rng(8)
    nothing, baseline = generator.normal([[0.5], [0.5 + gap]], 0.1, (2, 100))
    assert all(map(math.isnan, normalised(np.ones(100), nothing, baseline)))
