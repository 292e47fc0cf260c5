"""The lecture's heading step, psi' = psi + atan(v_x / v): without dt, so the turn rate is what the step makes of it.

In a steady turn the recurrence flies a polygon, whose sides v dt turn by q = atan(v_x / v) each: its corners lie on a
circle of radius v dt / (2 sin(q/2)), flown at the turn rate q / dt. At dt = 1 s that is the turn that was asked for.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vr_envs.experiments.experiment import Finding, Outcome, Progress
from vr_envs.experiments.look import BALL, BAR, FAINT, FORMULA, FOUND, label
from vr_envs.models.autopilot import State
from vr_envs.models.autopilot_options import Textbook, Track
from vr_envs.models.autopilot_textbook import fly_in_steps
from vr_envs.models.ground_track import uniform_turn
from vr_envs.models.record import dtype_of, pack

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SLOPE = 0.05  # lateral over forward speed
SPEED = 100.0  # m/s
STEPS = {"1": 1.0, "0.1": 0.1, "1/60": 1.0 / 60.0}  # s
PRINTED = (2.9, 28.6, 172.0)  # deg/s
SECONDS = 60
CORNERS = 1e-6  # m, by which a corner may be off the circle


class Flight(NamedTuple):
    """Places x, z (m) and heading (rad, counted on) after every second, the start first."""

    x: np.ndarray
    z: np.ndarray
    heading: np.ndarray


def flown(step: float | None) -> Flight:
    """A steady turn by the recurrence with a step (s), or exactly."""
    state = np.zeros(1, dtype_of(State))[0]
    state["speed"], state["turn_rate"] = SPEED, math.atan(SLOPE)
    track, rows = pack(Track()), [(0.0, 0.0, 0.0)]
    for _ in range(SECONDS):
        if step is None:
            uniform_turn(state, 1.0)
            state["heading"] += state["turn_rate"]
        else:
            fly_in_steps(state, 0.0, 0.0, math.atan(SLOPE), 1.0, track, pack(Textbook(step=step)))
        rows.append((float(state["x"]), float(state["z"]), float(state["heading"])))
    return Flight(*np.array(rows).T)


def heading(progress: Progress) -> Outcome:
    """One minute of a steady turn at three steps."""
    flights = {name: flown(step) for name, step in progress(STEPS.items(), desc="steps")}
    exact, findings = flown(None), []
    angle = math.atan(SLOPE)
    rates, radii, offs = [], [], []
    for (name, step), printed in zip(STEPS.items(), PRINTED, strict=True):
        flight = flights[name]
        rate = math.degrees((flight.heading[-1] - flight.heading[0]) / SECONDS)
        radius = 0.5 * SPEED * step / math.sin(0.5 * angle)
        # the first side goes along z; the centre is on the bisector of the first corner
        x, z = radius * math.cos(0.5 * angle), 0.5 * SPEED * step
        off = float(np.abs(np.hypot(flight.x - x, flight.z - z) - radius).max())
        rates.append(rate)
        radii.append(radius)
        offs.append(off)
        digits = 1 if printed < 100.0 else 0
        findings += [
            Finding(
                f"turn rate with v_x/v = {SLOPE:g} at dt = {name} s",
                f"{printed:g} deg/s",
                f"{rate:.{digits}f} deg/s",
                round(rate, digits) == printed,
            ),
            Finding(
                f"its track at dt = {name} s",
                f"corners on a circle of {radius:.1f} m, within {CORNERS:g} m",
                f"off it by {off:.0e} m at most",
                off < CORNERS,
            ),
        ]
    exact_rate = math.degrees(exact.heading[-1] / SECONDS)
    findings.append(
        Finding(
            "turn at dt = 1 s against the exact one that was asked for",
            f"the same rate, {exact_rate:.2f} deg/s; radius {SPEED / angle:.1f} m, up to 1/24 of the angle's square",
            f"{rates[0]:.2f} deg/s; {radii[0]:.1f} m",
            abs(rates[0] / exact_rate - 1.0) < 1e-12 and 0.0 < radii[0] * angle / SPEED - 1.0 < angle**2 / 23.0,
        )
    )
    columns = {
        "step_s": np.array(list(STEPS.values())),
        "turn_rate_deg_s": np.array(rates),
        "radius_m": np.array(radii),
        "largest_distance_from_circle_m": np.array(offs),
    }
    return Outcome(tuple(findings), {"turns": columns}, lambda figure: _draw(figure, flights, exact, rates))


def _draw(figure: Figure, flights: dict[str, Flight], exact: Flight, rates: list[float]) -> None:
    """Tracks seen from above, and turn rates over the step."""
    figure.set_size_inches(10.0, 5.0)
    left, right = figure.subplots(1, 2)
    left.plot(1e-3 * exact.x, 1e-3 * exact.z, color=FORMULA, lw=3.0, alpha=0.3, label="exact")
    steps = np.geomspace(min(STEPS.values()), 1.0, 50)
    right.loglog(steps, np.degrees(math.atan(SLOPE) / steps), color=FAINT, lw=0.8, label="atan(v_x / v) / dt")
    right.axhline(math.degrees(math.atan(SLOPE)), color=FORMULA, lw=3.0, alpha=0.3, label="exact")
    for (name, flight), rate, colour in zip(flights.items(), rates, (BALL, BAR, FOUND), strict=True):
        left.plot(1e-3 * flight.x, 1e-3 * flight.z, ".-", color=colour, ms=3.0, lw=0.6, label=f"dt = {name} s")
        right.loglog(STEPS[name], rate, "o", color=colour, label=f"dt = {name} s")
    left.set_aspect("equal")
    label(left, "one minute of the same command, from above", "x (km)", "z (km)", legend=True)
    label(right, f"turn rate with v_x / v = {SLOPE:g}", "step (s)", "turn rate (deg/s)", legend=True)
