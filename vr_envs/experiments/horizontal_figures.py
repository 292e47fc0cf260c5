"""Figures 4.1 to 4.3 and 4.5 to 4.7: where the moving bar draws the ball to its centre and where it drives it away."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from vr_envs.experiments.experiment import Finding, Outcome, Progress
from vr_envs.experiments.horizontal import (
    FRICTIONLESS,
    LAWS,
    PARTIAL,
    SPHERE,
    STICKING,
    TILT_ACCELERATION,
    ContactLaw,
    growth_rates,
    harmonics,
)
from vr_envs.experiments.look import BALL, BAR, FAINT, FORMULA, FOUND, label, shared_legend

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PHASES = np.linspace(-math.pi, math.pi, 72, endpoint=False)
TILTS = np.linspace(20.0, 240.0, 12)  # rad/s^2
COLOURS = dict(zip(LAWS, (FAINT, BALL, BAR, FOUND), strict=True))
PHASE_LABEL, GAMMA_LABEL, TILT_LABEL = "φ (rad)", "γ / ω", "tilt acceleration (rad/s²)"
PHASE_TICKS = ["-π", "-π/2", "0", "π/2", "π"]


@dataclasses.dataclass(frozen=True)
class Curves:
    """gamma / omega over the phase, (laws, x accelerations, phases)."""

    laws: tuple[ContactLaw, ...]
    x: tuple[float, ...]
    rates: np.ndarray

    def of(self, law: ContactLaw, x: float) -> np.ndarray:
        """One curve."""
        return self.rates[self.laws.index(law), self.x.index(x)]

    def columns(self) -> dict[str, np.ndarray]:
        """The curves as a table."""
        table = {"phi_rad": PHASES}
        for law in self.laws:
            for x in self.x:
                table[f"gamma_over_omega, {law.name}, x {x:g} m/s^2"] = self.of(law, x)
        return table


def _curves(progress: Progress, x: tuple[float, ...]) -> Curves:
    rates = []
    for law in progress(LAWS, desc="contact laws"):
        cycle_map = law.cycle_map()
        rates.append([growth_rates(cycle_map, a, [TILT_ACCELERATION], PHASES)[0] for a in x])
    return Curves(LAWS, x, np.array(rates))


def _range(what: str, expected: str, rates: np.ndarray, agrees: bool) -> Finding:
    return Finding(what, expected, f"from {rates.min():+.5f} to {rates.max():+.5f}", agrees)


def _never_negative(curves: Curves, laws: tuple[ContactLaw, ...], x: float) -> list[Finding]:
    found = [(law, curves.of(law, x)) for law in laws]
    return [
        _range(f"{law.name}: gamma at Acc_x = {x:g} m/s^2", "never below zero", r, bool(r.min() > 0))
        for law, r in found
    ]


def _plot(figure: Figure, curves: Curves, x: float, title: str) -> None:
    """Bell's curve by the law that gives it, and beside it those of all laws."""
    figure.set_size_inches(11.0, 5.0)
    alone, together = figure.subplots(1, 2)
    for axes, laws in ((alone, (PARTIAL,)), (together, curves.laws)):
        for law in laws:
            _curve(axes, curves.of(law, x), color=COLOURS[law], label=law.name)
    label(alone, f"{PARTIAL.name}: the law that comes nearest to Bell", PHASE_LABEL, GAMMA_LABEL)
    label(together, "all contact laws", PHASE_LABEL, GAMMA_LABEL)
    shared_legend(figure, *together.get_legend_handles_labels())
    figure.suptitle(title)


def _curve(axes: Axes, rates: np.ndarray, **style: Any) -> None:
    """gamma over one whole turn of phi."""
    axes.plot(np.append(PHASES, math.pi), np.append(rates, rates[0]), **style)
    axes.axhline(0.0, color=FORMULA, linewidth=0.6)
    axes.set_xticks(np.linspace(-math.pi, math.pi, 5), PHASE_TICKS)


def no_x_motion(progress: Progress) -> Outcome:
    """Figure 4.1: the tilt alone is a source at every phase."""
    curves = _curves(progress, (0.0,))
    findings = _never_negative(curves, (FRICTIONLESS, PARTIAL, SPHERE), 0.0)
    sticking = curves.of(STICKING, 0.0)
    findings.append(
        _range(
            f"{STICKING.name}: gamma at Acc_x = 0",
            "Bell's claim fails by a little: below zero by 5 to 10 % of its largest value",
            sticking,
            bool(-0.1 < sticking.min() / sticking.max() < -0.05),
        )
    )
    partial = curves.of(PARTIAL, 0.0)
    _, first, second = harmonics(PHASES, partial)
    findings.append(
        Finding(
            f"{PARTIAL.name}: harmonics of gamma(phi)",
            "a sine of 2 phi that repeats (Bell: the repeated sine curve): no first harmonic",
            f"first {first:.1e}, second {second:.5f}",
            first < 1e-6 * second,
        )
    )

    def draw(figure: Figure) -> None:
        _plot(figure, curves, 0.0, f"no x-motion, z 8 m/s², tilt {TILT_ACCELERATION:g} rad/s² (Fig 4.1)")

    return Outcome(tuple(findings), {"growth": curves.columns()}, draw)


def small_x_motion(progress: Progress) -> Outcome:
    """Figure 4.5: a small x-motion makes gamma negative at some phases."""
    curves = _curves(progress, (1.0,))
    partial = curves.of(PARTIAL, 1.0)
    findings = [
        _range(
            f"{PARTIAL.name}: gamma at Acc_x = 1 m/s^2",
            "below zero at some phases; largest 0.02 to 0.025 (Bell's axis, for which the tilt was chosen)",
            partial,
            bool(partial.min() < 0.0 and 0.02 < partial.max() < 0.025),
        ),
        *_never_negative(curves, (FRICTIONLESS, SPHERE), 1.0),
    ]

    def draw(figure: Figure) -> None:
        _plot(figure, curves, 1.0, f"Acc_x = 1 m/s², z 8 m/s², tilt {TILT_ACCELERATION:g} rad/s² (Fig 4.5)")

    return Outcome(tuple(findings), {"growth": curves.columns()}, draw)


def x_motions(progress: Progress) -> Outcome:
    """Figure 4.7: with growing x-motion the repeated sine becomes a single one, centred on zero."""
    x = (0.0, 1.0, 2.0, 4.0)
    curves = _curves(progress, x)
    partial = curves.of(PARTIAL, 4.0)
    mean, first, second = harmonics(PHASES, partial)
    negative = float(np.mean(partial < 0.0))
    sizes = [harmonics(PHASES, curves.of(PARTIAL, a))[1] for a in x[1:]]
    spread = max(s / a for s, a in zip(sizes, x[1:], strict=True)) / min(
        s / a for s, a in zip(sizes, x[1:], strict=True)
    )
    findings = [
        Finding(
            f"{PARTIAL.name}: gamma(phi) at Acc_x = 4 m/s^2",
            "one sine centred on zero, largest about 0.04: second harmonic and mean below 15 % of the first",
            f"mean {mean:+.5f}, first harmonic {first:.5f}, second {second:.5f}, largest {partial.max():.5f}",
            abs(mean) < 0.15 * first and second < 0.15 * first and 0.035 < partial.max() < 0.045,
        ),
        Finding(
            f"{PARTIAL.name}: phases that draw the ball in at Acc_x = 4 m/s^2",
            "about half of them: 40 to 50 %",
            f"{100 * negative:.0f} %",
            0.4 <= negative <= 0.5,
        ),
        Finding(
            f"{PARTIAL.name}: first harmonic of gamma over Acc_x",
            "in proportion to Acc_x within 15 %",
            ", ".join(f"{s:.5f} at {a:g}" for s, a in zip(sizes, x[1:], strict=True)),
            spread < 1.15,
        ),
        *(f for a in x for f in _never_negative(curves, (FRICTIONLESS, SPHERE), a)),
    ]

    def draw(figure: Figure) -> None:
        figure.set_size_inches(10.0, 7.5)
        panels = figure.subplots(2, 2, sharex=True, sharey=True)
        for axes, law in zip(panels.flat, LAWS, strict=True):
            for a, style in zip(x, (":", "-.", "--", "-"), strict=True):
                _curve(axes, curves.of(law, a), linestyle=style, color=COLOURS[law], label=f"Acc_x = {a:g} m/s²")
            below, left = law in LAWS[2:], law in LAWS[::2]
            label(axes, law.name, PHASE_LABEL if below else "", GAMMA_LABEL if left else "")
        handles, names = panels[0, 0].get_legend_handles_labels()
        shared_legend(figure, handles, names)
        figure.suptitle(f"z 8 m/s², tilt {TILT_ACCELERATION:g} rad/s² (Fig 4.7)")

    return Outcome(tuple(findings), {"growth": curves.columns()}, draw)


def _surfaces(progress: Progress, x: float, title: str) -> tuple[dict[ContactLaw, np.ndarray], Outcome]:
    surfaces = {law: growth_rates(law.cycle_map(), x, TILTS, PHASES) for law in progress(LAWS, desc="contact laws")}
    columns = {
        "tilt_acceleration_rad_s2": np.repeat(TILTS, len(PHASES)),
        "phi_rad": np.tile(PHASES, len(TILTS)),
        **{f"gamma_over_omega, {law.name}": rates.ravel() for law, rates in surfaces.items()},
    }

    def draw(figure: Figure) -> None:
        figure.set_size_inches(14.0, 7.5)
        grid = figure.add_gridspec(2, len(surfaces), height_ratios=(1.3, 1.0))
        for k, (law, rates) in enumerate(surfaces.items()):
            above: Any = figure.add_subplot(grid[0, k], projection="3d")
            closed = np.append(rates, rates[:, :1], axis=1)
            above.plot_surface(*np.meshgrid(np.append(PHASES, math.pi), TILTS), closed, cmap="coolwarm", linewidth=0.2)
            above.set_xticks(np.linspace(-math.pi, math.pi, 5), PHASE_TICKS)
            above.set_yticks([50.0, 150.0, 250.0])
            above.tick_params(labelsize=8, pad=0)
            label(above, law.name, PHASE_LABEL, "tilt (rad/s²)")
            side = figure.add_subplot(grid[1, k])
            side.plot(TILTS, rates, color=COLOURS[law], linewidth=0.5)
            side.axhline(0.0, color=FORMULA, linewidth=0.6)
            label(side, "seen from the side: a line for each φ", TILT_LABEL, GAMMA_LABEL if k == 0 else "")
        figure.suptitle(title)

    return surfaces, Outcome((), {"growth": columns}, draw)


def _power(rates: np.ndarray) -> float:
    """The power of the tilt acceleration with which the mean of gamma over the phases grows, from the smaller half."""
    half = len(TILTS) // 2
    return float(np.polyfit(np.log(TILTS[:half]), np.log(rates.mean(axis=1)[:half]), 1)[0])


def surface(progress: Progress) -> Outcome:
    """Figures 4.2 and 4.3: gamma over phase and tilt acceleration, without x-motion."""
    surfaces, outcome = _surfaces(progress, 0.0, "γ / ω with no x-motion, z 8 m/s² (Figs 4.2, 4.3)")
    findings = [
        _range(f"{law.name}: gamma at tilts of 20 to 240 rad/s^2", "never below zero", r, bool(r.min() > 0.0))
        for law, r in surfaces.items()
        if law is not STICKING
    ]
    powers = {FRICTIONLESS: 1.0, SPHERE: 1.0, PARTIAL: 2.0}
    findings += [
        Finding(
            f"{law.name}: gamma grows with the tilt acceleration to the power",
            f"{power:g}, within 0.1",
            f"{_power(surfaces[law]):.3f}",
            abs(_power(surfaces[law]) - power) < 0.1,
        )
        for law, power in powers.items()
    ]
    return dataclasses.replace(outcome, findings=tuple(findings))


def surface_x(progress: Progress) -> Outcome:
    """Figure 4.6: the same at an x acceleration of 1 m/s^2."""
    surfaces, outcome = _surfaces(progress, 1.0, "γ / ω at Acc_x = 1 m/s², z 8 m/s² (Fig 4.6)")
    partial = surfaces[PARTIAL].min(axis=1)
    findings = [
        Finding(
            f"{PARTIAL.name}: smallest gamma over the phases",
            "below zero, deepest at a tilt in between: with x it falls as the tilt, tilt alone adds its square",
            f"{partial[0]:+.5f} at {TILTS[0]:g}, lowest {partial.min():+.5f} at {TILTS[partial.argmin()]:g}, "
            f"{partial[-1]:+.5f} at {TILTS[-1]:g} rad/s^2",
            bool(partial[0] < 0.0 and partial.min() < min(partial[0], partial[-1])),
        ),
        *(
            _range(
                f"{law.name}: gamma at Acc_x = 1 m/s^2", "never below zero", surfaces[law], surfaces[law].min() > 0.0
            )
            for law in (FRICTIONLESS, SPHERE)
        ),
    ]
    return dataclasses.replace(outcome, findings=tuple(findings))
