"""Calibration of a camera from images of known points: direct linear transformation, then least squares.

    images = rig.ball_images(target, view=0)     # the ball held at known places, as an experimenter would
    calibration = calibrate(target, images)
    calibration.view, calibration.rms

Source of the method: Abdel-Aziz and Karara 1971; normalisation and refinement: Hartley and Zisserman, Multiple View
Geometry, 2nd ed., section 7.
"""

from __future__ import annotations

import dataclasses

import numpy as np

_STEPS = 20  # of Gauss and Newton; they converge in about five


@dataclasses.dataclass(frozen=True)
class Calibration:
    """An estimated camera: `view` (3, 4) of unit norm, positive before the camera, and `rms` residual per coordinate.

    The residual is in pixels. With independent errors of size s in n images it is s sqrt(1 - 11 / 2n) on average, and
    the fitted camera's own error at those points s sqrt(11 / 2n): a view has 11 free numbers.
    """

    view: np.ndarray
    rms: float


def projected(view: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(n, 2) images, column and row, of the points (n, 3)."""
    q = points @ view[:, :3].T + view[:, 3]
    return q[:, :2] / q[:, 2:]


def calibrate(points: np.ndarray, images: np.ndarray) -> Calibration:
    """The camera that shows `points` at `images`, with least squared distance in the image.

    Args:
        points: (n, 3) known places, m, n >= 6, not all in one plane.
        images: (n, 2) column and row of each.

    Raises:
        ValueError: too few points, shapes that do not match, numbers that are not finite, points in one plane.
    """
    points, images = np.asarray(points, float), np.asarray(images, float)
    n = len(points)
    if n < 6 or points.shape != (n, 3) or images.shape != (n, 2):
        raise ValueError(
            f"points have shape {points.shape} and images {images.shape}; give (n, 3) and (n, 2) with n >= 6"
        )
    if not (np.isfinite(points).all() and np.isfinite(images).all()):
        raise ValueError("a point or an image is not finite: leave out the points that were not seen")
    to_points, to_images = _normalising(points), _normalising(images)
    x = np.column_stack([points, np.ones(n)]) @ to_points.T
    u = images @ to_images[:2, :2].T + to_images[:2, 2]
    if np.linalg.svd(x, compute_uv=False)[-1] < 1e-9 * np.sqrt(n):
        raise ValueError("the points lie in one plane: they cannot tell distance from magnification; add others")
    view = _refined(_direct(x, u), x, u)
    view = np.linalg.inv(to_images) @ view @ to_points
    view /= np.linalg.norm(view) * np.sign(view[2] @ [*points[0], 1.0])
    return Calibration(view, float(np.sqrt(np.mean((projected(view, points) - images) ** 2))))


def _normalising(points: np.ndarray) -> np.ndarray:
    """Homogeneous matrix that brings points to mean 0 and unit size."""
    size = points.shape[1]
    mean = points.mean(axis=0)
    spread = np.sqrt(np.mean((points - mean) ** 2)) or 1.0
    matrix = np.diag([1.0 / spread] * size + [1.0])
    matrix[:size, size] = -mean / spread
    return matrix


def _direct(x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """(3, 4) that minimises the algebraic error |u (p_3 x) - p_1 x|^2 + |v (p_3 x) - p_2 x|^2 at unit norm."""
    zero = np.zeros_like(x)
    rows = np.vstack([np.hstack([x, zero, -u[:, :1] * x]), np.hstack([zero, x, -u[:, 1:] * x])])
    return np.linalg.svd(rows)[2][-1].reshape(3, 4)


def _refined(view: np.ndarray, x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Least squared distance in the image, by Gauss and Newton; the free scale is left alone by the shortest step."""
    for _ in range(_STEPS):
        q = x @ view.T
        image = q[:, :2] / q[:, 2:]
        row = x / q[:, 2:]
        zero = np.zeros_like(row)
        slope = np.vstack([np.hstack([row, zero, -image[:, :1] * row]), np.hstack([zero, row, -image[:, 1:] * row])])
        step = np.linalg.lstsq(slope, (u - image).T.ravel(), rcond=1e-12)[0].reshape(3, 4)
        view = view + step
        if np.linalg.norm(step) < 1e-13 * np.linalg.norm(view):
            break
    return view
