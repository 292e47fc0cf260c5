"""Exponential, logarithm, sine and cosine against 60 digits, and the same bytes on lanes."""

import math

import mpmath
import numpy as np
import pytest

from vr_envs.models import elementary
from vr_envs.models.jit import kernel
from vr_envs.models.lane_records import block_at, empty_blocks, read_records, write_records

RECORD = np.dtype([("x", "f8"), ("y", "f8"), ("first", "f8"), ("second", "f8")], align=True)
RNG = np.random.default_rng(1)


@kernel
def exp(record):
    record.first = elementary.exp(record.x)


@kernel
def log(record):
    record.first = elementary.log(record.x)


@kernel
def cos_sin(record):
    record.first, record.second = elementary.cos_sin(record.x)


@kernel
def power(record):
    record.first = elementary.power(record.x, record.y)


@kernel
def everything(record):
    """All on the same argument, positive and not too large."""
    x, y = record.x, record.y
    c, s = elementary.cos_sin(x)
    record.first = elementary.exp(y) * elementary.power(x, y) + c
    record.second = elementary.log(x) * s


@kernel
def all_everything(records):
    for i in range(records.shape[0]):
        everything(records[i])


@kernel
def blocks_everything(blocks):
    for b in range(blocks.shape[0]):
        everything(block_at(blocks, b))


def ulps(got: float, exact: mpmath.mpf) -> float:
    """Error of a number in units of the last place of the exact one."""
    if exact == 0:
        return 0.0 if got == 0.0 else math.inf
    place = max(int(mpmath.floor(mpmath.log(abs(exact), 2))), -1022) - 52
    return float(abs(mpmath.mpf(got) - exact) / mpmath.mpf(2) ** place)


def worst(function, exact, x, y=None, which="first"):
    """The largest error [ulp] of a kernel over the arguments."""
    records = np.zeros(len(x), RECORD)
    records["x"], records["y"] = x, 0.0 if y is None else y
    for record in records:
        function(record)
    with mpmath.workdps(60):
        arguments = zip(x, records["y"], records[which], strict=True)
        return max(ulps(got, exact(mpmath.mpf(a), mpmath.mpf(b))) for a, b, got in arguments)


def test_exponential():
    ends = [0.0, -0.0, 709.78, -708.39, -708.4, -745.13, 1e-300, -1e-300, 0.5 * math.log(2.0), -0.5 * math.log(2.0)]
    x = [*ends, *RNG.uniform(-708.0, 709.7, 400), *RNG.uniform(-1.0, 1.0, 800), *RNG.uniform(-745.0, -708.0, 300)]
    assert worst(exp, lambda a, _: mpmath.exp(a), x) < 1.0


def test_exponential_out_of_range():
    records = np.zeros(4, RECORD)
    records["x"] = 709.79, 1e300, -745.2, -1e300
    for record in records:
        exp(record)
    assert records["first"].tolist() == [math.inf, math.inf, 0.0, 0.0]


def test_logarithm():
    near_one = 10.0 ** RNG.uniform(-16.0, -1.0, 300)
    cuts = [1.0, math.sqrt(0.5), math.sqrt(2.0), 5e-324, 2.0**-1022, np.nextafter(2.0**-1022, 0.0), 1.7e308]
    x = [*cuts, *(1.0 + near_one), *(1.0 - near_one), *RNG.uniform(0.5, 2.0, 500), *10.0 ** RNG.uniform(-323, 308, 400)]
    assert worst(log, lambda a, _: mpmath.log(a), x) < 1.0


@pytest.mark.parametrize("which, exact", [("first", mpmath.cos), ("second", mpmath.sin)])
def test_cosine_and_sine(which, exact):
    multiples = 0.5 * math.pi * RNG.integers(-640_000, 640_000, 400)
    near = [0.0, 1e-300, *(0.5 * math.pi * np.arange(100)), *multiples, *np.nextafter(multiples, 0.0)]
    x = [*near, *RNG.uniform(-1e6, 1e6, 400), *RNG.uniform(-10.0, 10.0, 400), *10.0 ** RNG.uniform(-20.0, 0.0, 100)]
    assert worst(cos_sin, lambda a, _: exact(a), x, which=which) < 1.0


@pytest.mark.parametrize("size, bound", [(math.log(1e6), 1.0), (700.0, 40.0)])
def test_power(size, bound):
    x = 10.0 ** RNG.uniform(-3.0, 3.0, 500)
    y = RNG.uniform(-size, size, len(x)) / np.log(x)
    assert worst(power, lambda a, b: a**b, x, y) < bound


def test_lanes_are_the_same_bytes():
    records = np.zeros(800, RECORD)
    records["x"], records["y"] = 10.0 ** RNG.uniform(-4.0, 6.0, 800), RNG.uniform(-30.0, 30.0, 800)
    blocks, rows = empty_blocks(RECORD, 800), np.arange(800)
    write_records(blocks, rows, records)
    all_everything(records)
    blocks_everything(blocks)
    others = read_records(blocks, rows)
    assert np.isfinite(records["first"]).all() and np.ptp(records["first"]) > 0.0
    assert records.tobytes() == others.tobytes()
