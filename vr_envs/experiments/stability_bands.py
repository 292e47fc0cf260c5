"""Figure 3.11: where period one of mode m is stable, found by simulation, against the bounds of Luck and Mehta.

A ball is started a little off the closed-form orbit. The amplitude is in the band if the ball, after many impacts of
the exact map, repeats every impact at m periods; both bounds are bracketed and the bracket is divided again and again.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from vr_envs.experiments.attractors import ends
from vr_envs.experiments.bounce import (
    lower_bound,
    period_one_launch,
    period_one_phase,
    scaled,
    upper_bound,
    vertical,
)
from vr_envs.experiments.experiment import Finding, Outcome, Progress
from vr_envs.experiments.look import FOUND, label, paint
from vr_envs.experiments.simulation import scan
from vr_envs.models.ball_on_bar import Params
from vr_envs.render.style import BLUE, GROUND, ORANGE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MODES = range(1, 8)
RESTITUTIONS = (0.68, 0.75, 0.856)
FREQUENCY = 20.0  # Hz; a scale
NUDGE = 1e-4  # of the flight's launch speed: how far off the orbit a ball starts
SETTLE = 2000  # base cycles per unit of m
PARTS, ROUNDS = 9, 4  # amplitudes between the ends of a bracket, and how often it is divided


def holds(params: Params, accelerations: np.ndarray, m: int) -> np.ndarray:
    """(n,) bool: whether a ball that starts near period one of mode m settles to it, at each peak acceleration."""
    nudge = NUDGE * 0.5 * params.gravity * m * 0.5 * params.period
    motions, states = period_one_launch(params, accelerations, m, nudge)
    kept, counts, _ = scan(params, motions, states, m * SETTLE, 26)
    found = ends(kept, counts, params)
    return (found.period == 1) & (np.abs(found.interval - m) < 1e-6)


def edge(params: Params, m: int, inside: float, outside: float) -> tuple[float, float]:
    """Bracket (inside, outside) of the peak acceleration at which period one of mode m is lost on the way between two.

    Raises:
        ArithmeticError: it is not stable at `inside`, or is stable at `outside`.
    """
    for _ in range(ROUNDS):
        tried = np.linspace(inside, outside, PARTS + 2)
        stable = holds(params, tried, m)
        if not stable[0] or stable[-1]:
            raise ArithmeticError(f"m = {m}: no edge between {inside} and {outside} m/s^2")
        last = int(np.argmin(stable)) - 1
        inside, outside = float(tried[last]), float(tried[last + 1])
    return inside, outside


def band(params: Params, m: int) -> tuple[float, float]:
    """Lower and upper peak acceleration (m/s^2) of period one of mode m, by simulation."""
    low, high = lower_bound(m, params), upper_bound(m, params)
    middle, reach = 0.5 * (low + high), high - low
    lower = edge(params, m, middle, max(middle - 1.5 * reach, 0.3 * low))
    upper = edge(params, m, middle, middle + 1.5 * reach)
    return 0.5 * sum(lower), 0.5 * sum(upper)


def stability_bands(progress: Progress) -> Outcome:
    """All bands, and the phase at which period one flips."""
    rows = []
    cases = [(alpha, m) for alpha in RESTITUTIONS for m in MODES]
    for alpha, m in progress(cases, desc="bands"):
        params = vertical(FREQUENCY, alpha)
        low, high = band(params, m)
        rows.append((alpha, m, low, lower_bound(m, params), high, upper_bound(m, params)))
    table = np.array(rows)
    lower, upper = (table[:, k] / table[:, k + 1] - 1.0 for k in (2, 4))
    first = table[:, 1] <= 4
    worst = [np.abs(errors[first]).max() for errors in (lower, upper)]
    rest = max(np.abs(lower[~first]).max(), np.abs(upper[~first]).max())
    findings = [
        Finding(
            f"{bound} bound, m = 1 to 4, restitution {', '.join(map(str, RESTITUTIONS))}",
            f"{formula}, within 0.5 %",
            f"largest difference {error:.3%}",
            bool(error < 0.005),
        )
        for bound, formula, error in zip(
            ("lower", "upper"),
            ("m (1-a)/(1+a)", "sqrt((m (1-a)/(1+a))^2 + (2 (1+a^2)/(pi (1+a)^2))^2)"),
            worst,
            strict=True,
        )
    ]
    findings.append(Finding("both bounds, m = 5 to 7", "the same, within 0.5 %", f"{rest:.3%}", bool(rest < 0.005)))
    widths = (table[:, 4] - table[:, 2]).reshape(len(RESTITUTIONS), -1)
    findings.append(
        Finding(
            "width of the bands",
            "falls with m (Bell: the upper bound approaches the lower)",
            ", ".join(f"{first:.2f} to {last:.2f} m/s^2" for first, last in widths[:, [0, -1]]),
            bool((np.diff(widths, axis=1) < 0.0).all()),
        )
    )
    findings += [_flip_phase(alpha, table[(table[:, 0] == alpha) & (table[:, 1] == 1)][0, 4]) for alpha in RESTITUTIONS]
    gravity = Params().gravity
    columns = {
        "restitution": table[:, 0],
        "m": table[:, 1].astype(int),
        "lower_found": scaled(table[:, 2], gravity),
        "lower_formula": scaled(table[:, 3], gravity),
        "upper_found": scaled(table[:, 4], gravity),
        "upper_formula": scaled(table[:, 5], gravity),
    }
    return Outcome(tuple(findings), {"bands": columns}, lambda figure: _draw(figure, columns))


def _flip_phase(alpha: float, flip: float) -> Finding:
    """Phase of the last stable orbit."""
    params = vertical(FREQUENCY, alpha)
    stable = flip * (1.0 - 2e-3)
    motions, states = period_one_launch(params, stable, 1, 1e-4)
    kept, _, _ = scan(params, motions, states, 20 * SETTLE, 1)
    found = float(kept["phase"][0, 0])
    expected = period_one_phase(upper_bound(1, params), 1, params)
    return Finding(
        f"phase at which period one flips, restitution {alpha:g}",
        f"{expected:.3f} rad, within 0.01; not pi/2 (Bell), which holds for restitution 1 alone",
        f"{found:.3f} rad at {stable:.3f} m/s^2",
        abs(found - expected) < 0.01 and abs(found - math.pi / 2.0) > 0.1,
    )


def _draw(figure: Figure, columns: dict[str, np.ndarray]) -> None:
    axes = figure.subplots()
    for k, (alpha, colour) in enumerate(zip(RESTITUTIONS, (GROUND, BLUE, ORANGE), strict=True)):
        rows = columns["restitution"] == alpha
        height = columns["m"][rows] + 0.22 * (k - 1)
        low, high = columns["lower_formula"][rows], columns["upper_formula"][rows]
        axes.barh(
            height, high - low, left=low, height=0.18, color=paint(colour), label=f"formula, restitution {alpha:g}"
        )
        for name in ("lower_found", "upper_found"):
            shown = "found by simulation" if k == 0 and name == "lower_found" else None
            axes.plot(columns[name][rows], height, "|", color=FOUND, markersize=11, mew=1.5, label=shown)
    label(axes, "Stable period one (Fig 3.11)", "Γ = Aω² / (π g)", "m", legend=True)
    axes.set_xlim(left=0.0)
    axes.set_yticks(list(MODES))
