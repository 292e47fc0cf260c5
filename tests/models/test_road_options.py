import math
from pathlib import Path

import numpy as np
import pytest

from vr_envs.models.road_options import POINTS, Bumps, Obstacle, Profile, Road, Wheel, check_road

EXAMPLE = Path(__file__).resolve().parents[2] / "docs" / "road_profile.csv"


@pytest.fixture
def profile(tmp_path):
    def read(rows):
        path = tmp_path / "road.csv"
        path.write_text("distance_m,height_m\n" + "".join(f"{x},{z}\n" for x, z in rows))
        return Profile.read(str(path))

    return read


def check(**options):
    check_road({name: options.get(name) for name in ("road", "profile", "bumps", "obstacle", "wheel")})


@pytest.mark.parametrize("letter", "ABCDEFGH")
def test_class_means_are_those_of_the_standard(letter):
    means = {"A": 16, "B": 64, "C": 256, "D": 1024, "E": 4096, "F": 16384, "G": 65536, "H": 262144}
    assert Road(iso_class=letter).density == pytest.approx(1e-6 * means[letter], rel=1e-15)


def test_equally_spaced_points_are_taken_as_they_are(profile):
    heights = np.random.default_rng(0).normal(size=50).round(4)
    for places in (0.05 * np.arange(50), 1234.5 + 3.0 * np.arange(50), (np.arange(50) / 3).round(3)):
        fields = profile(zip(places, heights, strict=True))
        assert fields["height"] == tuple(heights)
        assert fields["spacing"] == pytest.approx((places[-1] - places[0]) / 49, rel=1e-12)


def test_other_points_are_replaced_at_the_smallest_distance(profile):
    places, heights = [5.0, 7.0, 7.4, 7.9, 10.0], [1.0, 2.0, 0.0, 3.0, -1.0]
    fields = profile(zip(places, heights, strict=True))
    assert fields["spacing"] == pytest.approx(0.4, rel=1e-12)
    assert len(fields["height"]) == 14  # 5 m in pieces of 0.4 m, the last one beyond the end
    expected = np.interp(5.0 + 0.4 * np.arange(14), places, heights)
    assert fields["height"] == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    ("rows", "told"),
    [
        ([], "has 0 points; give at least 2"),
        ([(0, 0)], "has 1 points; give at least 2"),
        ([(0, 0), (1, 0), (1, 1)], "line 4: distance_m = 1 is not allowed; it must be above the 1 before it"),
        ([(0, 0), (2, 0), (1, 1)], "line 4: distance_m = 1 is not allowed; it must be above the 2 before it"),
        ([(i, 0) for i in range(POINTS + 1)], f"points 1 m apart over {POINTS} m are not allowed"),
        ([(0, 0), (1e-300, 0), (1e300, 0)], f"give at most {POINTS} points"),
    ],
)
def test_a_profile_that_cannot_be_used_says_why(profile, rows, told):
    with pytest.raises(ValueError) as error:
        profile(rows)
    assert told in str(error.value)


def test_the_largest_profile_is_allowed(profile):
    assert len(profile([(0.1 * i, 0) for i in range(POINTS)])["height"]) == POINTS
    assert len(profile([(0, 0), (0.1, 0), (0.1 * (POINTS - 1), 0)])["height"]) == POINTS


def test_the_example_is_the_hump_that_it_says(profile):
    """An arc of a circle, 3.7 m by 0.1 m, between level pieces."""
    fields = Profile.read(EXAMPLE)
    assert fields["spacing"] == pytest.approx(0.1, rel=1e-12)
    x = 0.1 * np.arange(401)
    radius = (1.85**2 + 0.1**2) / 0.2
    hump = np.maximum(0.0, np.sqrt(radius**2 - np.minimum(abs(x - 21.85), 2.0) ** 2) - radius + 0.1)
    assert fields["height"] == pytest.approx(hump, abs=6e-6)  # five decimals
    assert max(fields["height"]) == pytest.approx(0.1, abs=1e-4)


@pytest.mark.parametrize(
    "option", [{"profile": Profile()}, {"bumps": Bumps()}, {"obstacle": Obstacle()}, {"wheel": Wheel()}]
)
def test_what_lies_on_a_road_needs_one(option):
    (name,) = option
    with pytest.raises(
        ValueError, match=f"{name} = .* is not allowed without a road; give road = true, or {name} = null"
    ):
        check(**option)
    check(road=Road(), **option)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"profile": Profile(0.1, (0.0, 1.0))}, "road.knot_spacing = 0.2 .* profile.spacing = 0.1"),
        ({"bumps": Bumps(low=0.1, high=0.09)}, "bumps.low = 0.1 .* bumps.high = 0.09"),
        ({"bumps": Bumps(shortest=3.1)}, "bumps.shortest = 3.1 .* bumps.longest = 3"),
        ({"bumps": Bumps(stretch=5.9)}, "2 bumps.longest = 6 .* bumps.stretch = 5.9"),
        ({"obstacle": Obstacle(length=0.79)}, "4 road.knot_spacing = 0.8 .* obstacle.length = 0.79"),
        ({"obstacle": Obstacle("ramp", length=0.79)}, "4 road.knot_spacing = 0.8 .* obstacle.length = 0.79"),
        ({"obstacle": Obstacle("washboard", pitch=0.79)}, "4 road.knot_spacing = 0.8 .* obstacle.pitch = 0.79"),
        ({"obstacle": Obstacle("washboard", pitch=2.1)}, "obstacle.pitch = 2.1 .* obstacle.length = 2"),
        ({"obstacle": Obstacle("kerb", top=0.19)}, "road.knot_spacing = 0.2 .* obstacle.top = 0.19"),
        ({"obstacle": Obstacle("ramp", every=5.9)}, "the ramp's whole length = 6 .* obstacle.every = 5.9"),
        ({"obstacle": Obstacle("washboard", length=2.9, every=1.9)}, "whole length = 2 .* obstacle.every = 1.9"),
        ({"wheel": Wheel(6.1)}, "wheel.radius = 6.1 .* 30 road.knot_spacing = 6"),
    ],
)
def test_rules_say_what_was_given_and_what_is_allowed(options, told):
    with pytest.raises(ValueError, match=told.replace(".*", "is not allowed; it must not exceed")):
        check(road=Road(), **options)


def test_what_just_fits_is_allowed():
    check(road=Road(knot_spacing=0.1), profile=Profile(3 * 0.1 - 0.2, (0.0, 1.0)), wheel=Wheel(3.0))
    check(road=Road(), obstacle=Obstacle(length=0.8, every=0.8), bumps=Bumps(stretch=6.0, low=0.08, shortest=3.0))
    assert Obstacle("washboard", pitch=0.1, length=0.3).extent == pytest.approx(0.3, rel=1e-15)
    assert math.isclose(Obstacle("ramp").extent, 6.0)
