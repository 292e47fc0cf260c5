"""Places from images against the truth: exact without noise, and as good as the theory with it."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from vr_envs.models.camera import Camera, project, projection, reflected, sensor
from vr_envs.models.jit import kernel
from vr_envs.models.record import pack
from vr_envs.models.tracker import (
    back_projection,
    ball_images,
    bar_pose,
    in_plane,
    intersect,
    look,
    observe_ball,
    spot_images,
)

CAMERA = pack(Camera())
QUIET = pack(Camera(noise=0.0))
HALF = math.sqrt(0.5)
DIRECT = projection(CAMERA)
MIRRORED = reflected(DIRECT, (-0.07, 0.0, 0.0), (HALF, -HALF, 0.0))
POINT = st.tuples(*[st.floats(-0.03, 0.03)] * 3)


@given(POINT)
def test_two_lines_of_sight_meet_in_the_point(point):
    fix = intersect(
        back_projection(DIRECT), *project(DIRECT, *point), back_projection(MIRRORED), *project(MIRRORED, *point)
    )
    assert fix[:3] == pytest.approx(point, abs=1e-13)
    assert fix.gap < 1e-13


@given(st.lists(st.floats(-3.0, 3.0), min_size=4, max_size=4), POINT)
def test_lines_that_miss_are_intersected_in_the_sense_of_least_squares(wrong, point):
    backs = back_projection(DIRECT), back_projection(MIRRORED)
    images = np.array([*project(DIRECT, *point), *project(MIRRORED, *point)]) + wrong
    rays = [back[:, :3] @ [*image, 1.0] for back, image in zip(backs, (images[:2], images[2:]), strict=True)]
    rays = [r / np.linalg.norm(r) for r in rays]

    def away(p):
        return np.concatenate([np.cross(p - back[:, 3], r) for back, r in zip(backs, rays, strict=True)])

    # linear in p: its own least squares, by another method
    design = np.column_stack([away(e) - away(np.zeros(3)) for e in np.eye(3)])
    best = np.linalg.lstsq(design, -away(np.zeros(3)), rcond=None)[0]
    fix = intersect(backs[0], *images[:2], backs[1], *images[2:])
    assert fix[:3] == pytest.approx(best, abs=1e-12)
    assert fix.gap**2 / 2.0 == pytest.approx(np.sum(away(best) ** 2), rel=1e-6, abs=1e-20)


def test_back_projection_inverts_any_view():
    view = np.random.default_rng(1).normal(size=(3, 4))
    back = back_projection(view)
    assert back[:, :3] @ view[:, :3] == pytest.approx(np.eye(3), abs=1e-12)
    assert view[:, :3] @ back[:, 3] == pytest.approx(-view[:, 3], abs=1e-12)


def test_point_in_a_known_plane_needs_one_view():
    point = (0.012, -0.005, 0.003)
    assert in_plane(back_projection(DIRECT), *project(DIRECT, *point), -0.005) == pytest.approx(
        (0.012, 0.003), abs=1e-14
    )


def markers(pose, body):
    x, z, tilt = pose
    turned = Rotation.from_rotvec([0.0, tilt, 0.0]).apply(
        np.column_stack([body[:, 0], np.zeros(len(body)), body[:, 1]])
    )
    return turned[:, [0, 2]] + [x, z]


@given(st.floats(-0.01, 0.01), st.floats(-0.01, 0.01), st.floats(-3.0, 3.0))
def test_pose_of_the_bar_is_exact_and_right_handed_about_y(x, z, tilt):
    body = np.array([[-0.02, -0.005], [0.003, 0.002], [0.018, -0.004], [0.0, 0.01]])
    pose = bar_pose(body, markers((x, z, tilt), body))
    assert pose[:3] == pytest.approx((x, z, tilt), abs=1e-12)
    assert pose.rms < 1e-14


def test_positive_tilt_lowers_the_right_end():
    body = np.array([[-0.02, 0.0], [0.02, 0.0]])
    assert bar_pose(body, np.array([[-0.02, 0.001], [0.02, -0.001]])).tilt > 0.0


def test_pose_has_least_squared_distance():
    rng = np.random.default_rng(2)
    body = np.array([[-0.02, -0.005], [0.003, 0.002], [0.018, -0.004]])
    seen = markers((0.001, 0.002, 0.1), body) + rng.normal(size=(3, 2)) * 1e-4
    best = least_squares(lambda p: (markers(p, body) - seen).ravel() * 1e3, (0.0, 0.0, 0.0), xtol=1e-15, ftol=1e-15)
    pose = bar_pose(body, seen)
    assert pose[:3] == pytest.approx(best.x, abs=1e-9)
    assert pose.rms == pytest.approx(1e-3 * math.sqrt(2.0 * best.cost / 3.0), rel=1e-6)


def test_ball_is_seen_where_it_is():
    rng = np.random.default_rng(3)
    wrong = []
    for k in range(500):
        x, z = rng.uniform(-0.025, 0.025), rng.uniform(-0.003, 0.025)
        seen, x_seen, z_seen = look(11, k, x, z, CAMERA)
        assert seen
        wrong.append((x_seen - x, z_seen - z))
    rms = np.sqrt(np.mean(np.square(wrong), axis=0))
    assert np.abs(np.mean(wrong, axis=0)).max() < 4.0 * 1.3e-5 / math.sqrt(500)
    assert rms == pytest.approx([1.3e-5] * 2, rel=0.1)  # 0.051 pixel, see the theory in test_camera


def test_observation_has_place_and_mean_velocity_of_the_last_frame():
    sight = observe_ball(5, 9, 0.001, 0.004, 0.0012, 0.0037, CAMERA)
    before, after = look(5, 18, 0.001, 0.004, CAMERA), look(5, 19, 0.0012, 0.0037, CAMERA)
    assert sight == (True, after[1], after[2], 500.0 * (after[1] - before[1]), 500.0 * (after[2] - before[2]))
    assert sight == observe_ball(5, 9, 0.001, 0.004, 0.0012, 0.0037, CAMERA)
    assert sight[1:] == pytest.approx((0.0012, 0.0037, 0.1, -0.15), abs=0.05)
    assert observe_ball(5, 10, 0.001, 0.004, 0.0012, 0.0037, CAMERA) != sight
    assert observe_ball(6, 9, 0.001, 0.004, 0.0012, 0.0037, CAMERA) != sight


@pytest.mark.parametrize("place", [(0.0, 0.03), (0.05, 0.0), (0.0, -0.02), (math.nan, 0.0), (1e300, 0.0)])
def test_ball_out_of_the_image_is_reported(place):
    seen, x, z = look(1, 0, *place, CAMERA)
    assert not seen and math.isnan(x) and math.isnan(z)
    for places in ((*place, 0.0, 0.0), (0.0, 0.0, *place)):
        sight = observe_ball(1, 0, *places, CAMERA)
        assert not sight.seen
        assert all(math.isnan(v) for v in sight[1:])


def test_ball_behind_the_raised_end_of_the_bar_is_reported():
    """The bar hides what lies below the image of its edge: half a ball or less is no ball."""
    places = np.array([[0.0, 0.0, 0.005]])
    edge = project(MIRRORED, 0.0, 0.0, 0.006)[1]  # row, above the ball's middle
    out = np.empty((1, 2))
    region = sensor(CAMERA)._replace(column=-320)
    ball_images(1, places, MIRRORED, region, None, CAMERA, out)
    assert np.isfinite(out).all()
    ball_images(1, places, MIRRORED, region, (0.0, 1.0, -edge), CAMERA, out)
    assert np.isnan(out).all()


def test_spots_are_seen_where_they_are():
    places = np.random.default_rng(4).uniform((-0.02, -0.005, -0.005), (0.02, -0.005, 0.02), (100, 3, 3))
    out = np.empty((100, 3, 2))
    spot_images(1, places, 0.0015, DIRECT, sensor(CAMERA), CAMERA, out)
    true = np.array([[project(DIRECT, *p) for p in row] for row in places])
    assert np.sqrt(np.mean((out - true) ** 2)) == pytest.approx(0.065, rel=0.25)


@kernel
def _many(n, camera):
    total = 0.0
    for k in range(n):
        total += observe_ball(3, k, 0.001, 0.002, 0.0011, 0.0019, camera).x
    return total


def test_observation_is_called_from_kernels():
    assert _many(50, CAMERA) / 50 == pytest.approx(0.0011, abs=4e-5)


def test_without_noise_an_exposure_needs_no_key():
    assert look(1, 2, 0.003, 0.004, QUIET) == look(8, 9, 0.003, 0.004, QUIET)
