"""How far a periodic bounce strays when the restitution scatters, by the linearised map from impact to impact.

The state at an impact is (phase of z, velocity just after it). With U the bar's velocity, a its acceleration, v^- the
ball's just before the next impact, the derivative of the flight is that of z = A sin(phase) at both its ends,

    U_i dphase_i / omega + s dv_i + v^- ds = U_{i+1} (dphase_i / omega + ds),      dphase_{i+1} = dphase_i + omega ds,

and of the impact  dv_{i+1} = (1 + alpha) a_{i+1} dphase_{i+1} / omega - alpha dv^- + (U_{i+1} - v^-) dalpha.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import solve_discrete_lyapunov

from vr_envs.experiments.bounce import z_omega
from vr_envs.models.ball_on_bar import Params


def impact_maps(
    phases: Sequence[float] | np.ndarray, counts: Sequence[int], acceleration: float, params: Params
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of an orbit of p impacts (see `bounce.orbit_phases`), from each impact to the next.

    Returns:
        Derivatives (p, 2, 2) of (phase, velocity), of the next impact by this one; those by the restitution of the next
        impact (p, 2); and the velocities (p,) just after the impacts, m/s.
    """
    omega, alpha, g = z_omega(params), params.restitution, params.gravity
    phases = np.asarray(phases, float)
    size = acceleration / omega**2
    after = np.roll(phases, -1)
    flight = (2.0 * np.pi * np.asarray(counts) + after - phases) / omega
    out = size * (np.sin(after) - np.sin(phases)) / flight + 0.5 * g * flight
    back = out - g * flight
    bar, bar_next = size * omega * np.cos(phases), size * omega * np.cos(after)
    speed = bar_next - back
    later = np.array([(bar - bar_next) / omega, flight]) / speed  # ds by (phase, velocity)
    turned = omega * later + [[1.0], [0.0]]
    pushed = -(1.0 + alpha) * size * omega * np.sin(after) * turned - alpha * (-g * later + [[0.0], [1.0]])
    by_alpha = np.column_stack([np.zeros(len(phases)), speed])
    return np.moveaxis(np.array([turned, pushed]), 2, 0), by_alpha, out


def deviations(
    phases: Sequence[float] | np.ndarray, counts: Sequence[int], acceleration: float, params: Params, scatter: float
) -> np.ndarray:
    """Standard deviations (p, 3) of maximum (m), minimum (m) and phase (rad) at the impacts of an orbit.

    To first order in `scatter`, the standard deviation of the restitution from impact to impact. The maximum is that of
    the flight that begins at the impact.
    """
    maps, by_alpha, out = impact_maps(phases, counts, acceleration, params)
    kicks = scatter**2 * np.einsum("ij,ik->ijk", by_alpha, by_alpha)
    turn, gained = np.eye(2), np.zeros((2, 2))
    for one, kick in zip(maps, kicks, strict=True):
        turn, gained = one @ turn, one @ gained @ one.T + kick
    spread = solve_discrete_lyapunov(turn, gained)
    rows = []
    for one, kick, phase, velocity in zip(maps, kicks, phases, out, strict=True):
        lifted = acceleration / z_omega(params) ** 2 * np.cos(phase)
        top = np.array([lifted, velocity / params.gravity])
        rows.append((np.sqrt(top @ spread @ top), abs(lifted) * np.sqrt(spread[0, 0]), np.sqrt(spread[0, 0])))
        spread = one @ spread @ one.T + kick
    return np.array(rows)
