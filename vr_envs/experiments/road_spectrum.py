"""Averaged periodograms of roads of three ISO 8608 classes, over the standard's line and over the exact density.

A road is drawn as the environment draws it, by its knots. Each of many keys gives one stretch, a Hann window goes over
it, and the squared transforms are averaged. The window carries what lies at long waves into shorter ones, where the
density is lower, by less than 0.1 % from 0.1 cycle/m on; there the ratio to `knot_density` is 1 but for chance. Each
bin's power is exponentially distributed; neighbours share (2/3)^2 of it and next neighbours (1/6)^2, so the mean of B
bins over M stretches varies by sqrt((1 + 2 (4/9 + 1/36)) / (M B)).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from vr_envs.experiments.experiment import Finding, Outcome, Progress
from vr_envs.experiments.look import BALL, BAR, FAINT, FORMULA, FOUND, label, shared_legend
from vr_envs.models.jit import kernel
from vr_envs.models.record import dtype_of, pack
from vr_envs.models.road import RoadAlone, draw_road, roughness_deviation
from vr_envs.models.road_density import iso_density, knot_density, met_density
from vr_envs.models.road_options import Road

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CLASSES = "ACE"
SPACING, KNOTS, STRETCHES = 0.05, 8192, 1000  # m; a stretch is 410 m long
LOWEST, HIGHEST = 0.1, 1.0  # cycle/m, where the exact density is within 1.3 % of the line
CHANCE = 4.0  # standard deviations that a finding may be off
SHARED = 1.0 + 2.0 * (4.0 / 9.0 + 1.0 / 36.0)  # by the bins under a Hann window
BANDS = np.geomspace(0.0125, 10.0, 59)  # cycle/m, edges: six in an octave


@kernel
def draw_roads(state, first_key, heights, road):
    """Heights (stretches, knots) of the roads with the keys from `first_key` on."""
    for i in range(heights.shape[0]):
        state.key = np.uint64(first_key + i)
        draw_road(state, heights[i], road, None, None, None, None)


def stretches(road: Road, count: int, knots: int, first_key: int = 0) -> np.ndarray:
    """Heights (count, knots) in m of the first knots of `count` roads, with keys from `first_key` on."""
    heights = np.empty((count, knots))
    draw_roads(np.zeros(1, dtype_of(RoadAlone))[0], first_key, heights, pack(road))
    return heights


def periodogram(heights: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Wave numbers (cycle/m) above zero and below half a cycle per `spacing`, and the averaged one-sided density."""
    knots = heights.shape[1]
    window = np.sin(np.pi * (np.arange(knots) + 0.5) / knots) ** 2
    power = np.zeros(knots // 2 + 1)
    for row in heights:
        power += np.abs(np.fft.rfft(row * window)) ** 2
    density = power * 2.0 * spacing / (len(heights) * np.sum(window**2))
    return np.fft.rfftfreq(knots, spacing)[1:-1], density[1:-1]


def chance(stretches: int, bins: int) -> float:
    """Standard deviation of the mean ratio of `bins` bins over that many stretches."""
    return math.sqrt(SHARED / (stretches * bins))


def _findings(letter: str, road: Road, heights: np.ndarray, number: np.ndarray, found: np.ndarray) -> list[Finding]:
    """What a class shows: ratios to the exact density and to the line, and the root mean square."""
    exact = found / knot_density(number, road)
    far, near = number >= LOWEST, (number >= LOWEST) & (number <= HIGHEST)
    allowed = 0.001 + CHANCE * chance(STRETCHES, int(far.sum()))
    ratio = float(exact[far].mean())
    line = float((found / iso_density(number, road.density))[near].mean())
    bent = float((knot_density(number, road) / iso_density(number, road.density))[near].mean())
    line_allowed = 0.001 + CHANCE * chance(STRETCHES, int(near.sum()))
    deviation = roughness_deviation(road.density, road.cutoff)
    rms = math.sqrt(float(np.mean(heights**2)))
    # of the mean square over a long stretch; the covariance falls as exp(-2 pi n_c x)
    spread = math.sqrt(0.5 / (STRETCHES * KNOTS * SPACING * 2.0 * math.pi * road.cutoff))
    return [
        Finding(
            f"class {letter}: periodogram over exact density, {LOWEST:g} to {0.5 / SPACING:g} cycle/m",
            f"1.0000 +- {allowed:.4f}",
            f"{ratio:.4f}",
            abs(ratio - 1.0) <= allowed,
        ),
        Finding(
            f"class {letter}: periodogram over Gd(n0) (n/n0)^-2, {LOWEST:g} to {HIGHEST:g} cycle/m",
            f"{bent:.4f} +- {line_allowed:.4f}",
            f"{line:.4f}",
            abs(line - bent) <= line_allowed,
        ),
        Finding(
            f"class {letter}: root mean square",
            f"{1e3 * deviation:.2f} mm +- {100.0 * CHANCE * spread:.1f} %",
            f"{1e3 * rms:.2f} mm",
            abs(rms / deviation - 1.0) <= CHANCE * spread,
        ),
    ]


def road_spectrum(progress: Progress) -> Outcome:
    """Three classes: their periodograms, in bands, over the line and over the exact density."""
    findings: list[Finding] = []
    tables: dict[str, dict[str, np.ndarray]] = {}
    levels: list[float] = []  # fitted Gd(n0), m^3
    bins = int(np.sum(np.fft.rfftfreq(KNOTS, SPACING)[1:-1] >= LOWEST))
    for i, letter in enumerate(progress(CLASSES, desc="classes")):
        road = Road(iso_class=letter, spread=0.0, knot_spacing=SPACING)
        heights = stretches(road, STRETCHES, KNOTS, i * STRETCHES)
        number, found = periodogram(heights, SPACING)
        findings += _findings(letter, road, heights, number, found)
        levels.append(road.density * float((found / knot_density(number, road))[number >= LOWEST].mean()))
        place = np.digitize(number, BANDS)
        bands = [place == i for i in range(1, len(BANDS)) if (place == i).any()]
        centre = np.array([number[band].mean() for band in bands])
        tables[letter] = {
            "wave_number_cycle_m": centre,
            "density_m3": np.array([found[band].mean() for band in bands]),
            "over_line": np.array([(found / iso_density(number, road.density))[band].mean() for band in bands]),
            "over_exact": np.array([(found / knot_density(number, road))[band].mean() for band in bands]),
        }
    allowed = 16.0 * CHANCE * math.sqrt(2.0) * chance(STRETCHES, bins)
    for name, factor in (("A to C", levels[1] / levels[0]), ("C to E", levels[2] / levels[1])):
        findings.append(
            Finding(
                f"density over two classes, {name}",
                f"16.00 +- {allowed:.2f}",
                f"{factor:.2f}",
                abs(factor - 16.0) <= allowed,
            )
        )
    return Outcome(tuple(findings), tables, lambda figure: _draw(figure, tables))


def _draw(figure: Figure, tables: dict[str, dict[str, np.ndarray]]) -> None:
    """The densities beside the line, and what they are over it."""
    left, right = figure.subplots(1, 2)
    for letter, colour in zip(tables, (BALL, BAR, FOUND), strict=True):
        table, road = tables[letter], Road(iso_class=letter, knot_spacing=SPACING)
        number = table["wave_number_cycle_m"]
        left.loglog(number, iso_density(number, road.density), color=FORMULA, lw=1.0, label="Gd(n0) (n/n0)^-2")
        left.loglog(number, table["density_m3"], ".", color=colour, ms=4.0, label=f"class {letter}")
        right.semilogx(number, table["over_line"], ".", color=colour, ms=4.0)
    road = Road(knot_spacing=SPACING)
    number = np.geomspace(BANDS[0], 0.5 / SPACING, 200)
    line = iso_density(number, road.density)
    right.semilogx(number, knot_density(number, road) / line, color=FAINT, lw=1.0, label="exact, of the knots")
    right.semilogx(number, met_density(number, road) / line, "--", color=FAINT, lw=1.0, label="exact, straight between")
    right.axhline(1.0, color=FORMULA, lw=1.0)
    right.set_ylim(0.0, 2.6)
    label(left, "one-sided density of the knots' heights", "wave number (cycle/m)", "density (m^3)")
    label(right, "the same over the standard's line", "wave number (cycle/m)", "ratio")
    handles = dict(zip(*reversed(left.get_legend_handles_labels()), strict=True))
    handles |= dict(zip(*reversed(right.get_legend_handles_labels()), strict=True))
    shared_legend(figure, list(handles.values()), list(handles))
