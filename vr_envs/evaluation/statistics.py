"""Point estimates with 95 % intervals, on numpy.

The interval is the percentile bootstrap over scenarios (Efron and Tibshirani 1993, chapter 13), from a fixed seed:
the same numbers in, the same interval out. Resamples are the same for every policy, so that ratios and differences
of policies on the same scenarios are paired. The interquartile mean is that of Agarwal et al. (2021).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

RESAMPLES = 4000
COVERAGE = 0.95
_SEED = 20210830


class Estimate(NamedTuple):
    """A value and its 95 % interval [low, high]; NaN where there is none."""

    value: float
    low: float
    high: float


UNDEFINED = Estimate(math.nan, math.nan, math.nan)


def mean(values: np.ndarray) -> np.ndarray:
    """Mean along the last axis."""
    return values.mean(axis=-1)


def iqm(values: np.ndarray) -> np.ndarray:
    """Interquartile mean along the last axis: a quarter of the values (rounded down) is cut from each end."""
    cut = values.shape[-1] // 4
    return np.sort(values, axis=-1)[..., cut : values.shape[-1] - cut].mean(axis=-1)


def bootstrap(statistic: Callable[..., np.ndarray], *samples: np.ndarray, seed: int = _SEED) -> Estimate:
    """`statistic` of equally long samples, resampled jointly (paired) over their entries.

    `statistic` takes one array per sample, reduces the last axis, and accepts any leading axes.
    """
    n = len(samples[0])
    rows = np.random.default_rng(seed).integers(n, size=(RESAMPLES, n))
    draws = statistic(*(np.asarray(s, float)[rows] for s in samples))
    low, high = np.quantile(draws, [(1 - COVERAGE) / 2, (1 + COVERAGE) / 2])
    value = statistic(*(np.asarray(s, float) for s in samples))
    return Estimate(float(value), float(low), float(high))


def estimate(values: np.ndarray) -> Estimate:
    """Mean with interval, over the entries that are not NaN; `UNDEFINED` where there are none."""
    known = np.asarray(values, float)
    known = known[~np.isnan(known)]
    return bootstrap(mean, known) if len(known) else UNDEFINED


def difference(scores: np.ndarray, reference: np.ndarray) -> Estimate:
    """Mean paired difference scores - reference, with interval."""
    return bootstrap(mean, np.asarray(scores, float) - reference)


def normalised(scores: np.ndarray, nothing: np.ndarray, baseline: np.ndarray) -> Estimate:
    """Mean score on the scale do-nothing = 0, documents' baseline = 1, all three on the same scenarios.

    `UNDEFINED` where the baseline is not clearly better than doing nothing (the paired interval reaches zero):
    there the scale has no unit.
    """
    if difference(baseline, nothing).low <= 0.0:
        return UNDEFINED
    return bootstrap(lambda s, z, b: (mean(s) - mean(z)) / (mean(b) - mean(z)), scores, nothing, baseline)
