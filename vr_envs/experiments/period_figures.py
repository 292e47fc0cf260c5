"""Figures 3.1 to 3.4, 3.6, 3.7 and tables 3.1, 3.2: period one and two, with one and with two bar cycles a bounce."""

from __future__ import annotations

import dataclasses

import numpy as np

from vr_envs.experiments.bounce import (
    lower_bound,
    newton,
    orbit_residual,
    period_one_phase,
    restitution_of_phase,
    upper_bound,
    vertical,
    z_omega,
)
from vr_envs.experiments.experiment import Finding, Outcome, Progress
from vr_envs.experiments.periodic import Setting, halves, near, one_findings, outcome_of, table, two_findings
from vr_envs.models.ball_on_bar import Params


def period_one(progress: Progress) -> Outcome:
    """Figures 3.1, 3.2 and table 3.1."""
    setting = Setting(30.0, 10.4, 1, 1000.0, 2)
    alpha = restitution_of_phase(setting.acceleration, 0.97, 1, Params().gravity)
    measured = _mean_phases(setting, alpha, 1)[0]
    findings = [
        Finding(
            f"phase with a restitution of {alpha:.4f}, which period one needs (closed form) for Bell's mean phase",
            "0.9700 rad, within 1e-6 rad",
            f"{measured:.7f} rad",
            near(measured, 0.97, 1e-6),
        )
    ]
    settled = setting.settled(0.68)
    seen, bounces = setting.seen(*settled)
    findings += one_findings(setting, settled[0], bounces)
    phase = _mean_phases(setting, 0.75, 1)[0]
    expected = period_one_phase(setting.acceleration, 1, vertical(30.0, 0.75))
    findings.append(
        Finding(
            "phase with Bell's best fit 0.75",
            f"{expected:.4f} rad (closed form), within 1e-6 rad: not his 0.97",
            f"{phase:.7f} rad",
            near(phase, expected, 1e-6),
        )
    )
    period, _ = setting.repeats(0.856)
    limit = upper_bound(1, vertical(30.0, 0.856))
    findings.append(
        Finding(
            "orbit with Bell's dropped-ball 0.856",
            f"period 2: it flips at {limit:.2f} m/s^2",
            f"period {period}",
            period == 2,
        )
    )
    title = "Period one: peak acceleration 10.4 m/s², z at 30 Hz, restitution 0.68 (Figs 3.1, 3.2)"
    return outcome_of(setting, settled, seen, bounces, findings, _columns(table(bounces)), 1, title, 2.0)


def period_two(progress: Progress) -> Outcome:
    """Figures 3.3, 3.4 and table 3.2."""
    setting = Setting(30.0, 11.95, 1, 1000.0, 2)
    settled = setting.settled(0.68)
    seen, bounces = setting.seen(*settled)
    findings = two_findings(setting, settled[0], bounces)

    gravity, omega = settled[0].gravity, z_omega(settled[0])
    fit = newton(lambda p: orbit_residual([0.67, 1.36], [1, 1], p[0], p[1], gravity, omega), [12.0, 0.7])
    measured = np.sort(_mean_phases(dataclasses.replace(setting, acceleration=float(fit[0])), float(fit[1]), 2))
    findings.append(
        Finding(
            f"phases at {fit[0]:.3f} m/s^2 and a restitution of {fit[1]:.4f}, which Bell's mean phases need (orbit's "
            f"equations; his 11.95 is {1.0 - setting.acceleration / fit[0]:.1%} less)",
            "0.67 and 1.36 rad, within 1e-6 rad",
            " and ".join(f"{phase:.7f}" for phase in measured) + " rad",
            bool(np.abs(measured - [0.67, 1.36]).max() < 1e-6),
        )
    )
    title = "Period two: peak acceleration 11.95 m/s², z at 30 Hz, restitution 0.68 (Figs 3.3, 3.4)"
    return outcome_of(setting, settled, seen, bounces, findings, halves(bounces), 2, title, 2.0)


def period_one_m2(progress: Progress) -> Outcome:
    """Figure 3.6."""
    setting = Setting(20.0, 11.5, 2, 1000.0, 2)
    settled = setting.settled(0.75)
    seen, bounces = setting.seen(*settled)
    findings = one_findings(setting, settled[0], bounces)
    low, high = restitution_range(setting.acceleration, 2)
    for alpha, stable in ((low - 0.003, False), (low + 0.003, True), (high - 0.003, True), (high + 0.003, False)):
        period, interval = setting.repeats(alpha)
        holds = period == 1 and near(interval, 2.0, 1e-6)
        findings.append(
            Finding(
                f"restitution {alpha:.4f}",
                f"period one with m = 2 {'holds' if stable else 'does not hold'}: it does from {low:.4f} to {high:.4f}",
                f"period {period}, m = {interval:.3g}" if period else "locks or does not repeat",
                holds == stable,
            )
        )
    title = "Period one, m = 2: peak acceleration 11.5 m/s², z at 20 Hz, restitution 0.75 (Fig 3.6)"
    return outcome_of(setting, settled, seen, bounces, findings, _columns(table(bounces)), 1, title, 16.0)


def period_two_m2(progress: Progress) -> Outcome:
    """Figure 3.7."""
    setting = Setting(20.0, 13.3, 2, 1000.0, 2)
    settled = setting.settled(0.76)
    seen, bounces = setting.seen(*settled)
    findings = two_findings(setting, settled[0], bounces)
    _, flip = restitution_range(setting.acceleration, 2)
    period, _ = setting.repeats(0.75)
    findings.append(
        Finding(
            "orbit with Bell's best fit 0.75",
            f"still period 1: period two needs a restitution above {flip:.4f}",
            f"period {period}",
            period == 1,
        )
    )
    title = "Period two, m = 2: peak acceleration 13.3 m/s², z at 20 Hz, restitution 0.76 (Fig 3.7)"
    return outcome_of(setting, settled, seen, bounces, findings, halves(bounces), 2, title, 16.0)


def restitution_range(acceleration: float, m: int) -> tuple[float, float]:
    """Between which restitutions period one of mode m is stable at a peak acceleration, by bisection of its bounds."""
    bounds = []
    for bound in (lower_bound, upper_bound):
        low, high = 0.0, 1.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if bound(m, Params(restitution=middle)) > acceleration else (low, middle)
        bounds.append(high)
    return bounds[0], bounds[1]


def _mean_phases(setting: Setting, restitution: float, period: int) -> np.ndarray:
    """Phases (period,) at the impacts of the settled ball, means of the camera's fits, rad."""
    phases = setting.seen(*setting.settled(restitution))[1].phases
    return np.array([phases[i::period].mean() for i in range(period)])


def _columns(rows: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    return {name: values for name, values in rows.items() if name != "impact"}
