"""Restitution from the decay of a ball dropped on the bar at rest, as Bell measured it (report, section III.D).

Heights fall by alpha^2 from bounce to bounce, flight times by alpha, and all ends after t1 / (1 - alpha), t1 being the
first whole flight.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from vr_envs.experiments.camera_trace import Bounces, CameraTrace, as_seen, fitted
from vr_envs.experiments.experiment import Finding, Outcome, Progress
from vr_envs.experiments.look import BALL, FAINT, FORMULA, FOUND, label
from vr_envs.experiments.simulation import ball, bar_motion, simulate
from vr_envs.experiments.trace import Trace
from vr_envs.models.ball_on_bar import Params
from vr_envs.models.ball_options import Scatter

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RESTITUTION = 0.856  # Bell, from several drops
SCATTERS = (0.0, 0.02, 0.05)  # standard deviation of the restitution from impact to impact
HEIGHTS = np.linspace(0.01, 0.04, 20)  # m
RATE, REGIONS = 1000.0, 2  # Hz, regions of interest of the camera
BOUNCES = 8  # parabolas used of each drop: later ones have few samples


def drop(height: float, scatter: float, key: int) -> tuple[Params, Trace]:
    """A drop on the bar at rest, until it lies still, and the camera's samples of it."""
    params = Params(restitution=RESTITUTION)
    still = bar_motion(params)
    first = 2.0 * RESTITUTION * math.sqrt(2.0 * height / params.gravity)
    cycles = math.ceil((first / (1.0 - RESTITUTION) + 0.5 * first / RESTITUTION) * params.frequency) + 2
    options = {"scatter": Scatter(scatter, 0.0)} if scatter else None
    return params, simulate(params, still, ball(still, z=height, key=key), cycles, options, sample_rate=RATE)


def seen_bounces(trace: Trace) -> tuple[CameraTrace, Bounces]:
    """The camera's view of the first bounces of a drop, and their fits."""
    seen = as_seen(trace, REGIONS)
    end = trace.seconds(trace.impacts)[BOUNCES + 2]
    ball_rows, bar_rows = seen.ball_time < end, seen.bar_time < end
    early = CameraTrace(seen.ball_time[ball_rows], seen.ball[ball_rows], seen.bar_time[bar_rows], seen.bar[bar_rows])
    return early, fitted(early, trace.params.omega)


def estimates(bounces: Bounces) -> tuple[np.ndarray, np.ndarray]:
    """Restitution from each pair of heights and from each pair of flight times."""
    heights, flights = bounces.maxima[:BOUNCES], np.diff(bounces.impact_times)[: BOUNCES - 1]
    return np.sqrt(heights[1:] / heights[:-1]), flights[1:] / flights[:-1]


def restitution(progress: Progress) -> Outcome:
    """Drops without scatter, and with it."""
    rows: list[tuple[float, float, int, float, float]] = []
    findings: list[Finding] = []
    shown: dict[float, tuple[CameraTrace, Bounces]] = {}
    for scatter in progress(SCATTERS, desc="drops"):
        height_ratios, time_ratios = [], []
        for key, height in enumerate(HEIGHTS):
            params, trace = drop(float(height), scatter, key)
            seen, bounces = seen_bounces(trace)
            shown.setdefault(scatter, (seen, bounces))
            by_height, by_time = estimates(bounces)
            rows += [(scatter, 1e3 * height, i, a, b) for i, (a, b) in enumerate(zip(by_height, by_time, strict=False))]
            height_ratios.append(by_height)
            time_ratios.append(by_time)
            if scatter == 0.0 and key == 0:
                findings.append(_decay_time(params, trace, float(height)))
        findings += _found(scatter, np.concatenate(height_ratios), np.concatenate(time_ratios))
    names = ("scatter", "drop_mm", "bounce", "by_height", "by_time")
    columns = {name: np.array(values) for name, values in zip(names, zip(*rows, strict=True), strict=True)}
    return Outcome(tuple(findings), {"estimates": columns}, lambda figure: _draw(figure, shown, columns))


def _decay_time(params: Params, trace: Trace, height: float) -> Finding:
    """The impacts accumulate at a finite time."""
    fall = math.sqrt(2.0 * height / params.gravity)
    expected = fall * (1.0 + RESTITUTION) / (1.0 - RESTITUTION)
    # what is left after the last impact located, by the same law
    last = trace.impacts[-1]
    found = trace.seconds(trace.impacts)[-1] + 2.0 * last["normal_out"] / params.gravity / (1.0 - RESTITUTION)
    resting = bool(trace.final["resting"])
    return Finding(
        f"time from a drop of {1e3 * height:.0f} mm to rest",
        f"{expected:.4f} s = sqrt(2h/g) (1+a)/(1-a), at rest then, within 1e-12",
        f"{found:.4f} s, difference {abs(found - expected):.0e}, {'at rest' if resting else 'still bouncing'}",
        resting and abs(found - expected) < 1e-12,
    )


def _found(scatter: float, by_height: np.ndarray, by_time: np.ndarray) -> list[Finding]:
    findings = []
    for way, values in (("heights, sqrt(h2/h1)", by_height), ("flight times, t2/t1", by_time)):
        mean, std = float(values.mean()), float(values.std(ddof=1))
        error = std / math.sqrt(len(values))
        within = 1e-6 if scatter == 0.0 else 4.0 * error
        told = "1e-6" if scatter == 0.0 else f"4 standard errors; std of one value {scatter:g}, within 30 %"
        agrees = abs(mean - RESTITUTION) < within and abs(std - scatter) <= (1e-6 if scatter == 0.0 else 0.3 * scatter)
        findings.append(
            Finding(
                f"restitution from {way}; scatter {scatter:g}",
                f"{RESTITUTION:g}, within {told}",
                f"{mean:.5f}, std of one value {std:.2g}, {len(values)} values",
                bool(agrees),
            )
        )
    return findings


def _draw(figure: Figure, shown: dict[float, tuple[CameraTrace, Bounces]], columns: dict[str, np.ndarray]) -> None:
    figure.set_size_inches(9.0, 7.0)
    above, below = figure.subplots(2, 1)
    for (scatter, (seen, bounces)), colour in zip(shown.items(), (BALL, FAINT, FOUND), strict=True):
        text = f"scatter {scatter:g}" if scatter else "no scatter"
        above.plot(1e3 * seen.ball_time, 1e3 * seen.ball, ".-", color=colour, markersize=2, lw=0.6, label=text)
        top = bounces.centres - bounces.parabolas[:, 1] / (2.0 * bounces.parabolas[:, 0])
        above.plot(1e3 * top, 1e3 * bounces.maxima, "^", color=colour, markersize=4)
        rows = columns["scatter"] == scatter
        below.plot(
            columns["drop_mm"][rows] + 0.3 * columns["bounce"][rows] / BOUNCES,
            columns["by_height"][rows],
            ".",
            color=colour,
            markersize=4,
            label=text,
        )
    below.axhline(RESTITUTION, color=FORMULA, lw=0.8)
    label(
        above,
        "drops of 10 mm on the bar at rest; triangles: maxima of the fits",
        "time (ms)",
        "height (mm)",
        legend=True,
    )
    label(
        below,
        "restitution from the heights of successive bounces; line: 0.856",
        "drop (mm)",
        "restitution",
        legend=True,
    )
