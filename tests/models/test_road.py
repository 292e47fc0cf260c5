import math

import numpy as np
import pytest

from tests.models.road_record import fresh, knots, packed
from vr_envs.models.record import pack
from vr_envs.models.road import RING, pass_knot, place_on_road, road_height, slope_of_road, start_road
from vr_envs.models.road_features import bump_height, obstacle_height, profile_height
from vr_envs.models.road_options import Bumps, Obstacle, Profile, Road

SD = 0.1 * math.sqrt(math.pi * 256e-6 / (2 * 0.011))  # class C
FEATURES = Profile(spacing=0.3, height=(1.0, 1.1, 0.8, 0.95)), Bumps(stretch=30.0), Obstacle(length=1.0, every=7.0)


def uniform(key, counter):
    """SplitMix64's number `counter` from the seed `key`, as a float."""
    mask = 2**64 - 1
    z = (key + (counter + 1) * 0x9E3779B97F4A7C15) & mask
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & mask
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & mask
    return ((z ^ (z >> 31)) // 2**12 + 0.5) * 2.0**-52


def normal(key, counter):
    """Box and Muller, the `counter`-th of a sequence of pairs."""
    even = counter - counter % 2
    turn = 2 * math.pi * uniform(key, even + 1)
    return math.sqrt(-2 * math.log(uniform(key, even))) * (math.sin(turn) if counter % 2 else math.cos(turn))


def bump(key, x):
    """Bumps with the usual settings."""
    start = 40 * (x // 40)
    draws = [uniform(key, 2**42 + 3 * int(x // 40) + i) for i in range(3)]
    centre, half, side = start + 3 + 34 * draws[0], 1 + 2 * draws[1], 2 * draws[2] - 1
    return math.copysign(0.03 + 0.05 * abs(side), side) * max(0.0, 1 - abs(x - centre) / half)


@pytest.mark.parametrize("key", [0, 7, 2**64 - 3])
def test_the_usual_road_is_what_its_formulas_say(key):
    """Written out again in plain Python: no knot of an episode's key may ever change."""
    deviation = 0.1 * math.sqrt(math.pi * 256e-6 * 2 ** (2 * uniform(key, 2**40) - 1) / (2 * 0.011))
    phi = math.exp(-2 * math.pi * 0.011 * 0.2)
    roughness, expected = deviation * normal(key, 2**43), []
    for k in range(1000):
        roughness = phi * roughness + math.sqrt(1 - phi**2) * deviation * normal(key, k)
        expected.append(roughness + bump(key, 0.2 * k))
    assert knots(key, 1000, Road(), bumps=Bumps()) == pytest.approx(np.array(expected), abs=1e-14)


def test_knots_are_the_exact_discretisation():
    """Innovations of the first-order filter are white, standard normal: variance, whiteness, kurtosis."""
    n = 40000
    r = knots(7, n, Road(spread=0.0))
    phi = math.exp(-2 * math.pi * 0.011 * 0.2)
    e = (r[1:] - phi * r[:-1]) / (SD * math.sqrt(1 - phi**2))
    assert abs(e.mean()) < 4 / math.sqrt(n)
    assert abs(e.var() - 1) < 4 * math.sqrt(2 / n)
    assert abs((e**4).mean() - 3) < 4 * math.sqrt(96 / n)
    for lag in range(1, 6):
        assert abs(np.mean(e[lag:] * e[:-lag])) < 4 / math.sqrt(n)


def test_starts_are_stationary():
    heights = np.array([knots(key, 64, Road(spread=0.0))[[0, 63]] for key in range(4000)])
    assert heights.var(axis=0) == pytest.approx(SD**2, rel=4 * math.sqrt(2 / 4000))


def test_density_is_drawn_about_the_mean():
    octaves, road = [], pack(Road(spread=1.0))
    for key in range(3000):
        state = fresh(key)
        start_road(state, road, None, None, None, None)
        octaves.append(math.log2((state["roughness_sd"] / SD) ** 2))
    assert -1 < min(octaves) < -0.99 and 0.99 < max(octaves) < 1
    assert abs(np.mean(octaves)) < 4 * math.sqrt(1 / 3 / 3000)


@pytest.mark.parametrize("letter", "ABCDEFGH")
def test_each_class_is_twice_as_high_as_the_one_before(letter):
    """The same key: the same road but for its size, 2 per class."""
    ratio = 2.0 ** ("ABCDEFGH".index(letter) - 2)
    assert knots(3, 500, Road(iso_class=letter)) == pytest.approx(ratio * knots(3, 500, Road()), rel=1e-13)


def test_preview_is_the_road_that_comes():
    options = packed(Road(), *FEATURES, None)
    heights = knots(3, 600, Road(), *FEATURES)
    state = fresh(3)
    start_road(state, *options)
    for knot in range(300):
        assert state["knot"] == knot
        state["to_knot"] = 0.05
        assert place_on_road(state, options[0]) == pytest.approx(0.75)
        assert slope_of_road(state, options[0]) == pytest.approx((heights[knot + 1] - heights[knot]) / 0.2, abs=1e-15)
        for place in (0.0, 0.75, 1.0, 30.25, RING - 3.5):
            expected = np.interp(knot + place, np.arange(600), heights)
            assert road_height(state, place) == pytest.approx(expected, abs=1e-15)
        pass_knot(state, True, *options)


def test_what_lies_on_a_road_adds_to_its_roughness():
    profile, bumps, obstacle = (pack(feature) for feature in FEATURES)
    x = 0.2 * np.arange(1000)
    expected = [profile_height(d, profile) + bump_height(5, d, bumps) + obstacle_height(d, obstacle) for d in x]
    difference = knots(5, 1000, Road(), *FEATURES) - knots(5, 1000, Road())
    assert difference == pytest.approx(np.array(expected), abs=1e-14)


def test_a_flat_road_has_its_features_alone():
    flat = Road(iso_class="flat")
    assert (knots(1, 300, flat) == 0.0).all()
    x = 0.2 * np.arange(300)
    assert knots(1, 300, flat, bumps=Bumps()) == pytest.approx(
        np.array([bump_height(1, d, pack(Bumps())) for d in x]), abs=1e-15
    )


def test_a_road_does_not_end():
    """Far beyond any ride, where counters of different uses meet, knots are still finite and differ."""
    options = packed(Road(), *FEATURES, None)
    state = fresh(6)
    start_road(state, *options)
    state["knot"] = 2**44
    for _ in range(2 * RING):
        pass_knot(state, True, *options)
    assert np.isfinite(state["knots"]).all()
    assert len(set(state["knots"])) == RING
