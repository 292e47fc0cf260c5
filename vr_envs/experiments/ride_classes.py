"""How a quarter car rides by road class and speed: long rides against the frequency domain.

A passive quarter car, 290/59 kg, 16812 and 190000 N/m, 1500 N s/m, rides 8000 s on each of the ISO 8608 classes A to E
at three speeds. The linear formula knows no lift-off: it holds while the tyre stays on the ground, and the finding says
from which class on it does not.
"""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from vr_envs.evaluation.rollout import Rollout, rollout
from vr_envs.evaluation.scenarios import scenario_set
from vr_envs.experiments.experiment import Finding, Outcome, Progress
from vr_envs.experiments.look import BALL, BAR, FORMULA, FOUND, label
from vr_envs.models.ride_spectrum import Vehicle, ride_rms
from vr_envs.models.road_density import iso_density
from vr_envs.models.road_options import Road

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CAR = Vehicle(290.0, 16812.0, 1500.0, 59.0, 190e3)
CLASSES, SPEEDS = "ABCDE", (10.0, 20.0, 30.0)  # m/s
RIDES, INTERVAL, SPACING = 8, 1.0, 0.05  # rides for each; s, the longest ride is 1000 of them; m between knots
ALLOWED = 0.02
SPEED_COLOURS = (BALL, BAR, FOUND)
GROUNDED = 1e-3  # part of the time off the ground up to which the linear formula is held to


class Still:
    """The policy that leaves the actuators where they are."""

    def reset(self, n: int) -> None:
        """Nothing to forget."""

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        """Zeros."""
        return np.zeros((len(observations), 2), np.float32)


def long_rides(iso_class: str, speed: float) -> Rollout:
    """`RIDES` rides of the passive quarter car; position 0 of the actuators is its damping and spring."""
    damping = CAR.damping / CAR.sprung_mass
    off = dict.fromkeys(("bumps", "stop", "payload", "lag", "noise", "preview"))
    road = {"iso_class": iso_class, "spread": 0.0, "knot_spacing": SPACING}
    scene = {
        "base": "quarter-car",
        **off,
        "dt": INTERVAL,
        "speed": speed,
        "damping_low": 0.5 * damping,
        "damping_high": 2.0 * damping,
        "road": road,
    }
    return rollout(Still(), scenario_set("vr_envs/TerrainRide-v0", scene, n=RIDES))


def ride_classes(progress: Progress) -> Outcome:
    """Weighted acceleration and tyre load by class and speed, from long rides and from the formula."""
    rows, findings = [], []
    for letter, speed in progress([(c, v) for c in CLASSES for v in SPEEDS], desc="classes and speeds"):
        ridden = long_rides(letter, speed)
        formula = ride_rms(CAR, speed, partial(iso_density, reference=Road(letter).density))
        found = ridden.metrics["acceleration_rms_m_s2"]
        value, error = float(found.mean()), float(found.std(ddof=1)) / math.sqrt(RIDES)
        airborne = float(ridden.metrics["airborne_fraction"].mean())
        load = float(ridden.metrics["tyre_load_rms"].mean())
        rows.append((letter, speed, formula.weighted, value, error, formula.tyre_load, load, airborne))
        if airborne < GROUNDED:
            findings.append(
                Finding(
                    f"weighted acceleration, class {letter}, {speed:g} m/s",
                    f"{formula.weighted:.3f} m/s^2 within {100 * ALLOWED:g} %",
                    f"{value:.3f} +- {error:.3f} m/s^2, off the ground {100 * airborne:.2g} % of the time",
                    abs(value / formula.weighted - 1.0) < ALLOWED,
                )
            )
    names = (
        "class",
        "speed_m_s",
        "formula_m_s2",
        "ridden_m_s2",
        "error_m_s2",
        "formula_load",
        "ridden_load",
        "airborne",
    )
    columns = {name: np.array(values) for name, values in zip(names, zip(*rows, strict=True), strict=True)}
    findings.append(_step_of_a_class(columns))
    return Outcome(tuple(findings), {"rides": columns}, lambda figure: _draw(figure, columns))


def _step_of_a_class(columns: dict[str, np.ndarray]) -> Finding:
    """Four times the density is twice the acceleration, as long as the tyre is linear."""
    a, b = (columns["ridden_m_s2"][columns["class"] == letter] for letter in "AB")
    off = float(np.abs(b / a - 2.0).max())
    return Finding("class B over class A", "2, within 1e-3", f"2 within {off:.1e}", off < 1e-3)


def _draw(figure: Figure, columns: dict[str, np.ndarray]) -> None:
    """Rides as points on the formula's lines, and how much of the time the tyre was off the ground."""
    left, right = figure.subplots(1, 2)
    place = np.arange(len(CLASSES))
    for speed, colour in zip(SPEEDS, SPEED_COLOURS, strict=True):
        at = columns["speed_m_s"] == speed
        left.semilogy(place, columns["formula_m_s2"][at], "-", color=colour, lw=0.8)
        left.semilogy(place, columns["ridden_m_s2"][at], "o", color=colour, ms=5.0, label=f"{speed:g} m/s")
        right.plot(place, 100.0 * columns["airborne"][at], "o-", color=colour, lw=0.8)
    left.axhline(0.315, color=FORMULA, lw=0.6, ls="--")
    for axes in (left, right):
        axes.set_xticks(place, CLASSES)
    label(left, "lines: formula; dashed: not uncomfortable below", "ISO 8608 class", "a_w (m/s^2)", legend=True)
    label(right, "tyre off the ground", "ISO 8608 class", "part of the time (%)")
