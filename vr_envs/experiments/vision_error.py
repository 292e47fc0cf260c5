"""Error of the vision system against the true place, over image noise and over resolution."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

import numpy as np

from vr_envs.experiments.calibration import projected
from vr_envs.experiments.experiment import Finding, Outcome, Progress
from vr_envs.experiments.look import BALL, BAR, FAINT, FOUND, label, plain_log
from vr_envs.experiments.vision_rig import Rig, bar_poses, centroid_error, locate, marker_error, predicted_error, target
from vr_envs.models.camera import Camera, outline

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NOISES = (0.0, 1.0, 2.0, 4.0, 8.0, 12.0, 16.0, 20.0, 25.0, 30.0, 40.0)  # grey levels of 200 from black to white
RESOLUTIONS = (1e-3, 7e-4, 5e-4, 3.5e-4, 2.5e-4, 1.75e-4, 1.25e-4)  # m/pixel
PLACES = 2000  # per ball
BALLS = 8  # of radii over one pixel: the lattice error of a disc depends on it
CALIBRATIONS = 40  # per noise
WITHIN = 0.04  # part by which found and expected error may differ
RESOLUTION_TICKS = (0.125, 0.25, 0.5, 1.0)  # mm/pixel
TRUSTED = 20.0  # grey levels of noise up to which the theory of single edge pixels holds


def run(progress: Progress) -> Outcome:
    """Bias and rms error per axis with true cameras, and what calibration adds."""
    over_noise = [_errors(Camera(noise=noise), i) for i, noise in enumerate(progress(NOISES, desc="vision: noise"))]
    over_size = [
        _errors(_sharper(resolution), 100 + i)
        for i, resolution in enumerate(progress(RESOLUTIONS, desc="vision: size"))
    ]
    calibration = [
        _calibration_error(noise, i) for i, noise in enumerate(progress(NOISES[:-3], desc="vision: calibration"))
    ]
    tables = {
        "noise": {"noise (grey level)": np.array(NOISES), **_columns(over_noise)},
        "resolution": {"resolution (mm/pixel)": 1e3 * np.array(RESOLUTIONS), **_columns(over_size)},
        "calibration": {
            "noise (grey level)": np.array(NOISES[:-3]),
            "direct view, found (pixel)": np.array([c[0][0] for c in calibration]),
            "direct view, expected (pixel)": np.array([c[0][1] for c in calibration]),
            "reflected view, found (pixel)": np.array([c[1][0] for c in calibration]),
            "reflected view, expected (pixel)": np.array([c[1][1] for c in calibration]),
        },
    }
    return Outcome(tuple(_findings(over_noise, over_size, calibration)), tables, lambda figure: _draw(figure, tables))


def _sharper(resolution: float) -> Camera:
    """The default camera with pixels of another size and the same field of view."""
    usual = Camera()
    scale = usual.resolution / resolution
    return dataclasses.replace(
        usual, resolution=resolution, columns=round(scale * usual.columns), rows=round(scale * usual.rows)
    )


def _errors(camera: Camera, key: int) -> dict[str, np.ndarray | float]:
    """Bias, rms error and expected error per axis (m) over random places, and the part of them that is not seen."""
    places = np.random.default_rng(key).uniform((-0.02, -0.01, 0.0), (0.02, 0.01, 0.02), (PLACES, 3))
    wrong, expected = [], []
    for i in range(BALLS):
        radius = camera.ball_radius + ((i + 0.5) / BALLS - 0.5) * camera.resolution
        rig = Rig(dataclasses.replace(camera, ball_radius=radius))
        images = [rig.ball_images(places, k, 1000 * key + 2 * i + k) for k in (0, 1)]
        wrong.append(locate(rig.views, images[0], images[1])[:, :3] - places)
        expected.append(np.mean([predicted_error(rig, place) ** 2 for place in places[:8]], axis=0))
    errors = np.concatenate(wrong)
    seen = errors[np.isfinite(errors).all(axis=1)]
    return {
        "bias": seen.mean(axis=0),
        "rms": np.sqrt(np.mean(seen**2, axis=0)),
        "expected": np.sqrt(np.mean(expected, axis=0)),
        "lost": 1.0 - len(seen) / len(errors),
        "uncertain": seen.std(axis=0) / math.sqrt(len(seen)),
    }


def _calibration_error(noise: float, key: int) -> list[tuple[float, float]]:
    """Per view: rms error of calibrated cameras at their targets (pixels), and s sqrt(11 / 2n).

    The error is the distance to the middle of the ball's true image, which is what a calibration by the ball aims at.
    """
    rig = Rig(Camera(noise=noise))
    radius, contrast = rig.camera.ball_radius, rig.camera.white - rig.camera.black
    keys = [10_000 + 1000 * key + 2 * i for i in range(CALIBRATIONS)]
    runs, held = [rig.calibrated(k) for k in keys], [target(k) for k in keys]
    rows = []
    for k, view in enumerate(rig.views):
        middles = np.array([[outline(view, place, (radius,) * 3)[:2] for place in places] for places in held])
        found = np.array([projected(r[k].view, places) for r, places in zip(runs, held, strict=True)])
        depths = held[0] @ view[2, :3] + view[2, 3]
        sizes = [centroid_error(rig.camera.focal_length * radius / depth, noise / contrast) for depth in depths]
        expected = math.sqrt(np.mean(np.square(sizes)) * 11.0 / (2 * len(sizes)))
        rows.append((float(np.sqrt(np.mean((found - middles) ** 2))), expected))
    return rows


def _bar_errors() -> tuple[np.ndarray, np.ndarray]:
    """Rms errors of the bar's x, z (m) and tilt (rad) over random poses, and what is expected."""
    poses = np.random.default_rng(7).uniform((-0.005, -0.001, -0.05), (0.005, 0.001, 0.05), (PLACES, 3))
    rig = Rig()
    wrong = bar_poses(rig.views[0], rig.marker_images(poses, key=1))[:, :3] - poses
    return np.sqrt(np.mean(wrong**2, axis=0)), marker_error(rig)


def _columns(results: list) -> dict[str, np.ndarray]:
    columns = {}
    for k, name in enumerate("xyz"):
        columns[f"{name} rms error (µm)"] = 1e6 * np.array([r["rms"][k] for r in results])
        columns[f"{name} expected (µm)"] = 1e6 * np.array([r["expected"][k] for r in results])
        columns[f"{name} bias (µm)"] = 1e6 * np.array([r["bias"][k] for r in results])
    return columns | {"not seen (%)": 100.0 * np.array([r["lost"] for r in results])}


def _findings(over_noise: list, over_size: list, calibration: list) -> list[Finding]:
    findings = []
    trusted = [r for r, noise in zip(over_noise, NOISES, strict=True) if noise <= TRUSTED]
    for what, results in ((f"noise 0 to {TRUSTED:g} grey levels", trusted), ("1 to 0.125 mm/pixel", over_size)):
        for k, name in enumerate("xyz"):
            ratio = [r["rms"][k] / r["expected"][k] for r in results]
            findings.append(
                Finding(
                    f"rms error of {name} over theory, {what}",
                    f"1 ± {WITHIN:g} (lattice of pixels, noise of edge pixels, triangulation)",
                    f"{min(ratio):.3f} to {max(ratio):.3f}",
                    max(abs(r - 1.0) for r in ratio) <= WITHIN,
                )
            )
    slope = [np.polyfit(np.log(RESOLUTIONS), np.log([r["rms"][k] for r in over_size]), 1)[0] for k in range(3)]
    findings.append(
        Finding(
            "rms error grows with the size of a pixel as its power",
            "1.5 ± 0.05 (r^(-1/2) in pixels)",
            ", ".join(f"{s:.3f}" for s in slope),
            all(abs(s - 1.5) <= 0.05 for s in slope),
        )
    )
    usual = over_noise[NOISES.index(Camera().noise)]
    found = usual["rms"][1] / usual["rms"][0]
    rig = Rig()
    ratio = ((rig.camera.distance - rig.mirror) / rig.camera.distance) ** 1.5
    findings.append(
        Finding(
            "y (mirror only) over x (direct view only): rms errors",
            f"{ratio:.3f} ± 0.03 (the mirror's longer way to the power 3/2)",
            f"{found:.3f}",
            abs(found - ratio) <= 0.03,
        )
    )
    depth = rig.camera.distance - rig.mirror
    bias = rig.mirror / depth * rig.camera.ball_radius**2 / depth
    found, uncertain = usual["bias"][1], usual["uncertain"][1]
    findings.append(
        Finding(
            "bias of y: the image of a sphere off the axis is not centred on the image of its centre",
            f"{1e6 * bias:.2f} ± {3e6 * uncertain:.2f} µm (tan of the angle off the axis, radius^2 / distance)",
            f"{1e6 * found:.2f} µm",
            abs(found - bias) <= 3.0 * uncertain,
        )
    )
    found, expected = _bar_errors()
    # the markers keep their distance in columns, so their errors along x are not independent as the theory takes them
    for k, (name, unit, within) in enumerate((("x", "µm", 0.15), ("z", "µm", 0.05), ("tilt", "µrad", 0.05))):
        findings.append(
            Finding(
                f"{name} of the bar from its three markers: rms error",
                f"{1e6 * expected[k]:.2f} {unit} ± {100 * within:.0f} % (independent centroid errors, rigid fit)",
                f"{1e6 * found[k]:.2f} {unit}",
                abs(found[k] / expected[k] - 1.0) <= within,
            )
        )
    pooled = np.sqrt(np.mean([[(found / expected) ** 2 for found, expected in row] for row in calibration], axis=0))
    for name, ratio in zip(("direct", "reflected"), pooled, strict=True):
        findings.append(
            Finding(
                f"error of the calibrated camera over s sqrt(11/2n), {name} view, all noises",
                "1 ± 0.05 (11 free numbers, independent centroid errors)",
                f"{ratio:.3f}",
                abs(ratio - 1.0) <= 0.05,
            )
        )
    return findings


def _draw(figure: Figure, tables: dict[str, dict[str, np.ndarray]]) -> None:
    """Error over noise and over resolution per axis, calibration, bias."""
    figure.set_size_inches(11.0, 7.5)
    axes = figure.subplots(2, 2)
    noise, size = "noise (grey level)", "resolution (mm/pixel)"
    for place, table, key, what in (
        (axes[0, 0], "noise", noise, "error over image noise"),
        (axes[0, 1], "resolution", size, "error over size of a pixel"),
    ):
        for name, colour in zip("xyz", (BALL, FOUND, BAR), strict=True):
            rows = tables[table]
            place.plot(rows[key], rows[f"{name} expected (µm)"], color=colour, linewidth=1.0)
            place.plot(rows[key], rows[f"{name} rms error (µm)"], "o", color=colour, label=name)
            if table == "resolution":
                axes[1, 1].plot(rows[key], rows[f"{name} bias (µm)"], "o-", color=colour, label=name)
        label(place, f"{what}: found (points), theory (lines)", key, "rms error (µm)", legend=True)
    axes[0, 0].axvline(TRUSTED, color=FAINT, linewidth=0.8, linestyle="--")
    axes[0, 0].text(TRUSTED + 0.5, 1.0, "the theory holds to the left", fontsize=8, color=FAINT)
    axes[0, 0].set_ylim(bottom=0.0)
    plain_log(axes[0, 1], "x", RESOLUTION_TICKS)
    plain_log(axes[0, 1], "y", (5.0, 10.0, 20.0, 50.0, 100.0))
    plain_log(axes[1, 1], "x", RESOLUTION_TICKS)
    label(axes[1, 1], "bias over size of a pixel", size, "mean error (µm)", legend=True)
    rows = tables["calibration"]
    for view, colour in (("direct", BALL), ("reflected", FOUND)):
        axes[1, 0].plot(rows[noise], rows[f"{view} view, expected (pixel)"], color=colour, linewidth=1.0)
        axes[1, 0].plot(rows[noise], rows[f"{view} view, found (pixel)"], "o", color=colour, label=f"{view} view")
    axes[1, 0].set_ylim(0.0, 0.018)
    label(axes[1, 0], "calibration: found (points), theory (lines)", noise, "error of the camera (pixel)", legend=True)
