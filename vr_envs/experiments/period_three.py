"""Figure 3.5: a stable period three beside period one and two, found by scanning the starts."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from vr_envs.experiments.attractors import Ends, ends_of_starts, grid_of_starts
from vr_envs.experiments.bounce import orbit_apexes, orbit_phases, vertical, z_omega
from vr_envs.experiments.camera_trace import Bounces, CameraTrace
from vr_envs.experiments.experiment import Finding, Outcome, Progress
from vr_envs.experiments.look import label, paint
from vr_envs.experiments.periodic import Setting, draw_trace, table, trace_table
from vr_envs.render.style import BLUE, GROUND, ORANGE, PALE_BLUE, PALE_GROUND, RED

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SETTING = Setting(30.0, 11.11, 1, 2000.0, 3)
STARTS = 48  # per axis of the plane of phase and speed
HIGHEST = 3.0  # W, start speed relative to the bar over pi g / omega
SKIP, KEEP = 400, 60  # base cycles, impacts
RESTITUTIONS = (0.68, 0.80)

ORBITS = {
    "locking": RED,
    "period 1": BLUE,
    "period 2": PALE_BLUE,
    "period 3": ORANGE,
    "m > 1": GROUND,
    "other": PALE_GROUND,
}


def period_three(progress: Progress) -> Outcome:
    """Scan the starts at both restitutions, then show the orbit as the camera saw it."""
    findings: list[Finding] = []
    maps: dict[float, Ends] = {}
    tables: dict[str, dict[str, np.ndarray]] = {}
    shown: tuple[CameraTrace, Bounces] | None = None
    for alpha in progress(RESTITUTIONS, desc="starts"):
        params = vertical(SETTING.frequency, alpha)
        motions, states, tau, speed = grid_of_starts(params, SETTING.acceleration, STARTS, HIGHEST)
        found, kept, finals = ends_of_starts(params, motions, states, SKIP, KEEP)
        maps[alpha] = found
        tables[f"basin-{alpha:g}"] = {
            "tau": np.repeat(tau, STARTS),
            "speed": np.tile(speed, STARTS),
            "locked": found.rested.astype(int),
            "period": found.period,
            "interval": found.interval,
        }
        rows = np.flatnonzero((found.period == 3) & (np.abs(found.interval - 1.0) < 1e-6))
        findings.append(_beside(alpha, found, len(rows)))
        if not len(rows):
            continue
        row = rows[0]
        findings += _orbit(alpha, kept[row, -3:])
        if shown is None:
            shown = SETTING.seen(params, motions[row], finals[row])
            tables |= {"impacts": table(shown[1]), "trace": trace_table(shown[0])}
            findings.append(_seen(shown[1], kept[row, -3:], params.gravity))

    def draw(figure: Figure) -> None:
        from matplotlib.patches import Patch

        figure.set_size_inches(9.0, 10.0)
        parts: Any = figure.subfigures(2, 1, height_ratios=(3, 2))
        if shown is not None:
            draw_trace(
                parts[0],
                *shown,
                "Period three: peak acceleration 11.11 m/s², z at 30 Hz, restitution 0.68 (Fig 3.5)",
                3.5,
            )
        for axes, (alpha, found) in zip(parts[1].subplots(1, 2, sharey=True), maps.items(), strict=True):
            _draw_basin(axes, alpha, found)
        handles = [Patch(color=paint(colour), label=name) for name, colour in ORBITS.items()]
        parts[1].legend(handles=handles, fontsize=8, frameon=False, loc="outside lower center", ncols=len(handles))

    return Outcome(tuple(findings), tables, draw)


def _beside(alpha: float, found: Ends, threes: int) -> Finding:
    """What the starts end in."""
    other = 1 if alpha < 0.75 else 2
    shares = {
        "locking": float(found.rested.mean()),
        f"period {other}": found.share(other, 1.0),
        "period 3": found.share(3, 1.0),
    }
    told = ", ".join(f"{name} {share:.1%}" for name, share in shares.items())
    return Finding(
        f"where {found.period.size} starts end, restitution {alpha:g}",
        f"a stable period 3 coexists with period {other}; it is a matter of the start, not of a transition (Bell)",
        f"{told}, others {1.0 - sum(shares.values()):.1%}",
        threes > 0 and found.share(other, 1.0) > 0.0,
    )


def _orbit(alpha: float, impacts: np.ndarray) -> list[Finding]:
    """The orbit's apexes, and the equations of motion for its phases."""
    params = vertical(SETTING.frequency, alpha)
    apexes = np.sort(1e3 * (impacts["z"] + impacts["w_out"] ** 2 / (2.0 * params.gravity)))
    counts = _counts(impacts, params.gravity, z_omega(params))
    phases = orbit_phases(impacts["phase"], counts, SETTING.acceleration, params)
    expected = np.sort(1e3 * orbit_apexes(phases, counts, SETTING.acceleration, params))
    error = float(np.abs(phases - impacts["phase"]).max())
    return [
        Finding(
            f"apexes of period 3, restitution {alpha:g}",
            f"{', '.join(f'{a:.4f}' for a in expected)} mm (orbit's equations), within 1e-6 mm",
            f"{', '.join(f'{a:.4f}' for a in apexes)} mm",
            bool(np.abs(apexes - expected).max() < 1e-6),
        ),
        Finding(
            f"phases of period 3, restitution {alpha:g}",
            f"{', '.join(f'{p:.4f}' for p in phases)} rad (orbit's equations), within 1e-9 rad",
            f"largest difference {error:.0e} rad",
            error < 1e-9,
        ),
    ]


def _counts(impacts: np.ndarray, gravity: float, omega: float) -> list[int]:
    """Periods of z between the impacts of an orbit of three, from its flights."""
    height, out = impacts["z"], impacts["w_out"]
    rise = out + np.sqrt(out**2 + 2.0 * gravity * (height - np.roll(height, -1)))
    turns = (omega * rise / gravity - (np.roll(impacts["phase"], -1) - impacts["phase"])) / (2.0 * math.pi)
    return [round(float(t)) for t in turns]


def _seen(bounces: Bounces, impacts: np.ndarray, gravity: float) -> Finding:
    """The camera's phases against the simulation's."""
    found = np.sort(bounces.phases)[[0, len(bounces.phases) // 2, -1]]
    exact = np.sort(impacts["phase"])
    return Finding(
        "phases from the camera's fits",
        f"{', '.join(f'{p:.4f}' for p in exact)} rad, within 1e-6 rad",
        f"{', '.join(f'{p:.7f}' for p in found)} rad",
        bool(np.abs(found - exact).max() < 1e-6),
    )


def _draw_basin(axes, alpha: float, found: Ends) -> None:  # type: ignore[no-untyped-def]
    from matplotlib.colors import ListedColormap

    names = list(ORBITS)
    kind = np.full(found.period.size, names.index("other"))
    kind[(found.period > 0) & (found.interval > 1.5)] = names.index("m > 1")
    for period in (1, 2, 3):
        kind[(found.period == period) & (np.abs(found.interval - 1.0) < 1e-6)] = names.index(f"period {period}")
    kind[found.rested] = names.index("locking")
    colours = ListedColormap([paint(colour) for colour in ORBITS.values()])
    picture = kind.reshape(STARTS, STARTS).T
    axes.imshow(
        picture,
        origin="lower",
        extent=(0.0, 1.0, 0.0, HIGHEST),
        aspect="auto",
        cmap=colours,
        vmin=-0.5,
        vmax=len(names) - 0.5,
        interpolation="nearest",
    )
    label(axes, f"where starts end, restitution {alpha:g}", "τ: phase at the start / 2π", "W: speed / (π g / ω)")
