"""Figures 3.8 to 3.10: heights of bounce against the bar's peak acceleration, for m = 1 and 2.

Once as a quasi-static sweep, which waits at every acceleration and starts the next from where the ball is, and once as
Bell did it: one run in which the acceleration grows slowly. His rates read ".18t" and ".13t", with zeros lost.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from vr_envs.experiments.attractors import ends
from vr_envs.experiments.bounce import (
    lower_bound,
    orbit_apexes,
    orbit_phases,
    period_one_launch,
    period_one_phase,
    upper_bound,
    vertical,
)
from vr_envs.experiments.experiment import Finding, Outcome, Progress
from vr_envs.experiments.look import FAINT, label, paint
from vr_envs.experiments.simulation import bar_motion, scan, simulate
from vr_envs.experiments.trace import free_flights
from vr_envs.models.ball_on_bar import Params
from vr_envs.models.ball_options import Ramp
from vr_envs.render.style import BLUE, GROUND

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

RESTITUTIONS = (0.856, 0.75)
MODES = (1, 2)
FREQUENCY = 20.0  # Hz
HIGHEST = 15.0  # m/s^2
STEP = 0.02  # m/s^2, of the quasi-static sweep
WAIT, KEEP = 400, 48  # base cycles at each acceleration before KEEP impacts are kept
RATES = (0.018, 0.18)  # m/s^3
SPLIT = 0.01  # share of the height by which two successive bounces differ once a ramp has passed the flip
EQUAL = 1e-3  # relative difference of equal bounces and intervals
BEYOND = 5  # steps of the sweep
Sweep = tuple[np.ndarray, np.ndarray, np.ndarray]
Diagrams = dict[tuple[float, int], tuple[np.ndarray, np.ndarray]]
# peak accelerations (m/s^2) of each m at which the settled heights are compared, restitution 0.75
SETTLED = {1: (10.0, 11.0, 11.5, 12.0), 2: (10.0, 12.0, 13.3, 13.5)}
FIGURES = dict(zip(RESTITUTIONS, ("Fig 3.9", "Fig 3.10"), strict=True))
TOP = 25.0  # mm, of Bell's axis


def middle(m: int, params: Params) -> float:
    """A peak acceleration on the sweep's grid where period one of mode m is stable."""
    return STEP * round(0.5 * (lower_bound(m, params) + upper_bound(m, params)) / STEP)


def sweep(m: int, params: Params, upwards: bool) -> Sweep:
    """Quasi-static sweep from the middle of the band: (accelerations (n,), impacts kept (n, KEEP), counts (n,))."""
    begin = middle(m, params)
    count = round((HIGHEST - begin) / STEP) if upwards else round(begin / STEP)
    accelerations = begin + STEP * np.arange(count + 1) * (1.0 if upwards else -1.0)
    phase = period_one_phase(begin, m, params)
    motions = np.array([bar_motion(params, z=a, z_phase=phase) for a in accelerations])
    _, starts = period_one_launch(params, begin, m, nudge=1e-5)
    kept, counts, _ = scan(params, motions, starts, WAIT, KEEP, follow=True)
    return accelerations, kept, counts


def heights(impacts: np.ndarray, counts: np.ndarray, params: Params) -> np.ndarray:
    """Apex (m) of each flight (n, KEEP - 1) above the bar's mean position; NaN where the ball rested."""
    first = impacts[:, :-1]
    top = first["z"] + np.maximum(0.0, first["w_out"]) ** 2 / (2.0 * params.gravity)
    filled = np.arange(1, impacts.shape[1]) < counts[:, None]
    return np.where(free_flights(impacts, params) & filled, top, np.nan)


def ramp(m: int, params: Params, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """One run from just above the lower bound with an acceleration that grows by `rate` (m/s^3).

    Returns:
        Peak acceleration (m/s^2) at the impact that begins each flight, and the flight's apex (m).
    """
    begin = 1.05 * lower_bound(m, params)
    motions, starts = period_one_launch(params, begin, m)
    phase = period_one_phase(begin, m, params)
    growth = Ramp(z_cos=rate * math.sin(phase), z_sin=rate * math.cos(phase))
    cycles = math.ceil((HIGHEST - begin) / rate * params.frequency)
    trace = simulate(params, motions[0], starts[0], cycles, {"ramp": growth})
    apexes = trace.apexes
    return begin + rate * trace.seconds(apexes), apexes["z"]


def split_at(accelerations: np.ndarray, tops: np.ndarray) -> float:
    """Acceleration from which successive apexes differ by more than `SPLIT`, at four bounces in a row."""
    apart = np.abs(np.diff(tops)) > SPLIT * tops[1:]
    row = apart[:-3] & apart[1:-2] & apart[2:-1] & apart[3:]
    return float(accelerations[np.argmax(row)]) if row.any() else math.nan


def bifurcation(progress: Progress) -> Outcome:
    """Both diagrams for both restitutions and modes."""
    findings: list[Finding] = []
    still: Diagrams = {}
    moving: Diagrams = {}
    cases = [(alpha, m) for alpha in RESTITUTIONS for m in MODES]
    for alpha, m in progress(cases, desc="sweeps"):
        params = vertical(FREQUENCY, alpha)
        up, down = sweep(m, params, True), sweep(m, params, False)
        tops = [heights(kept, counts, params) for _, kept, counts in (up, down)]
        findings += _bounds_found(m, params, up, down)
        if alpha == 0.75:
            findings += _settled(m, params, up, down)
        still[alpha, m] = (
            np.concatenate([np.repeat(a, KEEP - 1) for a in (up[0], down[0])]),
            np.concatenate([t.ravel() for t in tops]),
        )
        runs = [ramp(m, params, rate) for rate in RATES]
        findings.append(_late(alpha, m, params, [split_at(*run) for run in runs]))
        moving[alpha, m] = runs[0]
    tables = {}
    for name, diagrams in (("sweep", still), ("ramp", moving)):
        rows = [(np.full(len(a), alpha), np.full(len(a), m), a, 1e3 * t) for (alpha, m), (a, t) in diagrams.items()]
        columns = [np.concatenate(column) for column in zip(*rows, strict=True)]
        seen = np.isfinite(columns[3])
        names = ("restitution", "m", "peak_acceleration_m_s2", "apex_mm")
        tables[name] = {key: column[seen] for key, column in zip(names, columns, strict=True)}
    return Outcome(tuple(findings), tables, lambda figure: _draw(figure, still, moving))


def edge_of(m: int, params: Params, swept: Sweep) -> tuple[float, float, int]:
    """The last acceleration of a sweep with period one of mode m, the next one, and the period `BEYOND` further on.

    Near a flip an orbit settles slowly, so bounces count as equal up to `EQUAL`; a period of 0 is rest or irregular.
    """
    accelerations, kept, counts = swept
    tops = heights(kept, counts, params)
    level = np.ptp(tops, axis=1) < EQUAL * tops.max(axis=1)  # False where a ball rested
    found = ends(kept, counts, params)
    holds = level & (np.abs(found.interval - m) < EQUAL)
    first = int(np.argmin(holds))
    return float(accelerations[first - 1]), float(accelerations[first]), int(found.period[first + BEYOND])


def _bounds_found(m: int, params: Params, up: Sweep, down: Sweep) -> list[Finding]:
    """Where the sweeps leave period one of mode m."""
    low, high = lower_bound(m, params), upper_bound(m, params)
    flip, end = edge_of(m, params, up), edge_of(m, params, down)
    name = f"m = {m}, restitution {params.restitution:g}, quasi-static"
    return [
        Finding(
            f"period one flips: {name}",
            f"{high:.3f} m/s^2, within {STEP:g}; into period 2",
            f"between {flip[0]:.2f} and {flip[1]:.2f}; period {flip[2]}",
            bool(flip[0] - STEP <= high <= flip[1] + STEP and flip[2] == 2),
        ),
        Finding(
            f"period one ends below: {name}",
            f"{low:.3f} m/s^2, within {STEP:g}",
            f"between {end[1]:.2f} and {end[0]:.2f}",
            bool(end[1] - STEP <= low <= end[0] + STEP),
        ),
    ]


def _settled(m: int, params: Params, up: Sweep, down: Sweep) -> list[Finding]:
    """Heights of the settled bounces where the sweep passes, against the equations of period one or two."""
    findings = []
    for acceleration in SETTLED[m]:
        accelerations, kept, counts = up if acceleration >= up[0][0] else down
        row = int(np.argmin(np.abs(accelerations - acceleration)))
        period = 1 if acceleration < upper_bound(m, params) else 2
        last = kept[row, -period:]
        phases = orbit_phases(last["phase"], [m] * period, acceleration, params)
        expected = np.sort(1e3 * orbit_apexes(phases, [m] * period, acceleration, params))
        tops = 1e3 * heights(kept, counts, params)[row, -2 * (KEEP // 4) :]
        found = np.split(np.sort(tops), period)
        findings.append(
            Finding(
                f"apexes at {acceleration:g} m/s^2, m = {m}, restitution 0.75",
                f"{', '.join(f'{e:.4f}' for e in expected)} mm (orbit's equations), within 1e-3 mm",
                f"{', '.join(f'{f.mean():.4f}' for f in found)} mm",
                all(np.abs(f - e).max() < 1e-3 for f, e in zip(found, expected, strict=True)),
            )
        )
    return findings


def _late(alpha: float, m: int, params: Params, found: list[float]) -> Finding:
    """How late the ramps show the flip."""
    bound = upper_bound(m, params)
    bell = "; Bell's ball split around 11.0 or 11.2 (a digit is lost)" if (alpha, m) == (0.75, 1) else ""
    return Finding(
        f"bounces of m = {m} split under a ramp of {RATES[0]:g} and {RATES[1]:g} m/s^3; restitution {alpha:g}",
        f"after {bound:.3f} m/s^2, the later the faster{bell}",
        f"{found[0]:.3f} and {found[1]:.3f} m/s^2",
        bound < found[0] < found[1],
    )


def _draw(figure: Figure, still: Diagrams, moving: Diagrams) -> None:
    figure.set_size_inches(11.0, 8.0)
    axes = figure.subplots(len(RESTITUTIONS), 2, sharex=True, sharey=True)
    for row, alpha in zip(axes, RESTITUTIONS, strict=True):
        for part, diagrams, title in zip(
            row, (still, moving), ("quasi-static sweep", f"ramp of {RATES[0]:g} m/s³"), strict=True
        ):
            _diagram(part, alpha, diagrams)
            label(
                part,
                f"restitution {alpha:g} ({FIGURES[alpha]}): {title}",
                "peak acceleration (m/s²)",
                "height of bounce (mm)",
                True,
            )


def _diagram(axes: Axes, alpha: float, diagrams: Diagrams) -> None:
    params = vertical(FREQUENCY, alpha)
    for m, colour in zip(MODES, (BLUE, GROUND), strict=True):
        accelerations, tops = diagrams[alpha, m]
        axes.plot(accelerations, 1e3 * tops, ".", color=paint(colour), markersize=1.2, markeredgewidth=0.0)
        axes.plot([], [], "s", color=paint(colour), markersize=4, label=f"started at m = {m}")
        for bound, shown in (
            (lower_bound(m, params), None),
            (upper_bound(m, params), "bounds of stable period one" if m == MODES[-1] else None),
        ):
            axes.axvline(bound, color=FAINT, lw=0.6, ls="--", label=shown)
    axes.set_xlim(0.0, HIGHEST)
    axes.set_ylim(0.0, TOP)
