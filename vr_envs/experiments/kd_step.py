"""Equation 3.88 of the lecture, v' = k_d v + a dt: a factor once a step is another damping at every step.

A spring with the factor k_d has the map [[1, dt], [-w2 dt, k_d - w2 dt^2]], whose determinant is k_d: while it swings,
its area in the plane of displacement and velocity shrinks by k_d a step, as that of  x'' + gamma x' + w2 x = 0  shrinks
by e^(-gamma dt). So k_d is gamma = -ln(k_d) / dt, and k_d = e^(-gamma dt) is what keeps the damping.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from vr_envs.experiments.experiment import Finding, Outcome, Progress
from vr_envs.experiments.look import BALL, BAR, FAINT, FORMULA, FOUND, label
from vr_envs.models.jit import kernel
from vr_envs.models.record import dtype_of, pack
from vr_envs.models.ride_options import Textbook
from vr_envs.models.ride_textbook import drift, kick
from vr_envs.models.spring import damping_of_restitution, free_motion
from vr_envs.models.terrain_ride import Params, State

if TYPE_CHECKING:
    from matplotlib.figure import Figure

K_D, REFERENCE = 0.99, 1.0 / 60.0  # the lecture's factor, and the step (s) at which it is taken to be meant
RATES = (30, 60, 120, 960)  # steps in a second
PRINTED = (0.302, 0.603, 1.206)  # 1/s, at the first three
SPAN = 6.0  # s
START = 0.05  # m


@kernel
def ring_down(state, step, gamma, w2, travel, params, textbook):
    """Write the displacements (n,) of a spring on level ground after every step; the first is the start."""
    state.travel, state.velocity = travel[0], 0.0
    for i in range(1, travel.shape[0]):
        rise = drift(state, step, params, None, None, None, None, None, None)
        kick(state, step, rise, gamma, w2, 0.0, textbook)
        travel[i] = state.travel


def rung(rate: int, gamma: float) -> np.ndarray:
    """Displacements (m) at `rate` steps in a second, with the factor e^(-gamma / rate)."""
    settings = Params()
    travel = np.full(round(SPAN * rate) + 1, START)
    state = np.zeros(1, dtype_of(State))[0]
    ring_down(state, 1.0 / rate, gamma, settings.w2, travel, pack(settings), pack(Textbook()))
    return travel


def damping_of(travel: np.ndarray, rate: int) -> float:
    """Damping (1/s) seen in a motion: x'' = a x' - b x from step to step, and b is the map's determinant."""
    (_, b), *_ = np.linalg.lstsq(np.stack([travel[1:-1], -travel[:-2]], axis=1), travel[2:], rcond=None)
    return -math.log(b) * rate


def kd_step(progress: Progress) -> Outcome:
    """The same factor at several steps, and the same damping."""
    meant = damping_of_restitution(K_D, REFERENCE)
    factor = {rate: rung(rate, damping_of_restitution(K_D, 1.0 / rate)) for rate in progress(RATES, desc="steps")}
    physical = {rate: rung(rate, meant) for rate in RATES}
    found = {rate: (damping_of(factor[rate], rate), damping_of(physical[rate], rate)) for rate in RATES}
    findings = [
        Finding(
            f"damping of k_d = {K_D:g} at dt = 1/{rate} s",
            f"{printed:.3f} 1/s = -ln(k_d)/dt, within 1e-9",
            f"{found[rate][0]:.3f} 1/s",
            abs(found[rate][0] * (1.0 / rate) / -math.log(K_D) - 1.0) < 1e-9 and round(found[rate][0], 3) == printed,
        )
        for rate, printed in zip(RATES[:3], PRINTED, strict=True)
    ]
    spread = max(abs(found[rate][1] / meant - 1.0) for rate in RATES)
    findings.append(
        Finding(
            f"damping of k_d = e^(-gamma dt), gamma = {meant:.3f} 1/s, at every step",
            "the same, within 1e-9",
            f"within {spread:.0e}",
            spread < 1e-9,
        )
    )
    errors = {rate: _error(physical[rate], rate, meant) for rate in RATES}
    growth = errors[30] / errors[120]
    findings.append(
        Finding(
            "distance of that motion from the exact one, 1/30 s over 1/120 s",
            "4 (order 1), within 15 %",
            f"{growth:.2f}; {1e3 * errors[30]:.2f} and {1e3 * errors[120]:.2f} mm at most",
            abs(growth / 4.0 - 1.0) < 0.15,
        )
    )
    columns = {
        "step_s": 1.0 / np.array(RATES),
        "damping_of_the_factor_1_s": np.array([found[rate][0] for rate in RATES]),
        "damping_of_the_damping_1_s": np.array([found[rate][1] for rate in RATES]),
        "largest_error_m": np.array([errors[rate] for rate in RATES]),
    }
    return Outcome(tuple(findings), {"dampings": columns}, lambda figure: _draw(figure, factor, physical, meant))


def _exact(seconds: np.ndarray, gamma: float) -> np.ndarray:
    return np.array([free_motion(START, 0.0, gamma, Params().w2, float(t))[0] for t in seconds])


def _error(travel: np.ndarray, rate: int, gamma: float) -> float:
    """Largest distance (m) from the exact motion."""
    return float(np.abs(travel - _exact(np.arange(len(travel)) / rate, gamma)).max())


def _draw(figure: Figure, factor: dict[int, np.ndarray], physical: dict[int, np.ndarray], meant: float) -> None:
    """Both families over time."""
    figure.set_size_inches(9.0, 6.5)
    above, below = figure.subplots(2, 1, sharex=True)
    for axes, motions, text in (
        (above, factor, f"the lecture's factor, k_d = {K_D:g} a step"),
        (below, physical, f"one damping, k_d = e^(-γ dt), γ = {meant:.3f} 1/s"),
    ):
        for (rate, travel), colour in zip(motions.items(), (BALL, BAR, FOUND, FAINT), strict=True):
            axes.plot(np.arange(len(travel)) / rate, 1e3 * travel, color=colour, lw=0.8, label=f"1/{rate} s")
        seconds = np.linspace(0.0, SPAN, 601)
        axes.plot(
            seconds, 1e3 * _exact(seconds, meant), ":", color=FORMULA, lw=0.8, label=f"exact, γ = {meant:.3f} 1/s"
        )
        label(axes, text, "time (s)" if axes is below else "", "displacement (mm)", legend=True)
