"""Figure 4.4: two motions of the bar, one that drives the ball away and one that draws it to the centre."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from vr_envs.experiments.experiment import Finding, Outcome, Progress
from vr_envs.experiments.horizontal import PARTIAL, TILT_ACCELERATION, parabolic
from vr_envs.experiments.look import BALL, BAR, label

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KINDS = {"-pi/2": "source", "+pi/2": "sink"}


def bar_motions(progress: Progress) -> Outcome:
    """Figure 4.4: the motions with phi = -pi/2, a source, and phi = +pi/2, a sink."""
    cycle_map = PARTIAL.cycle_map()
    x, rates, columns = 4.0, {}, {}
    turn = np.linspace(0.0, 2.0 * math.pi, 49)
    for name, phase in progress([("-pi/2", -0.5 * math.pi), ("+pi/2", 0.5 * math.pi)], desc="motions"):
        motion = parabolic(cycle_map, x, TILT_ACCELERATION, phase)
        rates[name] = cycle_map.orbit(motion).growth
        parts = motion.reshape(3, 2)
        path = [c * np.cos(k * turn) + s * np.sin(k * turn) for (c, s), k in zip(parts, (1, 1, 2), strict=True)]
        columns[name] = dict(zip(("x_m", "tilt_rad", "z_m"), path, strict=True))
    findings = (
        Finding(
            "phi = -pi/2, tilt counted about +y (positive lowers the right end): gamma",
            "a source: above zero",
            f"{rates['-pi/2']:+.5f}",
            rates["-pi/2"] > 0.0,
        ),
        Finding("phi = +pi/2: gamma", "a sink: below zero", f"{rates['+pi/2']:+.5f}", rates["+pi/2"] < 0.0),
    )

    def draw(figure: Figure) -> None:
        figure.set_size_inches(10.0, 3.4)
        for axes, (name, path) in zip(figure.subplots(1, 2, sharex=True, sharey=True), columns.items(), strict=True):
            axes.plot(1e3 * path["x_m"], 1e3 * path["z_m"], color=BALL)
            for k in range(0, 25, 4):
                centre, tilt = np.array([path["x_m"][k], path["z_m"][k]]), 10.0 * path["tilt_rad"][k]
                along = 1e-4 * np.array([math.cos(tilt), -math.sin(tilt)])
                ends = 1e3 * np.array([centre - along, centre + along])
                axes.plot(*ends.T, color=BAR)
            axes.set_aspect("equal")
            label(axes, f"φ = {name.replace('pi', 'π')}: {KINDS[name]}, γ/ω = {rates[name]:+.4f}", "x (mm)", "z (mm)")
        figure.suptitle(f"Acc_x = {x:g} m/s², path of the bar's centre, tilt drawn ten times as large (Fig 4.4)")

    return Outcome(findings, {KINDS[name]: {"omega_t_rad": turn, **c} for name, c in columns.items()}, draw)
