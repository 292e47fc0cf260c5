import math

import numpy as np
import pytest

from tests.models.road_record import knots
from vr_envs.models.road_options import Bumps, Obstacle, Profile, Road, Wheel

FLAT = Road(iso_class="flat", knot_spacing=0.05)


def by_sampling(heights, spacing, radius):
    """c - R at the knots by the definition, with s at every knot and 200001 places between; level behind knot 0."""
    reach = math.ceil(radius / spacing) + 1
    ground = np.concatenate([np.full(reach, heights[0]), heights])
    x = spacing * (np.arange(len(ground)) - reach)
    s = np.union1d(np.linspace(-radius, radius, 200001), spacing * np.arange(1 - reach, reach))
    s = s[np.abs(s) <= radius]
    circle = np.sqrt(radius**2 - s**2) - radius
    return np.array([(np.interp(k * spacing + s, x, ground) + circle).max() for k in range(len(heights) - reach)])


@pytest.mark.parametrize("radius", [0.04, 0.3, 0.33, 1.5])
def test_the_centre_runs_along_the_envelope(radius):
    """A rough road with everything on it, longer than the ring; a sampled maximum is short by 11 ds^2/(8 R) at most."""
    road = Road(iso_class="F", knot_spacing=0.05)
    features = Profile(spacing=0.05, height=(0.0, 0.1, 0.1, -0.1)), Bumps(), Obstacle(kind="kerb", height=0.1)
    raw = knots(9, 600, road, *features)
    expected = by_sampling(raw, 0.05, radius)
    got = knots(9, len(expected), road, *features, Wheel(radius=radius))
    assert np.abs(got - expected).max() < 2e-9
    assert (got >= raw[: len(got)] - 1e-15).all()
    assert (got > raw[: len(got)] + 1e-4).mean() > 0.05


def test_over_a_kerb_the_centre_is_on_a_circle_about_its_edge():
    radius, height, top = 0.3, 0.1, 2.0
    wheel, kerb = Wheel(radius=radius), Obstacle(kind="kerb", height=height, first=5.0, top=top)
    got = knots(0, 300, FLAT, obstacle=kerb, wheel=wheel)
    x = 0.05 * np.arange(300)
    # the edges of the polygon: the knot where it begins and the last one before it ends
    away = np.maximum(np.maximum(5.0 - x, x - (5.0 + top - 0.05)), 0.0)
    arc = height - radius + np.sqrt(np.maximum(0.0, radius**2 - away**2))
    assert got == pytest.approx(np.maximum(0.0, arc), abs=1e-15)


def test_on_a_slope_the_centre_is_above_by_what_the_circle_needs():
    """c = r + R sqrt(1 + p^2): the foot of the perpendicular."""
    slope, radius = 0.2, 0.33
    ramp = Obstacle(kind="ramp", height=1.0, first=5.0, length=5.0, top=3.0)
    got = knots(0, 300, FLAT, obstacle=ramp, wheel=Wheel(radius=radius))
    x = 0.05 * np.arange(300)
    inside = (x > 5.0 + radius) & (x < 10.0 - radius)
    rise = slope * (x - 5.0) + radius * (math.sqrt(1.0 + slope**2) - 1.0)
    assert got[inside] == pytest.approx(rise[inside], abs=1e-14)


def test_a_wheel_bridges_a_gap_narrower_than_itself():
    """On both edges of a hole of width w it sinks by R - sqrt(R^2 - w^2/4)."""
    hole = Profile(spacing=0.05, height=(0.0,) * 40 + (-1.0,) * 3 + (0.0, 0.0))
    got = knots(0, 100, FLAT, profile=hole, wheel=Wheel(radius=0.3))
    assert got.min() == pytest.approx(math.sqrt(0.3**2 - 0.1**2) - 0.3, abs=1e-15)
    assert np.argmin(got) == 41


def test_the_road_behind_the_start_is_level():
    """A drop that begins at the first knot: the wheel rolls off its edge."""
    drop = Profile(spacing=0.05, height=(0.0, -1.0, -1.0))
    got = knots(0, 20, FLAT, profile=drop, wheel=Wheel(radius=0.3))
    away = 0.05 * np.arange(7)
    assert got[0] == 0.0
    assert got[:6] == pytest.approx(np.sqrt(0.3**2 - away[:6] ** 2) - 0.3, abs=1e-15)
    assert got[7:] == pytest.approx(-1.0, abs=1e-15)


def test_a_wheel_of_many_knots_sees_the_whole_ring():
    road, wheel = Road(iso_class="E", knot_spacing=0.01), Wheel(radius=0.3)
    raw = knots(4, 500, road)
    expected = by_sampling(raw, 0.01, 0.3)
    assert np.abs(knots(4, len(expected), road, wheel=wheel) - expected).max() < 2e-9
