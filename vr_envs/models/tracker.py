"""Places from images: ball in the plane or in space, pose of the bar.

Source: Bell (bouncing-ball report), section II: the area centroid in each of two views gives two lines of sight, and
least squares their intersection. Frame and views: `models/camera.py`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vr_envs.models.camera import find, frame_key, outline, projection, sensor, window_around
from vr_envs.models.jit import kernel


class Sight(NamedTuple):
    """What two exposures tell of a ball in the plane y = 0: place (m) and velocity (m/s); NaN unless `seen`."""

    seen: bool
    x: float
    z: float
    u: float
    w: float


class Fix(NamedTuple):
    """A place in space (m) and the distance between the two lines of sight that it lies midway between (m)."""

    x: float
    y: float
    z: float
    gap: float


class Pose(NamedTuple):
    """The bar: x and z of its reference point (m), tilt (rad), rms distance of a marker from its place (m)."""

    x: float
    z: float
    tilt: float
    rms: float


@kernel
def ball_blob(frame, place, view, region, cover, camera):
    """`Blob` of the ball at `place` (x, y, z) in the window `region` of an image; the other arguments: `find`."""
    r = camera.ball_radius
    shape = outline(view, place, (r, r, r))
    return find(frame, shape, window_around(shape, region), cover, camera)


@kernel
def spot_blob(frame, place, radius, view, region, camera):
    """`Blob` of a round white spot that faces the camera."""
    shape = outline(view, place, (radius, 0.0, radius))
    return find(frame, shape, window_around(shape, region), None, camera)


@kernel
def look(key, exposure, x, z, camera):
    """(seen, x, z): the ball at (x, 0, z) as one exposure of a calibrated camera shows it, m; NaN unless seen.

    Args:
        key: key of the episode.
        exposure: number of the exposure >= 0; the noise is a pure function of key and exposure.
        x, z: true place of the ball's centre, m.
        camera: record of `Camera`.
    """
    blob = ball_blob(frame_key(key, exposure), (x, 0.0, z), projection(camera), sensor(camera), None, camera)
    if not blob.whole:
        return False, math.nan, math.nan
    return True, camera.resolution * blob.column, camera.height - camera.resolution * blob.row


@kernel
def observe_ball(key, counter, x0, z0, x1, z1, camera):
    """`Sight` of a ball in the plane from its last two exposures.

    The place is that of the second exposure, the velocity the difference of the two places in one frame: the mean over
    it, g / (2 frame_rate) = 10 mm/s behind in free fall at 500 Hz, and meaningless when the ball hits the bar in it.

    Args:
        key: key of the episode.
        counter: number of the observation >= 0, not used before; its exposures are 2 counter and 2 counter + 1.
        x0, z0: true place at the exposure one frame before the last, m.
        x1, z1: true place at the last exposure, m.
        camera: record of `Camera`.
    """
    seen_0, xa, za = look(key, 2 * counter, x0, z0, camera)
    seen_1, xb, zb = look(key, 2 * counter + 1, x1, z1, camera)
    if not (seen_0 and seen_1):
        return Sight(False, math.nan, math.nan, math.nan, math.nan)
    return Sight(True, xb, zb, (xb - xa) * camera.frame_rate, (zb - za) * camera.frame_rate)


@kernel
def back_projection(view):
    """(3, 4): in column 3 the camera's place -M^-1 p, before it M^-1, of `view` = [M | p]; singular M gives NaN.

    The line of sight of an image point runs from that place along M^-1 (column, row, 1).
    """
    back = np.empty((3, 4))
    for i in range(3):
        for j in range(3):  # cyclic minors: the adjugate without signs
            a, b, c, d = (j + 1) % 3, (j + 2) % 3, (i + 1) % 3, (i + 2) % 3
            back[i, j] = view[a, c] * view[b, d] - view[a, d] * view[b, c]
    det = view[0, 0] * back[0, 0] + view[0, 1] * back[1, 0] + view[0, 2] * back[2, 0]
    for i in range(3):
        for j in range(3):
            back[i, j] /= det
        back[i, 3] = -(back[i, 0] * view[0, 3] + back[i, 1] * view[1, 3] + back[i, 2] * view[2, 3])
    return back


@kernel
def _direction(back, column, row):
    return (
        back[0, 0] * column + back[0, 1] * row + back[0, 2],
        back[1, 0] * column + back[1, 1] * row + back[1, 2],
        back[2, 0] * column + back[2, 1] * row + back[2, 2],
    )


@kernel
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def intersect(back_1, column_1, row_1, back_2, column_2, row_2):
    """`Fix` of least squared distance to two lines of sight, given as back projections and image points.

    That point is the middle of the common perpendicular. Parallel lines give NaN or infinity.
    """
    p = _direction(back_1, column_1, row_1)
    q = _direction(back_2, column_2, row_2)
    base = back_2[0, 3] - back_1[0, 3], back_2[1, 3] - back_1[1, 3], back_2[2, 3] - back_1[2, 3]
    pp, pq, qq = _dot(p, p), _dot(p, q), _dot(q, q)
    bp, bq = _dot(base, p), _dot(base, q)
    det = pp * qq - pq * pq
    s = (bp * qq - bq * pq) / det
    t = (bp * pq - bq * pp) / det
    x1, y1, z1 = back_1[0, 3] + s * p[0], back_1[1, 3] + s * p[1], back_1[2, 3] + s * p[2]
    x2, y2, z2 = back_2[0, 3] + t * q[0], back_2[1, 3] + t * q[1], back_2[2, 3] + t * q[2]
    gap = math.sqrt((x2 - x1) ** 2 + (y2 - y1) ** 2 + (z2 - z1) ** 2)
    return Fix(0.5 * (x1 + x2), 0.5 * (y1 + y2), 0.5 * (z1 + z2), gap)


@kernel
def in_plane(back, column, row, y):
    """(x, z) where the line of sight of an image point meets the plane at `y`, m."""
    d = _direction(back, column, row)
    s = (y - back[1, 3]) / d[1]
    return back[0, 3] + s * d[0], back[2, 3] + s * d[2]


@kernel
def bar_pose(body, seen):
    """`Pose` by least squares: rotation and shift of the markers' places on the bar onto where they are seen.

    Args:
        body: (n, 2) x and z of each marker from the bar's reference point, m, n >= 2.
        seen: (n, 2) x and z of each marker in space, m.
    """
    n = body.shape[0]
    bx = bz = sx = sz = 0.0
    for k in range(n):
        bx += body[k, 0] / n
        bz += body[k, 1] / n
        sx += seen[k, 0] / n
        sz += seen[k, 1] / n
    along = across = 0.0
    for k in range(n):
        x, z = body[k, 0] - bx, body[k, 1] - bz
        along += x * (seen[k, 0] - sx) + z * (seen[k, 1] - sz)
        across += z * (seen[k, 0] - sx) - x * (seen[k, 1] - sz)
    tilt = math.atan2(across, along)
    cos, sin = math.cos(tilt), math.sin(tilt)
    x0, z0 = sx - cos * bx - sin * bz, sz + sin * bx - cos * bz
    total = 0.0
    for k in range(n):
        dx = x0 + cos * body[k, 0] + sin * body[k, 1] - seen[k, 0]
        dz = z0 - sin * body[k, 0] + cos * body[k, 1] - seen[k, 1]
        total += (dx * dx + dz * dz) / n
    return Pose(x0, z0, tilt, math.sqrt(total))


@kernel
def ball_images(key, places, view, region, cover, camera, out):
    """Write (column, row) of each ball place (n, 3) in exposures 0 to n - 1 to `out` (n, 2); NaN unless seen whole."""
    for k in range(places.shape[0]):
        blob = ball_blob(
            frame_key(key, k), (places[k, 0], places[k, 1], places[k, 2]), view, region, cover, camera
        )  # fmt: skip
        out[k, 0] = blob.column if blob.whole else math.nan
        out[k, 1] = blob.row if blob.whole else math.nan


@kernel
def spot_images(key, places, radius, view, region, camera, out):
    """`ball_images` of spots: `places` (n, m, 3) of m spots in each of n exposures, `out` (n, m, 2)."""
    for k in range(places.shape[0]):
        frame = frame_key(key, k)
        for i in range(places.shape[1]):
            blob = spot_blob(frame, (places[k, i, 0], places[k, i, 1], places[k, i, 2]), radius, view, region, camera)
            out[k, i, 0] = blob.column if blob.whole else math.nan
            out[k, i, 1] = blob.row if blob.whole else math.nan


@kernel
def intersections(back_1, images_1, back_2, images_2, out):
    """`intersect` row by row: image points (n, 2) twice, `out` (n, 4)."""
    for k in range(images_1.shape[0]):
        out[k] = intersect(back_1, images_1[k, 0], images_1[k, 1], back_2, images_2[k, 0], images_2[k, 1])
