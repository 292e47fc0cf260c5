"""The vision apparatus and its theory; both experiments agree with it and draw."""

import math

import numpy as np
import pytest
from scipy.special import jv

from vr_envs.experiments import vision, vision_error
from vr_envs.experiments.catalogue import EXPERIMENTS
from vr_envs.experiments.vision_rig import (
    Rig,
    bar_poses,
    centroid_error,
    locate,
    marker_places,
    predicted_error,
    target,
)
from vr_envs.models.camera import Camera, project


@pytest.mark.parametrize("radius", [3.0, 8.77, 10.0, 25.3])
def test_error_of_the_centroid_is_the_exact_sum_over_the_lattice(radius):
    k = np.arange(-400, 401)
    size = np.hypot(*np.meshgrid(k, k))
    size = size[size > 0]
    exact = math.sqrt(np.sum(0.5 * jv(2, 2.0 * np.pi * radius * size) ** 2 / size**2)) / math.pi
    assert centroid_error(radius, 0.0) == pytest.approx(exact, rel=3e-3)


def test_mean_error_of_the_centroid_is_0_152_over_the_root_of_the_radius():
    radii = np.linspace(20.0, 24.0, 400)
    mean = np.sqrt(np.mean([centroid_error(r, 0.0) ** 2 * r for r in radii]))
    assert mean == pytest.approx(math.sqrt(9.0336 / 4.0) / math.pi**2, rel=0.01)


def test_error_in_space_is_that_of_each_view_carried_to_its_axis():
    """On the axis: x from the direct view alone, y from the mirror alone, z the mean of both."""
    rig = Rig()
    place = np.array([0.0, 0.0, rig.camera.height])
    found = predicted_error(rig, place)
    far = rig.camera.distance - rig.mirror
    noise = 4.0 / 200.0
    direct = 2.5e-4 * centroid_error(10.0, noise)
    mirrored = 2.5e-4 * far / 0.5 * centroid_error(10.0 * 0.5 / far, noise)
    # the reflected line of sight is tan(7 degrees) off the axis, a second-order change of these
    assert found == pytest.approx([direct, mirrored, 0.5 * math.hypot(direct, mirrored)], rel=0.02)


def test_ball_is_located_in_space_with_calibrated_cameras():
    rig = Rig()
    direct, mirrored = rig.calibrated(key=1)
    places = np.random.default_rng(4).uniform((-0.02, -0.01, 0.0), (0.02, 0.01, 0.02), (300, 3))
    fixes = locate((direct.view, mirrored.view), rig.ball_images(places, 0, 5), rig.ball_images(places, 1, 6))
    wrong = fixes[:, :3] - places
    assert np.sqrt(np.mean(wrong**2, axis=0)) == pytest.approx(predicted_error(rig, places[0]), rel=0.25)
    assert fixes[:, 3].max() < 1e-4


def test_places_that_one_view_does_not_show_are_nan():
    rig = Rig()
    places = np.array([[0.0, 0.0, 0.0], [0.0, 0.05, 0.0], [0.06, 0.0, 0.0]])
    fixes = locate(rig.views, rig.ball_images(places, 0, 1), rig.ball_images(places, 1, 2))
    assert np.isfinite(fixes[0]).all()
    assert np.isnan(fixes[1:]).all()


def test_bar_is_found_from_its_markers():
    rig = Rig(Camera(noise=0.0))
    poses = np.array([[0.001, 0.0005, 0.02], [-0.002, 0.0, -0.05]])
    images = np.array([[project(rig.views[0], *place) for place in row] for row in marker_places(poses)])
    assert bar_poses(rig.views[0], images)[:, :3] == pytest.approx(poses, abs=1e-12)
    assert bar_poses(rig.views[0], rig.marker_images(poses, 1))[:, :3] == pytest.approx(poses, abs=3e-3)


def test_targets_are_seen_whole_in_both_views():
    rig = Rig()
    for key in range(20):
        assert all(np.isfinite(rig.ball_images(target(key), k, key)).all() for k in (0, 1))


def plain(items, *, desc):
    return items


@pytest.mark.parametrize("name", ["vision", pytest.param("vision-error", marks=pytest.mark.slow)])
def test_experiment_finds_what_it_expects_and_draws(name):
    figure = pytest.importorskip("matplotlib.figure").Figure()
    outcome = EXPERIMENTS[name].run(plain)
    assert [f.what for f in outcome.findings if not f.agrees] == []
    for table in outcome.tables.values():
        assert len({len(column) for column in table.values()}) == 1
        assert all(np.isfinite(column).all() for column in table.values())
    outcome.draw(figure)
    figure.canvas.draw()


def test_regions_exposed_in_turn_shift_the_height_by_half_the_way():
    """The mean of z now and z half a millisecond later, to the rounding of a noiseless camera."""
    track = vision._track(Rig(), Rig().views)
    shift = (track["in_turn"] - track["together"])[:, 2]
    way = 0.5 * (track["later"] - track["truth"])[:, 2]
    assert np.corrcoef(shift, way)[0, 1] > 0.95
    assert np.polyfit(way, shift, 1)[0] == pytest.approx(1.0, abs=0.05)


def test_noise_that_drowns_the_ball_is_counted():
    quiet, loud = (vision_error._errors(Camera(noise=n), 1)["lost"] for n in (4.0, 40.0))
    assert quiet == 0.0
    assert loud > 0.5
