"""Calibration finds the true cameras, and refuses what cannot calibrate one."""

import math

import numpy as np
import pytest

from vr_envs.experiments.calibration import calibrate, projected
from vr_envs.experiments.vision_rig import Rig, target
from vr_envs.models.tracker import back_projection


@pytest.mark.parametrize("k", [0, 1])
def test_true_camera_is_found_from_true_images(k):
    view, places = Rig().views[k], target(1)
    found = calibrate(places, projected(view, places))
    assert found.view == pytest.approx(view / np.linalg.norm(view), abs=1e-9)
    assert found.rms < 1e-9
    assert back_projection(found.view)[:, 3] == pytest.approx(back_projection(view)[:, 3], abs=1e-9)


def test_any_camera_is_found_from_the_fewest_points():
    rng = np.random.default_rng(2)
    view = np.array([[900.0, 30.0, -20.0, 5.0], [10.0, 40.0, -950.0, 8.0], [0.1, 1.0, 0.05, 2.0]])
    places = rng.uniform(-0.5, 0.5, (6, 3))
    found = calibrate(places, projected(view, places)).view
    assert found == pytest.approx(view / np.linalg.norm(view), abs=1e-9)


def test_refinement_reaches_the_least_distance_in_the_image():
    """No small change of the camera lowers the sum of squares; its residual is that of 2n - 11 free errors."""
    rng = np.random.default_rng(3)
    view, residuals = Rig().views[0], []
    for i in range(40):
        places = target(i)
        images = projected(view, places) + 0.3 * rng.standard_normal((len(places), 2))
        found = calibrate(places, images)
        residuals.append(found.rms)
        if i == 0:
            for step in 1e-6 * rng.standard_normal((20, 3, 4)) * np.abs(found.view):
                assert np.mean((projected(found.view + step, places) - images) ** 2) >= found.rms**2
    free = 1.0 - 11.0 / 160.0
    assert np.mean(np.square(residuals)) == pytest.approx(0.09 * free, rel=4.0 * math.sqrt(2.0 / (40 * 149)))


def test_points_in_a_plane_are_refused():
    places = target(1).copy()
    places[:, 1] = 0.0
    with pytest.raises(ValueError, match="one plane"):
        calibrate(places, projected(Rig().views[0], places))


def test_bad_input_is_refused():
    places = target(1)
    images = projected(Rig().views[0], places)
    with pytest.raises(ValueError, match="n >= 6"):
        calibrate(places[:5], images[:5])
    with pytest.raises(ValueError, match=r"\(79, 2\)"):
        calibrate(places, images[:-1])
    images[3, 0] = math.nan
    with pytest.raises(ValueError, match="not seen"):
        calibrate(places, images)
