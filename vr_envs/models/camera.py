"""A camera that sees white blobs on black: pinhole, flat mirror, pixels, noise, threshold, area centroid.

Source: Bell (bouncing-ball report), section II. Frame: x to the right along the bar, y away from the camera, z up; the
origin is the centre of a ball that rests in the middle of the bar at its mean height. The camera looks along +y.
A view is a 3 x 4 projection matrix: (column, row, 1) ~ view (x, y, z, 1), columns to the right, rows downwards, pixel
(i, j) the unit square about (i, j), and the optical axis at (0, 0).

The image of a sphere or of a round spot is exactly an ellipse (the dual conic view Q* view^T of its dual quadric Q*).
A pixel's coverage is that of the half plane which meets the ellipse at its nearest point (nearest to first order): the
edge is taken as straight within one pixel, an error of at most 1 / (8 r) of a pixel's area for a disc of r pixels. The
exposure is short: no motion blur. Blobs are rendered one by one: they do not overlap.
"""

from __future__ import annotations

import dataclasses
import math
from typing import NamedTuple

import numpy as np

from vr_envs.models.jit import kernel
from vr_envs.models.noise import bits, normal_pair
from vr_envs.models.record import quantity

MARGIN = 3.0  # pixels between a blob and the edge of the window it is looked for in
_LARGEST_DEVIATE = 8.58  # no `normal_pair` is larger: sqrt(2 * 53 log 2) = 8.572
_STREAM = 3 << 61  # draw of the episode's key, apart from all others, that starts the camera's own sequences
_CORNER = 0.7072  # pixels from the centre of a pixel to its corner, rounded up
_SIDE = 1 << 15  # pixels are numbered on a sensor of 2 * _SIDE by 2 * _SIDE


@dataclasses.dataclass(frozen=True)
class Camera:
    """Option: a high-speed camera that sees the ball (Bell section II). Place and velocity come from two exposures."""

    DERIVED = ("focal_length",)

    frame_rate: float = quantity(500.0, "Hz", "exposures of the ball in a second (Bell)", low=1.0, high=1e5)
    latency: float = quantity(0.002, "s", "from the last exposure to the observation", low=0.0, high=1.0)
    resolution: float = quantity(2.5e-4, "m/pixel", "side of a pixel in the plane of the ball", low=1e-6, high=0.1)
    distance: float = quantity(0.5, "m", "from the camera to the plane of the ball", low=0.01, high=100.0)
    height: float = quantity(0.01, "m", "of the optical axis above the centre of a resting ball", low=-10.0, high=10.0)
    columns: int = quantity(256, "pixel", "width of the image", low=8, high=_SIDE)
    rows: int = quantity(160, "pixel", "height of the image", low=8, high=_SIDE)
    white: float = quantity(220.0, "grey level", "of the ball and the markers", low=0.0, high=255.0)
    black: float = quantity(20.0, "grey level", "of the background", low=0.0, high=255.0)
    noise: float = quantity(4.0, "grey level", "standard deviation of a pixel", low=0.0, high=100.0)
    threshold: float = quantity(120.0, "grey level", "from which a pixel counts as white", low=0.0, high=255.0)
    ball_radius: float = quantity(0.0025, "m", "radius of the ball", low=1e-5, high=1.0)

    def __post_init__(self) -> None:
        """Refuse a threshold or a ball that cannot work."""
        if not self.black < self.threshold < self.white:
            raise ValueError(
                f"camera: black = {self.black:g}, threshold = {self.threshold:g}, white = {self.white:g} grey levels; "
                "give black < threshold < white"
            )
        if not self.resolution <= self.ball_radius < 0.5 * self.distance:
            raise ValueError(
                f"camera: ball_radius = {self.ball_radius:g} m; give at least one pixel, resolution = "
                f"{self.resolution:g} m, and less than half the distance = {self.distance:g} m"
            )

    @property
    def focal_length(self) -> float:
        """Focal length in pixels."""
        return self.distance / self.resolution


class Ellipse(NamedTuple):
    """The points p with (p - centre)^T S^-1 (p - centre) <= 1, in pixels; S = ((cc, cr), (cr, rr))."""

    column: float
    row: float
    cc: float
    cr: float
    rr: float


class Window(NamedTuple):
    """A rectangle of pixels: first column and row, and how many."""

    column: int
    row: int
    columns: int
    rows: int


class Blob(NamedTuple):
    """White pixels in a window: their number, their centroid (NaN without any), and whether they are a whole blob.

    It is whole when no white pixel lies on the window's border and the number is within a factor of 2 of the area
    expected: a blob that is cut off, hidden or drowned in noise is not.
    """

    whole: bool
    white: int
    column: float
    row: float


@kernel
def projection(camera):
    """View (3, 4) of a camera at (0, -distance, height) that looks along +y."""
    view = np.zeros((3, 4))
    view[0, 0] = camera.focal_length
    view[1, 2] = -camera.focal_length
    view[1, 3] = camera.focal_length * camera.height
    view[2, 1] = 1.0
    view[2, 3] = camera.distance
    return view


@kernel
def reflected(view, point, normal):
    """View (3, 4) through a flat mirror: `view` of mirror images, X - 2 (n (X - point)) n with unit normal n.

    A camera before a mirror sees what the virtual camera, its own mirror image, would see directly.
    """
    virtual = np.empty((3, 4))
    offset = normal[0] * point[0] + normal[1] * point[1] + normal[2] * point[2]
    for i in range(3):
        along = view[i, 0] * normal[0] + view[i, 1] * normal[1] + view[i, 2] * normal[2]
        for k in range(3):
            virtual[i, k] = view[i, k] - 2.0 * along * normal[k]
        virtual[i, 3] = view[i, 3] + 2.0 * along * offset
    return virtual


@kernel
def project(view, x, y, z):
    """(column, row) of a point."""
    c = view[0, 0] * x + view[0, 1] * y + view[0, 2] * z + view[0, 3]
    r = view[1, 0] * x + view[1, 1] * y + view[1, 2] * z + view[1, 3]
    w = view[2, 0] * x + view[2, 1] * y + view[2, 2] * z + view[2, 3]
    return c / w, r / w


@kernel
def outline(view, place, semi_axes):
    """`Ellipse` that an ellipsoid with semi-axes along x, y and z shows; a flat one (a semi-axis of 0) is a spot.

    The dual conic is p p^T - sum_k a_k^2 m_k m_k^T with p = view (place, 1) and m_k column k of the view.
    """
    p0 = view[0, 0] * place[0] + view[0, 1] * place[1] + view[0, 2] * place[2] + view[0, 3]
    p1 = view[1, 0] * place[0] + view[1, 1] * place[1] + view[1, 2] * place[2] + view[1, 3]
    p2 = view[2, 0] * place[0] + view[2, 1] * place[1] + view[2, 2] * place[2] + view[2, 3]
    # relative to the image of the centre, so that the difference of large squares keeps its digits
    u, v = p0 / p2, p1 / p2
    cc = cr = rr = cw = rw = ww = 0.0
    for k in range(3):
        a2 = semi_axes[k] * semi_axes[k]
        m2 = view[2, k]
        m0 = view[0, k] - u * m2
        m1 = view[1, k] - v * m2
        cc += a2 * m0 * m0
        cr += a2 * m0 * m1
        rr += a2 * m1 * m1
        cw += a2 * m0 * m2
        rw += a2 * m1 * m2
        ww += a2 * m2 * m2
    scale = 1.0 / (p2 * p2 - ww)
    shift_c, shift_r = -cw * scale, -rw * scale
    return Ellipse(
        u + shift_c, v + shift_r, cc * scale + shift_c * shift_c, cr * scale + shift_c * shift_r,
        rr * scale + shift_r * shift_r,
    )  # fmt: skip


@kernel
def half_plane_coverage(distance, normal_c, normal_r):
    """Part of a unit square on the inner side of a line at signed `distance` from its centre (positive: inside)."""
    a, b = abs(normal_c), abs(normal_r)
    if a < b:
        a, b = b, a
    s = abs(distance)
    if s >= 0.5 * (a + b):
        covered = 1.0
    elif s <= 0.5 * (a - b):
        covered = 0.5 + s / a
    else:
        corner = 0.5 * (a + b) - s
        covered = 1.0 - corner * corner / (2.0 * a * b)
    return covered if distance >= 0.0 else 1.0 - covered


@kernel
def _inverse_shape(shape):
    """S^-1 of an ellipse, and the squares of q = sqrt(w^T S^-1 w) inside and outside which no pixel is cut."""
    det = shape.cc * shape.rr - shape.cr * shape.cr
    mean = 0.5 * (shape.cc + shape.rr)
    minor = math.sqrt(det / (mean + math.sqrt(max(0.0, mean * mean - det))))
    reach = _CORNER / minor
    return shape.rr / det, -shape.cr / det, shape.cc / det, max(0.0, 1.0 - reach) ** 2, (1.0 + reach) ** 2


@kernel
def _coverage(shape, inverse, column, row):
    """Part of the pixel (column, row) that an ellipse covers."""
    cc, cr, rr, inner, outer = inverse
    dc, dr = column - shape.column, row - shape.row
    gc, gr = cc * dc + cr * dr, cr * dc + rr * dr
    q2 = dc * gc + dr * gr
    if q2 >= outer:
        return 0.0
    if q2 < inner:
        return 1.0
    slope = math.sqrt(gc * gc + gr * gr)
    if slope == 0.0:
        return 1.0
    q = math.sqrt(q2)
    return half_plane_coverage(q * (1.0 - q) / slope, gc / slope, gr / slope)


@kernel
def _uncovered(cover, column, row):
    """Part of a pixel that lies before the edge of something black: a c + b r + d <= 0 with a^2 + b^2 = 1."""
    return half_plane_coverage(-(cover[0] * column + cover[1] * row + cover[2]), cover[0], cover[1])


@kernel
def frame_key(key, exposure):
    """Key of the noise of one exposure: `key` of the episode, number of the exposure >= 0."""
    return bits(bits(key, _STREAM), exposure)


@kernel
def _grey(frame, level, column, row, camera):
    """Grey level of a pixel, 0 to 255: noise, then 8 bits."""
    if camera.noise > 0.0:
        level += camera.noise * normal_pair(frame, (row + _SIDE) * 2 * _SIDE + column + _SIDE)[0]
    return min(255.0, max(0.0, math.floor(level + 0.5)))


@kernel
def sensor(camera):
    """`Window` of the whole image; the optical axis is at its centre."""
    return Window(-(camera.columns // 2), -(camera.rows // 2), camera.columns, camera.rows)


@kernel
def window_around(shape, region):
    """Part of the window `region` in which a tracker looks for `shape`: what it covers, and `MARGIN` pixels more.

    The tracker knows where to look: acquisition of the ball is not modelled.
    """
    half_c, half_r = math.sqrt(shape.cc) + MARGIN, math.sqrt(shape.rr) + MARGIN
    last_c, last_r = region.column + region.columns - 1, region.row + region.rows - 1
    if not (  # a place that is not finite is nowhere
        region.column <= shape.column + half_c
        and shape.column - half_c <= last_c
        and region.row <= shape.row + half_r
        and shape.row - half_r <= last_r
    ):
        return Window(region.column, region.row, 0, 0)
    c0, c1 = max(region.column, math.floor(shape.column - half_c)), min(last_c, math.ceil(shape.column + half_c))
    r0, r1 = max(region.row, math.floor(shape.row - half_r)), min(last_r, math.ceil(shape.row + half_r))
    return Window(int(c0), int(r0), int(c1 - c0) + 1, int(r1 - r0) + 1)


@kernel
def find(frame, shape, window, cover, camera):
    """`Blob` in `window` of the image of one white ellipse.

    Args:
        frame: `frame_key` of the exposure.
        shape: `Ellipse`.
        window: `Window`.
        cover: None, or (a, b, d) with a^2 + b^2 = 1: what lies at a column + b row + d > 0 is hidden.
        camera: record of `Camera`.
    """
    inverse = _inverse_shape(shape)
    certain = _LARGEST_DEVIATE * camera.noise + 0.5  # beyond this no noise crosses the threshold: none is drawn
    first_c, first_r = window.column, window.row
    last_c, last_r = first_c + window.columns - 1, first_r + window.rows - 1
    count, sum_c, sum_r = 0, 0, 0
    whole = True
    for row in range(first_r, last_r + 1):
        for column in range(first_c, last_c + 1):
            part = _coverage(shape, inverse, column, row)
            if cover is not None:
                part *= _uncovered(cover, column, row)
            level = camera.black + (camera.white - camera.black) * part
            over = level - camera.threshold
            if abs(over) <= certain:
                over = _grey(frame, level, column, row, camera) - camera.threshold
            if over >= 0.0:
                count += 1
                sum_c += column
                sum_r += row
                if column == first_c or column == last_c or row == first_r or row == last_r:
                    whole = False
    area = math.pi * math.sqrt(shape.cc * shape.rr - shape.cr * shape.cr)
    whole = whole and 0.5 * area < count < 2.0 * area
    return Blob(whole, count, sum_c / count, sum_r / count) if count else Blob(False, 0, math.nan, math.nan)


@kernel
def picture(key, exposure, shapes, window, camera, image):
    """Write the grey levels of `window` with all ellipses in `shapes`, rows of (n, 5), to `image` (rows, columns)."""
    frame = frame_key(key, exposure)
    level = np.full((window.rows, window.columns), float(camera.black))
    for k in range(shapes.shape[0]):
        shape = Ellipse(shapes[k, 0], shapes[k, 1], shapes[k, 2], shapes[k, 3], shapes[k, 4])
        inverse = _inverse_shape(shape)
        for i in range(window.rows):
            for j in range(window.columns):
                part = _coverage(shape, inverse, window.column + j, window.row + i)
                level[i, j] = max(level[i, j], camera.black + (camera.white - camera.black) * part)
    for i in range(window.rows):
        for j in range(window.columns):
            image[i, j] = _grey(frame, level[i, j], window.column + j, window.row + i, camera)
