"""Figures 2.3 to 2.5: a ball bouncing in three dimensions on a concave lens, seen by the camera with the mirror.

The report gives the lenses' focal lengths alone; here they are plano-concave, of BK7 glass (n = 1.517), so their radius
of curvature is f (n - 1): 77.6 mm for 15 cm and 103.4 mm for 20 cm. Nor does it give the ball's start.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from vr_envs.experiments.experiment import Finding, Outcome, Progress
from vr_envs.experiments.lens_orbit import apex_swings, horizontal_map, travel_frequency
from vr_envs.experiments.lens_track import (
    FOCAL_LENGTHS,
    FREQUENCIES,
    LONG,
    Track,
    adjusted,
    elliptic,
    fitted_apexes,
    invariant,
    line_frequency,
    recursion,
    scene,
    tracked,
    true_apexes,
)
from vr_envs.experiments.look import BALL, FAINT, FOUND, label
from vr_envs.experiments.vision_rig import Rig, predicted_error
from vr_envs.models.ball_on_lens import Params
from vr_envs.models.ball_options import Spin

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SECONDS = 4.0
LENSES = [(focal_length, frequency) for focal_length in FOCAL_LENGTHS for frequency in FREQUENCIES]
SHOWN = (0.15, 30.0)  # the lens (m) and frequency (Hz) of the pictures
SETTLED = 30  # impacts after which the vertical motion has forgotten its start: below 1e-3 of it
MANY = 3000  # impacts over which the slow change of a frictionless ball's travel is measured


def _close(found: float, expected: float, relative: float) -> bool:
    return abs(found - expected) <= relative * abs(expected)


def _name(focal_length: float, frequency: float) -> str:
    return f"lens of {100.0 * focal_length:.0f} cm, {frequency:.0f} Hz"


def _tracks(progress: Progress, name: str) -> dict[tuple[float, float], Track]:
    """A frictionless ball on each lens, as the camera saw it."""
    rig = Rig()
    tracks = {}
    for number, (focal_length, frequency) in enumerate(progress(LENSES, desc=f"{name}: lenses")):
        params = scene(focal_length, frequency)
        run = elliptic(params, LONG, round(SECONDS * frequency))
        tracks[focal_length, frequency] = tracked(run, rig, key=10 * number)
    return tracks


def travel(progress: Progress) -> Outcome:
    """X, Y and Z in time, the path in the plane, and how fast the ball travels round the lens."""
    tracks = _tracks(progress, "lens-travel")
    findings = []
    for lens, track in tracks.items():
        expected, found = travel_frequency(track.run.params), line_frequency(track.times, track.seen[:, :2])
        findings.append(
            Finding(
                f"{_name(*lens)}: travel round the lens",
                f"{expected:.3f} Hz, linear map, within 1 %, {1e3 * LONG:.0f} mm being finite; below {lens[1]:.0f} Hz",
                f"{found:.3f} Hz",
                _close(found, expected, 0.01) and found < lens[1],
            )
        )
    shown = tracks[SHOWN]
    params = shown.run.params
    gripping = elliptic(params, LONG, round(SECONDS * params.frequency), Spin())
    findings += [*_kept(shown), *_slow(params), *_gripped(params)]
    columns = {"time (s)": shown.times}
    for k, axis in enumerate("xyz"):
        columns |= {f"{axis} true (mm)": 1e3 * shown.true[:, k], f"{axis} seen (mm)": 1e3 * shown.seen[:, k]}
    impacts = {
        "time (s)": gripping.times,
        **{f"{axis} (mm)": 1e3 * gripping.impacts[axis] for axis in "xyz"},
    }
    return Outcome(
        tuple(findings),
        {"track": columns, "gripping": impacts},
        lambda figure: _draw_travel(figure, shown, np.column_stack([impacts["x (mm)"], impacts["y (mm)"]])),
    )


def _kept(track: Track) -> list[Finding]:
    """Angular momentum about the axis, and what the camera adds."""
    i = track.run.impacts
    momentum = i["x"] * i["v"] - i["y"] * i["u"]
    change = float(np.ptp(momentum) / np.abs(momentum).mean())
    error = (track.seen - track.true).std(axis=0)
    expected = predicted_error(Rig(), np.array([0.0, 0.0, track.true[:, 2].mean()]))
    return [
        Finding(
            "frictionless: change of angular momentum about the axis",
            "0, within 1e-12 of it",
            f"{change:.1e}",
            change < 1e-12,
        ),
        Finding(
            "error of the camera in x, y, z (standard deviation)",
            ", ".join(f"{1e6 * e:.1f}" for e in expected) + " µm in theory, within 30 %",
            ", ".join(f"{1e6 * e:.1f}" for e in error) + " µm",
            all(_close(f, e, 0.3) for f, e in zip(error, expected, strict=True)),
        ),
    ]


def _slow(params: Params) -> list[Finding]:
    """Neutral to first order; what is left is of second order in the size of the path."""
    growth = []
    for size in (0.25 * LONG, 0.5 * LONG):
        run = elliptic(params, size, MANY)
        kept, tenth = invariant(run)[SETTLED:], MANY // 10
        growth.append(math.log(kept[-tenth:].mean() / kept[:tenth].mean()) / (len(kept) - tenth))
    modulus = np.abs(np.linalg.eigvals(horizontal_map(params))).max()
    return [
        Finding(
            f"frictionless: growth of the path's square per impact at {1e3 * size:.0f} mm",
            f"eigenvalues of size {modulus:.6f}: 0 to first order, below 1e-5",
            f"{rate:.1e}",
            abs(rate) < 1e-5,
        )
        for size, rate in zip((0.25 * LONG, 0.5 * LONG), growth, strict=True)
    ] + [
        Finding(
            "the same at twice the size",
            "4 times, being of second order, within 10 %",
            f"{growth[1] / growth[0]:.2f} times",
            _close(growth[1] / growth[0], 4.0, 0.1),
        )
    ]


def _gripped(params: Params) -> list[Finding]:
    """A solid sphere that grips and spins comes to the lens's centre."""
    run = elliptic(params, LONG, 150, Spin())
    size, angle = recursion(run)
    expected = np.abs(np.linalg.eigvals(horizontal_map(params, Spin()))).max()
    frequency, found = travel_frequency(params, Spin()), angle * params.frequency / (2.0 * math.pi)
    return [
        Finding(
            "gripping solid sphere: size of its path, from impact to impact",
            f"times {expected:.4f} within 10 % of the loss",
            f"times {size:.4f}",
            _close(1.0 - size, 1.0 - expected, 0.1),
        ),
        Finding(
            "gripping solid sphere: travel round the lens",
            f"{frequency:.3f} Hz, within 1 %",
            f"{found:.3f} Hz",
            _close(found, frequency, 0.01),
        ),
    ]


def _draw_travel(figure: Figure, track: Track, gripping: np.ndarray) -> None:
    figure.set_size_inches(11.0, 8.0)
    grid = figure.add_gridspec(1, 2, width_ratios=(1.5, 1.0))
    traces, paths = figure.add_subfigure(grid[0, 0]), figure.add_subfigure(grid[0, 1])
    seen = 1e3 * track.seen
    rows = traces.subplots(4, 1, sharex=True)
    for axes, values, name in zip(rows, (*seen.T, np.hypot(seen[:, 0], seen[:, 1])), "xyzr", strict=True):
        axes.plot(track.times, values, ".", color=BALL, markersize=1.5)
        label(axes, "", "", f"{name} (mm)")
    rows[0].set_title("place of the ball (Fig 2.3), and its distance r from the axis", fontsize=10, loc="left")
    rows[3].set_xlabel("time (s)")
    shown = (
        (seen[:, :2], "path in the plane, frictionless (Fig 2.4)"),
        (gripping, "a gripping solid sphere, its impacts"),
    )
    for axes, (path, title) in zip(paths.subplots(2, 1, sharex=True, sharey=True), shown, strict=True):
        axes.plot(path[:, 0], path[:, 1], color=FAINT, linewidth=0.5)
        points = axes.scatter(path[:, 0], path[:, 1], c=np.linspace(0.0, SECONDS, len(path)), s=3.0, cmap="viridis")
        axes.set_aspect("equal")
        paths.colorbar(points, ax=axes, label="time (s)", shrink=0.7)
        label(axes, title, "x (mm)", "y (mm)")


def height(progress: Progress) -> Outcome:
    """Height of the ball as it is and less that of the lens under it: how far the apexes swing."""
    tracks = _tracks(progress, "lens-height")
    findings, columns = [], {}
    for lens, track in tracks.items():
        params = track.run.params
        spread = _spread(track)
        raw, less = _expected(track)
        seen, factor = fitted_apexes(track, adjusted(params, track.seen))
        noise = factor * predicted_error(Rig(), np.array([0.0, 0.0, track.true[:, 2].mean()]))[2]
        found = seen[SETTLED:].std()
        findings += [
            Finding(
                f"{_name(*lens)}: apex heights, as they are (standard deviation)",
                f"{1e6 * raw:.1f} µm to second order, within 5 %",
                f"{1e6 * spread[0]:.1f} µm",
                _close(spread[0], raw, 0.05),
            ),
            Finding(
                f"{_name(*lens)}: adjusted with the true place",
                f"{1e6 * less:.1f} µm to second order, within 10 %",
                f"{1e6 * spread[1]:.1f} µm",
                _close(spread[1], less, 0.1),
            ),
            Finding(
                f"{_name(*lens)}: adjusted with the place that the camera saw",
                f"{1e6 * math.hypot(less, noise):.1f} µm, with {1e6 * noise:.1f} µm of noise, within 20 %",
                f"{1e6 * found:.1f} µm, {found / spread[0]:.2f} of what it was",
                _close(found, math.hypot(less, noise), 0.2),
            ),
        ]
        columns[f"apex, {_name(*lens)} (mm)"] = 1e3 * seen[: round(SECONDS * min(FREQUENCIES)) - 2]
    track = tracks[SHOWN]
    params = track.run.params
    trace = {
        "time (s)": track.times,
        "z seen (mm)": 1e3 * track.seen[:, 2],
        "z seen, adjusted (mm)": 1e3 * adjusted(params, track.seen),
        "z true (mm)": 1e3 * track.true[:, 2],
        "z true, adjusted (mm)": 1e3 * adjusted(params, track.true),
    }
    return Outcome(
        tuple(findings), {"track": trace, "apexes": columns}, lambda figure: _draw_height(figure, track, trace)
    )


def _spread(track: Track) -> tuple[float, float]:
    """Standard deviation (m) of the true apexes' heights, and of those heights adjusted."""
    apexes = true_apexes(track.run)[SETTLED:]
    return float(apexes[:, 2].std()), float(adjusted(track.run.params, apexes).std())


def _expected(track: Track) -> tuple[float, float]:
    """The same from the second-order theory, for the ellipse on which the ball travels."""
    run = track.run
    number = np.arange(len(run.cycle))[SETTLED:]
    turn = recursion(run)[1] * number
    waves = np.column_stack([np.cos(turn), -np.sin(turn)])
    x, y = (complex(*np.linalg.lstsq(waves, run.impacts[axis][SETTLED:], rcond=None)[0]) for axis in "xy")
    swings = apex_swings(run.params, x, y)
    return abs(swings[0]) / math.sqrt(2.0), abs(swings[1]) / math.sqrt(2.0)


def _draw_height(figure: Figure, track: Track, trace: dict[str, np.ndarray]) -> None:
    figure.set_size_inches(9.0, 7.0)
    rows = figure.subplots(3, 1, sharex=True)
    titles = ("height of the ball, as seen (Fig 2.5)", "adjusted using x and y (Fig 2.5)")
    for axes, name, title in zip(rows, ("z seen (mm)", "z seen, adjusted (mm)"), titles, strict=False):
        axes.plot(trace["time (s)"], trace[name], color=BALL, linewidth=0.6)
        label(axes, title, "", "z (mm)")
    for heights, colour, name in (
        (track.seen[:, 2], FAINT, "as seen"),
        (adjusted(track.run.params, track.seen), FOUND, "adjusted"),
    ):
        apexes, _ = fitted_apexes(track, heights)
        rows[2].plot(track.run.times[:-1], 1e3 * apexes, "o-", color=colour, markersize=2.5, linewidth=0.6, label=name)
    label(rows[2], "highest points of the parabolas fitted to each flight", "time (s)", "z (mm)", legend=True)
