import math

import numpy as np
import pytest

from vr_envs.models.record import pack
from vr_envs.models.road_features import bump_height, obstacle_height, profile_height
from vr_envs.models.road_options import POINTS, Bumps, Obstacle, Profile

X = np.arange(0.0, 60.0, 0.01)


def obstacle(**fields):
    record = pack(Obstacle(**fields))
    return np.array([obstacle_height(x, record) for x in X])


def test_bumps_stay_in_their_stretch_and_size():
    bumps = Bumps()
    record, x = pack(bumps), np.arange(0.0, 40000.0, 0.05)
    h = np.array([bump_height(11, d, record) for d in x]).reshape(1000, -1)
    top = np.abs(h).max(axis=1)
    assert (top <= bumps.high).all() and (top > bumps.low * (1 - 0.05 / bumps.shortest)).all()
    assert (np.sign(h).max(axis=1) - np.sign(h).min(axis=1) == 1).all()
    width = (h != 0).sum(axis=1) * 0.05
    assert (width > 2 * bumps.shortest - 0.1).all() and (width < 2 * bumps.longest + 0.1).all()
    assert 0.4 < (h.sum(axis=1) > 0).mean() < 0.6
    assert np.abs(np.diff(h, axis=1)).max() <= 0.05 * bumps.high / bumps.shortest * (1 + 1e-9)


@pytest.mark.parametrize("count", [1, 2, 57, POINTS])
def test_a_profile_is_straight_between_its_points_and_counts_from_the_first(count):
    heights = np.random.default_rng(count).normal(size=count)
    record = pack(Profile(spacing=0.13, height=tuple(heights)))
    end = 0.13 * (count - 1)
    for x in (*np.linspace(0.0, end, 997), *0.13 * np.arange(0, count, 7), end + 0.01, end + 1e6):
        expected = np.interp(x, 0.13 * np.arange(count), heights) - heights[0]
        assert profile_height(x, record) == pytest.approx(expected, abs=1e-11)


@pytest.mark.parametrize(("kind", "sign"), [("bump", 1.0), ("pothole", -1.0)])
def test_bump_and_pothole_are_one_minus_cosine(kind, sign):
    inside = (X > 20.0) & (X < 23.0)
    expected = np.where(inside, sign * 0.025 * (1.0 - np.cos(2.0 * math.pi * (X - 20.0) / 3.0)), 0.0)
    assert obstacle(kind=kind, length=3.0) == pytest.approx(expected, abs=1e-15)


def test_a_ramp_goes_up_along_and_down():
    expected = np.interp(X, [20.0, 23.0, 27.0, 30.0], [0.0, 0.05, 0.05, 0.0])
    assert obstacle(kind="ramp", length=3.0, top=4.0) == pytest.approx(expected, abs=1e-14)


def test_a_kerb_begins_and_ends_at_its_knots_in_spite_of_rounding():
    for first, spacing in ((0.3, 0.1), (20.0, 0.2), (4.9, 0.07), (7.0, 0.05)):
        record = pack(Obstacle(kind="kerb", first=first, top=10 * spacing, every=30 * spacing))
        begin = round(first / spacing)
        heights = [obstacle_height(k * spacing, record) for k in range(begin + 2000)]
        up = [k >= begin and (k - begin) % 30 < 10 for k in range(begin + 2000)]
        assert heights == [0.05 if high else 0.0 for high in up]


def test_a_washboard_is_whole_sines():
    inside = (X > 20.0) & (X < 23.5)
    expected = np.where(inside, 0.02 * np.sin(2.0 * math.pi * (X - 20.0) / 0.7), 0.0)
    assert obstacle(kind="washboard", height=0.02, pitch=0.7, length=4.0) == pytest.approx(expected, abs=1e-13)


@pytest.mark.parametrize("kind", ["bump", "pothole", "kerb", "washboard", "ramp"])
def test_obstacles_come_again(kind):
    once = obstacle(kind=kind, first=5.0, length=1.5)
    again = obstacle(kind=kind, first=5.0, length=1.5, every=10.0)
    expected = np.concatenate([once[:500], np.tile(once[500:1500], 6)])[: len(X)]
    assert again == pytest.approx(expected, abs=1e-12)
