"""The vision apparatus: a camera, a 45-degree mirror beside the bar, three markers on it; and its error in theory.

    rig = Rig(Camera(noise=4.0))
    direct, mirrored = rig.calibrated(key=1)
    images = rig.ball_images(places, 0, key=3), rig.ball_images(places, 1, key=4)
    fixes = locate((direct.view, mirrored.view), *images)

Source: Bell (bouncing-ball report), section II, figures 2.1 and 2.2. The report gives no distances: those here are
chosen to suit its bar. Frame: `models/camera.py`; the two views are numbered 0, direct, and 1, reflected.
"""

from __future__ import annotations

import dataclasses
import math
from functools import cache, cached_property

import numpy as np

from vr_envs.experiments.calibration import Calibration, calibrate
from vr_envs.models.camera import Camera, Window, project, projection, reflected, sensor
from vr_envs.models.record import pack
from vr_envs.models.tracker import (
    back_projection,
    ball_images,
    bar_pose,
    in_plane,
    intersect,
    intersections,
    spot_images,
)

MARKER_RADIUS = 0.0015  # m
MARKERS = np.array([[-0.02, -0.0055], [0.0, -0.0055], [0.02, -0.0055]])  # m, x and z from the bar's reference point
FRONT = -0.005  # m, y of the bar's front, which bears the markers
LATTICE = 100  # wave numbers that `centroid_error` sums


@dataclasses.dataclass(frozen=True)
class Rig:
    """Camera and mirror. The mirror stands at x = `mirror`, y = 0, and shows the ball from the left."""

    camera: Camera = Camera()
    mirror: float = -0.07  # m

    @cached_property
    def record(self) -> np.void:
        """The camera as kernels take it."""
        return pack(self.camera)

    @cached_property
    def views(self) -> tuple[np.ndarray, np.ndarray]:
        """True views (3, 4): direct, and through the mirror (the virtual camera)."""
        direct = projection(self.record)
        half = math.sqrt(0.5)
        return direct, reflected(direct, (self.mirror, 0.0, 0.0), (half, -half, 0.0))

    @cached_property
    def regions(self) -> tuple[Window, Window]:
        """Regions of interest: the direct one is the camera's image, the reflected one 40 mm wide about the ball's."""
        direct = sensor(self.record)
        column, _ = project(self.views[1], 0.0, 0.0, 0.0)
        width = 2 * round(0.02 / self.camera.resolution)
        return direct, Window(round(column) - width // 2, direct.row, width, direct.rows)

    def ball_images(self, places: np.ndarray, view: int, key: int) -> np.ndarray:
        """(n, 2) column and row of the ball at places (n, 3), one exposure each; NaN where it is not seen whole."""
        out = np.empty((len(places), 2))
        ball_images(key, np.ascontiguousarray(places), self.views[view], self.regions[view], None, self.record, out)
        return out

    def marker_images(self, poses: np.ndarray, key: int) -> np.ndarray:
        """(n, 3, 2) images of the markers for bar poses (n, 3): x, z, tilt."""
        places = marker_places(poses)
        out = np.empty((*places.shape[:2], 2))
        spot_images(key, places, MARKER_RADIUS, self.views[0], self.regions[0], self.record, out)
        return out

    def calibrated(self, key: int) -> tuple[Calibration, Calibration]:
        """Both cameras as an experimenter would find them: the ball held at the places of `target(key)`."""
        places = target(key)
        estimated = []
        for view in (0, 1):
            images = self.ball_images(places, view, key + view)
            seen = np.isfinite(images).all(axis=1)
            estimated.append(calibrate(places[seen], images[seen]))
        return estimated[0], estimated[1]


def target(key: int) -> np.ndarray:
    """(80, 3) m, known places of the ball for a calibration: a grid, each place up to 2 mm off it.

    On an exact grid the pixels' errors repeat from place to place instead of averaging out.
    """
    axes = np.linspace(-0.02, 0.02, 5), np.linspace(-0.01, 0.01, 4), np.linspace(0.0, 0.02, 4)
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    return grid + np.random.default_rng(key).uniform(-2e-3, 2e-3, grid.shape)


def locate(views: tuple[np.ndarray, np.ndarray], direct: np.ndarray, mirrored: np.ndarray) -> np.ndarray:
    """(n, 4) x, y, z and gap between the lines of sight, m, from images (n, 2) in the two (estimated) views."""
    out = np.empty((len(direct), 4))
    intersections(back_projection(views[0]), direct, back_projection(views[1]), mirrored, out)
    return out


def marker_places(poses: np.ndarray) -> np.ndarray:
    """(n, 3, 3) places of the markers for bar poses (n, 3): x, z, tilt; right-handed about +y."""
    x, z, tilt = (np.asarray(poses, float)[:, k, None] for k in range(3))
    along, up = MARKERS[:, 0], MARKERS[:, 1]
    places = np.empty((len(poses), len(MARKERS), 3))
    places[..., 0] = x + along * np.cos(tilt) + up * np.sin(tilt)
    places[..., 1] = FRONT
    places[..., 2] = z - along * np.sin(tilt) + up * np.cos(tilt)
    return places


def bar_poses(view: np.ndarray, images: np.ndarray) -> np.ndarray:
    """(n, 4) x, z, tilt and rms residual (m, rad) of the bar from images (n, 3, 2) of its markers in a view."""
    back = back_projection(view)
    out = np.empty((len(images), 4))
    for k, frame in enumerate(images):
        out[k] = bar_pose(MARKERS, np.array([in_plane(back, column, row, FRONT) for column, row in frame]))
    return out


@cache
def _lattice() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Whole wave vectors up to `LATTICE`, 0 left out: |k|, the larger component, how many share them by symmetry."""
    k = np.arange(LATTICE + 1.0)
    kx, ky = (a.ravel() for a in np.meshgrid(k, k))
    size = np.hypot(kx, ky)
    kept = (size > 0.0) & (size <= LATTICE)
    times = np.where((kx == 0.0) | (ky == 0.0), 2.0, 4.0)
    return size[kept], np.maximum(kx, ky)[kept], times[kept]


def centroid_error(radius: float, noise: float) -> float:
    """Standard deviation of the area centroid of a thresholded disc, per coordinate, in pixels.

    Args:
        radius: of the disc, in pixels, at least 2.
        noise: standard deviation of a pixel over the difference of white and black, at most about 0.1.

    A pixel is white when its centre lies in the disc. By Poisson summation the centroid of those centres has, over all
    places of the disc on the grid, the variance sum over k of k_x^2 J_2(2 pi r |k|)^2 / (pi^2 |k|^4), k on the lattice
    of whole numbers without 0; with the mean of J_2^2 over r this is sum |k|^-3 / (4 pi^4 r) = 0.0232 / r. So the
    error falls as r^(-1/2), and around that mean it varies with r by some tens of per cent.
    Noise blurs the edge by noise / slope of the coverage, which is 1 / max(|cos|, |sin|) for an edge at an angle. The
    blur damps each term by exp(-4 pi^2 noise^2 max(|k_x|, |k_y|)^2) and adds, from single pixels,
    2 sqrt(2) noise / (pi^(5/2) r).
    """
    size, largest, times = _lattice()
    z = 2.0 * np.pi * radius * size
    turn = z - 1.25 * np.pi
    j2 = (1.0 - 105.0 / (128.0 * z * z)) * np.cos(turn) - 15.0 / (8.0 * z) * np.sin(turn)  # DLMF 10.17.3
    damping = np.exp(-((2.0 * np.pi * noise * largest) ** 2))
    terms = np.sum(times * size**-3 * 2.0 * j2 * j2 * damping)
    terms += 2.0 * np.pi / LATTICE * math.exp(-((2.0 * np.pi * noise * LATTICE) ** 2))  # what lies beyond
    variance = terms / (4.0 * np.pi**2) + 2.0 * math.sqrt(2.0) * noise / math.sqrt(math.pi)
    return math.sqrt(variance / (np.pi**2 * radius))


def marker_error(rig: Rig) -> np.ndarray:
    """(3,) standard deviations of x, z (m) and tilt (rad) of the bar: the centroid's, through the fit of `bar_pose`."""
    camera = rig.camera
    scale = (camera.distance + FRONT) / camera.focal_length
    spot = scale * centroid_error(MARKER_RADIUS / scale, camera.noise / (camera.white - camera.black))
    middle = MARKERS.mean(axis=0)
    tilt = spot / math.sqrt(np.sum((MARKERS - middle) ** 2))
    share = spot / math.sqrt(len(MARKERS))
    return np.array([math.hypot(share, middle[1] * tilt), math.hypot(share, middle[0] * tilt), tilt])


def predicted_error(rig: Rig, place: np.ndarray) -> np.ndarray:
    """(3,) standard deviations of x, y, z (m) of the ball: the centroid's, through the derivative of `intersect`."""
    backs = [back_projection(v) for v in rig.views]
    images = np.concatenate([project(v, *place) for v in rig.views])
    camera = rig.camera
    noise = camera.noise / (camera.white - camera.black)
    deviations = []
    for view in rig.views:
        depth = view[2] @ [*place, 1.0]
        deviations += [centroid_error(camera.focal_length * camera.ball_radius / depth, noise)] * 2
    h = 1e-3
    derivative = np.empty((3, 4))
    for k in range(4):
        ends = []
        for sign in (h, -h):
            moved = images.copy()
            moved[k] += sign
            ends.append(np.array(intersect(backs[0], *moved[:2], backs[1], *moved[2:])[:3]))
        derivative[:, k] = (ends[0] - ends[1]) / (2.0 * h)
    return np.sqrt(np.sum((derivative * deviations) ** 2, axis=1))
