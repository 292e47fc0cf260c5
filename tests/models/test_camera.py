"""Images of blobs against geometry, brute force and the theory of lattice points in a disc."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import jv

from vr_envs.models.camera import (
    Camera,
    Ellipse,
    Window,
    find,
    frame_key,
    half_plane_coverage,
    outline,
    picture,
    project,
    projection,
    reflected,
    sensor,
    window_around,
)
from vr_envs.models.jit import kernel
from vr_envs.models.record import pack

QUIET = pack(Camera(noise=0.0))
NOISY = pack(Camera(noise=6.0))
HALF = math.sqrt(0.5)
MIRROR = (-0.07, 0.0, 0.0), (HALF, -HALF, 0.0)


def mirrored(point, place, normal):
    point, place, normal = (np.asarray(a) for a in (point, place, normal))
    return point - 2.0 * normal * (normal @ (point - place))


def disc(column, row, radius):
    return Ellipse(column, row, radius**2, 0.0, radius**2)


def test_points_are_projected_as_similar_triangles_say():
    view = projection(QUIET)
    for x, y, z in ((0.0, 0.0, 0.01), (0.02, 0.0, 0.0), (-0.01, 0.1, 0.03)):
        focal = 0.5 / 2.5e-4
        expected = focal * x / (0.5 + y), -focal * (z - 0.01) / (0.5 + y)
        assert project(view, x, y, z) == pytest.approx(expected, abs=1e-12)


def test_one_pixel_is_the_resolution_in_the_plane_of_the_ball():
    c0, r0 = project(projection(QUIET), 0.003, 0.0, 0.002)
    c1, r1 = project(projection(QUIET), 0.003 + 2.5e-4, 0.0, 0.002 + 2.5e-4)
    assert (c1 - c0, r1 - r0) == pytest.approx((1.0, -1.0), abs=1e-11)


@given(st.tuples(*[st.floats(-0.03, 0.03)] * 3))
def test_view_in_the_mirror_is_the_direct_view_of_the_mirror_image(point):
    direct = projection(QUIET)
    assert project(reflected(direct, *MIRROR), *point) == pytest.approx(
        project(direct, *mirrored(point, *MIRROR)), rel=1e-12
    )


def test_light_by_the_mirror_obeys_the_law_of_reflection():
    """The sight line from the camera to the mirror image meets the mirror where the true path is reflected."""
    eye, ball = np.array([0.0, -0.5, 0.01]), np.array([0.01, 0.004, 0.006])
    place, normal = (np.asarray(a) for a in MIRROR)
    image = mirrored(ball, *MIRROR)
    t = normal @ (place - eye) / (normal @ (image - eye))
    meets = eye + t * (image - eye)
    before, after = meets - eye, ball - meets
    before, after = before / np.linalg.norm(before), after / np.linalg.norm(after)
    assert after == pytest.approx(before - 2.0 * normal * (normal @ before), abs=1e-12)
    assert 0.0 < t < 1.0


def test_45_degree_mirror_looks_along_the_bar():
    """Height and depth, not the place along the bar, move the reflected image, to first order."""
    view = reflected(projection(QUIET), *MIRROR)
    c, r = project(view, 0.0, 0.0, 0.01)
    per_pixel = (0.5 + 0.07) / (0.5 / 2.5e-4)
    assert project(view, 0.0, per_pixel, 0.01)[0] - c == pytest.approx(1.0, abs=1e-9)
    assert project(view, 0.0, 0.0, 0.01 + per_pixel)[1] - r == pytest.approx(-1.0, abs=1e-9)


@pytest.mark.parametrize("place", [(0.0, 0.0, 0.01), (0.02, -0.01, 0.03), (-0.1, 0.05, 0.2)])
@pytest.mark.parametrize("mirror", [False, True])
def test_outline_of_a_sphere_is_where_lines_of_sight_touch_it(place, mirror):
    view = reflected(projection(QUIET), *MIRROR) if mirror else projection(QUIET)
    radius = 0.01
    shape = outline(view, place, (radius, radius, radius))
    eye = -np.linalg.solve(view[:, :3], view[:, 3])
    root = np.linalg.cholesky([[shape.cc, shape.cr], [shape.cr, shape.rr]])
    for angle in np.linspace(0.0, 6.0, 7):
        point = np.array([shape.column, shape.row]) + root @ [math.cos(angle), math.sin(angle)]
        ray = np.linalg.solve(view[:, :3], [*point, 1.0])
        away = np.asarray(place) - eye
        distance = np.linalg.norm(np.cross(ray, away)) / np.linalg.norm(ray)
        assert distance == pytest.approx(radius, rel=1e-9)


def test_outline_of_a_spot_is_the_image_of_its_rim():
    view = reflected(projection(QUIET), *MIRROR)
    place, radius = np.array([0.01, -0.005, 0.02]), 0.004
    shape = outline(view, place, (radius, 0.0, radius))
    inverse = np.linalg.inv([[shape.cc, shape.cr], [shape.cr, shape.rr]])
    for angle in np.linspace(0.0, 6.0, 7):
        point = project(view, *(place + radius * np.array([math.cos(angle), 0.0, math.sin(angle)])))
        offset = np.array(point) - [shape.column, shape.row]
        assert offset @ inverse @ offset == pytest.approx(1.0, rel=1e-8)


@given(st.floats(-1.0, 1.0), st.floats(0.0, 2.0 * math.pi))
def test_coverage_of_a_half_plane_is_exact(distance, angle):
    """Against the area of the polygon that is left of the square, cut by the line."""
    n = np.array([math.cos(angle), math.sin(angle)])
    corners = [np.array(c) for c in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))]
    kept = []
    for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
        da, db = distance + n @ a, distance + n @ b
        if da >= 0.0:
            kept.append(a)
        if (da >= 0.0) != (db >= 0.0):
            kept.append(a + (b - a) * da / (da - db))
    area = 0.0
    for a, b in zip(kept, kept[1:] + kept[:1], strict=True):
        area += 0.5 * (a[0] * b[1] - a[1] * b[0])
    assert half_plane_coverage(distance, n[0], n[1]) == pytest.approx(area, abs=1e-12)


@pytest.mark.parametrize("radius", [3.0, 10.0, 40.0])
def test_grey_levels_are_the_area_covered_within_the_stated_error(radius):
    window = Window(-50, -50, 101, 101)
    image = np.empty((101, 101))
    camera = pack(Camera(noise=0.0, black=0.0, white=255.0, threshold=128.0))
    column, row = 0.3, -0.17
    picture(1, 0, np.array([disc(column, row, radius)]), window, camera, image)
    across = (np.arange(101 * 256) + 0.5) / 256 - 50.5  # exact down the columns, fine across them
    chord = np.sqrt(np.maximum(0.0, radius**2 - (across - column) ** 2))
    top = np.arange(-50, 51)[:, None] - 0.5
    overlap = np.clip(row + chord, top, top + 1.0) - np.clip(row - chord, top, top + 1.0)
    area = overlap.reshape(101, 101, 256).mean(axis=2)
    assert np.abs(image / 255.0 - area).max() <= 1.0 / (8.0 * radius) + 0.5 / 255.0 + 1e-4


def test_centroid_of_a_disc_on_the_lattice_is_its_middle():
    for place in ((0.0, 0.0), (4.0, -3.0), (2.5, 1.0), (-1.5, 0.5)):  # centres of symmetry of the pixels
        for radius in (2.3, 7.7, 12.1):
            shape = disc(*place, radius)
            blob = find(np.uint64(1), shape, window_around(shape, sensor(QUIET)), None, QUIET)
            assert blob.whole
            assert (blob.column, blob.row) == pytest.approx(place, abs=1e-12)


@pytest.mark.parametrize("camera", [QUIET, NOISY, pack(Camera(noise=30.0))], ids=["quiet", "noisy", "loud"])
def test_centroid_is_that_of_the_white_pixels_of_the_picture(camera):
    """`find` draws no noise where none can matter; the picture draws it all: same pixels, bit for bit."""
    for exposure in range(20):
        shape = outline(projection(camera), (0.001 * exposure, 0.0, 0.004), (0.0025, 0.0025, 0.0025))
        window = window_around(shape, sensor(camera))
        image = np.empty((window.rows, window.columns), np.uint8)
        picture(7, exposure, np.array([shape]), window, camera, image)
        rows, columns = np.nonzero(image >= 120)
        blob = find(np.uint64(frame_key(7, exposure)), shape, window, None, camera)
        assert blob.white == len(rows)
        assert blob.column == (columns + window.column).sum() / len(rows)
        assert blob.row == (rows + window.row).sum() / len(rows)


@kernel
def centroids(places, radius, camera, out):
    region = sensor(camera)
    for k in range(places.shape[0]):
        shape = Ellipse(places[k, 0], places[k, 1], radius * radius, 0.0, radius * radius)
        blob = find(frame_key(3, k), shape, window_around(shape, region), None, camera)
        out[k, 0], out[k, 1] = blob.column, blob.row


@pytest.mark.parametrize("radius", [5.0, 10.5, 20.0])
def test_error_of_the_centroid_is_that_of_lattice_points_in_a_disc(radius):
    """Poisson summation: variance = sum over k of k_x^2 J_2(2 pi r |k|)^2 / (pi^2 |k|^4)."""
    k = np.arange(-300, 301)
    size = np.hypot(*np.meshgrid(k, k))
    size = size[size > 0]
    expected = math.sqrt(np.sum(0.5 * jv(2, 2.0 * np.pi * radius * size) ** 2 / size**2)) / math.pi
    n = 20_000
    places = np.random.default_rng(5).uniform(-0.5, 0.5, (n, 2))
    out = np.empty((n, 2))
    centroids(places, radius, QUIET, out)
    error = out - places
    assert error.std() == pytest.approx(expected, rel=0.03)
    assert np.abs(error.mean(axis=0)).max() < 4.0 * expected / math.sqrt(n)


def test_errors_fall_as_the_root_of_the_radius_in_pixels():
    n = 4000
    places = np.random.default_rng(6).uniform(-0.5, 0.5, (n, 2))
    errors = []
    radii = np.geomspace(4.0, 32.0, 12)
    for radius in radii:
        out = np.empty((n, 2))
        centroids(places, radius, QUIET, out)
        errors.append((out - places).std())
    assert np.polyfit(np.log(radii), np.log(errors), 1)[0] == pytest.approx(-0.5, abs=0.05)


def test_noise_is_a_function_of_key_and_exposure():
    shape = disc(0.2, 0.3, 8.0)
    camera = pack(Camera(noise=20.0))
    window = window_around(shape, sensor(camera))
    frames = [np.uint64(frame_key(key, exposure)) for key in (1, 2) for exposure in range(20)]
    places = {find(frame, shape, window, None, camera)[2:] for frame in frames}
    assert places == {find(frame, shape, window, None, camera)[2:] for frame in frames}
    assert len(places) > 30


def test_pixels_have_the_noise_and_the_eight_bits_they_should():
    image = np.empty((200, 200))
    camera = pack(Camera(noise=6.0, black=50.0))
    picture(1, 2, np.empty((0, 5)), Window(-100, -100, 200, 200), camera, image)
    assert image.mean() == pytest.approx(50.0, abs=4 * 6.0 / 200)
    assert image.std() == pytest.approx(math.sqrt(36.0 + 1.0 / 12.0), rel=4 / math.sqrt(2 * 40_000))
    assert np.array_equal(image, np.floor(image))
    picture(1, 2, np.empty((0, 5)), Window(-100, -100, 200, 200), pack(Camera(noise=100.0)), image)
    assert image.min() == 0.0 and image.max() == 255.0


@pytest.mark.parametrize("column", [-128.0, -120.0, 127.0, 135.0, 1e9, -1e300, math.nan, math.inf])
def test_blob_that_is_cut_off_or_gone_is_not_whole(column):
    shape = disc(column, 0.0, 10.0)
    blob = find(np.uint64(1), shape, window_around(shape, sensor(NOISY)), None, NOISY)
    assert not blob.whole


def test_blob_at_the_edge_is_whole_as_long_as_it_is_seen_whole():
    for column, whole in ((-116.6, True), (-118.0, False)):  # the sensor's first column is -128
        shape = disc(column, 0.0, 10.4)
        assert find(np.uint64(1), shape, window_around(shape, sensor(QUIET)), None, QUIET).whole is whole


def test_hidden_part_is_not_white_and_a_blob_half_hidden_is_not_whole():
    shape = disc(0.0, 0.0, 10.0)
    window = window_around(shape, sensor(QUIET))
    open_blob = find(np.uint64(1), shape, window, None, QUIET)
    for edge, whole in ((11.0, True), (5.0, True), (-1.0, False), (-11.0, False)):
        blob = find(np.uint64(1), shape, window, (0.0, 1.0, -edge), QUIET)  # hidden below row `edge`
        assert blob.whole is whole
        if edge > 10.0:
            assert blob == open_blob
        else:
            assert blob.white < open_blob.white
            assert not blob.row >= 0.0  # higher, or nowhere


def test_noise_that_drowns_the_ball_is_reported():
    shape = disc(0.0, 0.0, 10.0)
    camera = pack(Camera(noise=100.0))
    window = window_around(shape, sensor(camera))
    assert not any(find(np.uint64(frame_key(1, e)), shape, window, None, camera).whole for e in range(100))


@pytest.mark.parametrize(
    ("wrong", "text"),
    [({"threshold": 10.0}, "black < threshold < white"), ({"ball_radius": 1e-4}, "at least one pixel")],
)
def test_camera_that_cannot_work_is_refused(wrong, text):
    with pytest.raises(ValueError, match=text):
        Camera(**wrong)
