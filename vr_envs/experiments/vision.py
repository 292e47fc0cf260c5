"""The vision system at work: its picture, its calibration, and a bouncing ball tracked in space at 667 Hz."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from vr_envs.experiments.experiment import Finding, Outcome, Progress
from vr_envs.experiments.look import BALL, BAR, FAINT, FORMULA, FOUND, label
from vr_envs.experiments.simulation import ball, bar_motion, simulate
from vr_envs.experiments.vision_rig import (
    MARKER_RADIUS,
    Rig,
    bar_poses,
    centroid_error,
    locate,
    marker_places,
    predicted_error,
    target,
)
from vr_envs.models.ball_on_bar import Params
from vr_envs.models.camera import Window, outline, picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

REGION_RATE = 2000.0  # Hz, exposures of all regions together (Bell: divided over three, 667 Hz each)
RUNS = 50  # calibrations
CUT = 33  # pixels, side of the pictures of the white pixels


def run(progress: Progress) -> Outcome:
    """Calibrate, track ball and bar through one second of bouncing, compare with the truth and with theory."""
    rig = Rig()
    calibrations = [rig.calibrated(2 * i) for i in progress(range(RUNS), desc="vision: calibrations")]
    views = calibrations[0][0].view, calibrations[0][1].view
    track = _track(rig, views)
    findings = [*_calibration_findings(rig, calibrations), *_track_findings(rig, track)]
    truth, seen = track["truth"], track["together"]
    columns = {"time (s)": track["time"]}
    for k, name in enumerate("xyz"):
        columns |= {
            f"{name} true (mm)": 1e3 * truth[:, k],
            f"{name} seen (mm)": 1e3 * seen[:, k],
            f"{name} seen, regions in turn (mm)": 1e3 * track["in_turn"][:, k],
        }
    columns["gap (mm)"] = 1e3 * seen[:, 3]
    for k, (name, unit, scale) in enumerate((("x", "mm", 1e3), ("tilt", "mrad", 1e3), ("z", "mm", 1e3))):
        order = (0, 2, 1)[k]
        columns[f"bar {name} true ({unit})"] = scale * track["bar"][:, order]
        columns[f"bar {name} seen ({unit})"] = scale * track["bar_seen"][:, order]
    return Outcome(tuple(findings), {"track": columns}, lambda figure: _draw(figure, rig, track))


def _track(rig: Rig, views: tuple[np.ndarray, np.ndarray]) -> dict[str, Any]:
    """Ball and bar over 15 base cycles: true places, and what is seen with all regions exposed together or in turn."""
    params = Params(restitution=0.856)
    motion = bar_motion(params, x=4.0, tilt=50.0, tilt_phase=math.pi / 2.0, z=14.0)
    samples = simulate(params, motion, ball(motion, x=0.005, z=0.004), 15, sample_rate=REGION_RATE).samples
    place = np.column_stack([samples["x"], np.zeros(len(samples)), samples["z"]])
    pose = np.column_stack([samples["bar_x"], samples["bar_z"], samples["bar_tilt"]])
    n = len(samples) // 3
    direct = rig.ball_images(place[: 3 * n : 3], 0, key=1001)
    mirrored = [rig.ball_images(place[shift : 3 * n : 3], 1, key=1002) for shift in (0, 1)]
    return {
        "time": np.arange(n) * 3.0 / REGION_RATE,
        "truth": place[: 3 * n : 3],
        "later": place[1 : 3 * n : 3],
        "together": locate(views, direct, mirrored[0]),
        "in_turn": locate(views, direct, mirrored[1]),
        "bar": pose[: 3 * n : 3],
        "bar_seen": bar_poses(views[0], rig.marker_images(pose[: 3 * n : 3], key=1003)),
        "images": (direct, mirrored[0]),
    }


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _compared(what: str, expected: float, found: float, within: float, unit: str, why: str) -> Finding:
    """A finding that agrees when found and expected differ by at most the part `within` of what is expected."""
    agrees = abs(found - expected) <= within * expected
    return Finding(what, f"{expected:.4g} {unit} ± {100 * within:.0f} % ({why})", f"{found:.4g} {unit}", agrees)


def _calibration_findings(rig: Rig, calibrations: list[Any]) -> list[Finding]:
    """Residuals of the fits, and the error of the calibrated cameras, against the theory of least squares."""
    camera, places = rig.camera, target(0)
    n = len(places)
    noise = camera.noise / (camera.white - camera.black)
    findings = []
    for k, name in enumerate(("direct", "reflected")):
        depths = rig.views[k][2, :3] @ places.T + rig.views[k][2, 3]
        size = _rms(np.array([centroid_error(camera.focal_length * camera.ball_radius / d, noise) for d in depths]))
        residual = _rms(np.array([c[k].rms for c in calibrations]))
        expected = size * math.sqrt(1.0 - 11.0 / (2 * n))
        findings.append(
            _compared(
                f"calibration, {name} view: rms residual", expected, residual, 0.05, "pixel", "centroid error, 11 free"
            )
        )
    return findings


def _track_findings(rig: Rig, track: dict[str, Any]) -> list[Finding]:
    """Errors along the track against the centroid's error carried through the geometry."""
    truth, seen = track["truth"], track["together"]
    expected = np.sqrt(np.mean([predicted_error(rig, p) ** 2 for p in truth[::10]], axis=0))
    findings = [
        _compared(
            f"{name} of the bouncing ball: rms error",
            1e6 * e,
            1e6 * _rms(found),
            0.2,
            "µm",
            "triangulation; a track meets the lattice unevenly",
        )
        for name, e, found in zip("xyz", expected, (seen[:, :3] - truth).T, strict=True)
    ]
    lag = 0.5 * (track["later"] - truth)[:, 2]
    turn = math.hypot(expected[2], _rms(lag))
    findings.append(
        _compared(
            "z with the regions exposed in turn, 0.5 ms apart: rms error",
            1e6 * turn,
            1e6 * _rms(track["in_turn"][:, 2] - truth[:, 2]),
            0.1,
            "µm",
            "half the way in that time",
        )  # fmt: skip
    )
    return findings


def _draw(figure: Figure, rig: Rig, track: dict[str, Any]) -> None:
    """The camera's image, the white pixels of both blobs, and the track in space."""
    figure.set_size_inches(11.0, 9.0)
    grid = figure.add_gridspec(4, 4, height_ratios=(1.5, 1, 1, 1))
    at = len(track["time"]) // 10
    image, window = _image(rig, track, at)
    left, top = window.column - 0.5, window.row - 0.5
    axes, masks = figure.add_subplot(grid[0, :3]), figure.add_subplot(grid[0, 3])
    axes.imshow(
        image, cmap="gray", vmin=0, vmax=255, interpolation="nearest",
        extent=(left, left + window.columns, top + window.rows, top),
    )  # fmt: skip
    parts = []
    for k, (region, name) in enumerate(zip(rig.regions, ("direct view", "in the mirror"), strict=True)):
        colour = (BALL, FOUND)[k]
        x, y = region.column - 0.5, region.row - 0.5
        right, bottom = x + region.columns, y + region.rows
        axes.plot([x, right, right, x, x], [y, y, bottom, bottom, y], color=BAR, linewidth=1.0)
        axes.text(x + 4, y + 16, name, color=BAR, fontsize=9)
        column, row = track["images"][k][at]
        axes.plot(column, row, "+", color=colour)
        c0, r0 = round(column) - CUT // 2, round(row) - CUT // 2
        parts.append(image[r0 - window.row : r0 - window.row + CUT, c0 - window.column : c0 - window.column + CUT])
        masks.plot(column - c0 + CUT * k, row - r0, "+", color=colour, markersize=12)
    masks.imshow(np.hstack(parts) >= rig.camera.threshold, cmap="gray", interpolation="nearest")
    label(axes, "image: the ball in two lines of sight, and the bar's markers", "column (pixel)", "row (pixel)")
    label(masks, "white pixels and centroids", "pixel", "pixel")
    time = track["time"]
    for k, name in enumerate("xyz"):
        lines, errors = figure.add_subplot(grid[1 + k, :2]), figure.add_subplot(grid[1 + k, 2:])
        lines.plot(time, 1e3 * track["truth"][:, k], color=FORMULA, linewidth=0.8, label="ball, true")
        lines.plot(time, 1e3 * track["together"][:, k], ".", markersize=3, color=BALL, label="seen")
        if name == "z":
            lines.plot(time, 1e3 * track["bar"][:, 1], color=FAINT, linewidth=0.8, label="bar, true")
            lines.plot(time, 1e3 * track["bar_seen"][:, 1], ".", markersize=2, color=BAR, label="seen")
        for key, colour, text in (("in_turn", BAR, "regions in turn"), ("together", BALL, "regions together")):
            wrong = 1e3 * (track[key][:, k] - track["truth"][:, k])
            errors.plot(time, wrong, ".", markersize=3, color=colour, label=text)
        last = name == "z"
        label(lines, name, "time (s)" if last else "", f"{name} (mm)", legend=True)
        label(errors, f"error of {name}", "time (s)" if last else "", "error (mm)", legend=True)


def _image(rig: Rig, track: dict[str, Any], at: int) -> tuple[np.ndarray, Window]:
    """The whole image at one exposure."""
    radius = rig.camera.ball_radius
    shapes = [outline(view, track["truth"][at], (radius,) * 3) for view in rig.views]
    spots = marker_places(track["bar"][at : at + 1])[0]
    shapes += [outline(rig.views[0], place, (MARKER_RADIUS, 0.0, MARKER_RADIUS)) for place in spots]
    direct, mirrored = rig.regions
    first = mirrored.column - 8
    window = Window(first, direct.row, direct.column + direct.columns + 8 - first, direct.rows)
    image = np.empty((window.rows, window.columns), np.uint8)
    picture(0, at, np.array(shapes), window, rig.record, image)
    return image, window
