"""The aircraft by scipy's adaptive integrators."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from vr_envs.bench.accuracy.autopilot_loops import commands, corner_times, slopes, state_of, write_state


def integrate(
    state: Any, action: np.ndarray, params: Any, options: tuple[Any, ...], method: str, tolerance: float
) -> None:
    """Move `state` over a control interval by scipy's `solve_ivp`, restarted at the corners.

    `options`: records of envelope, energy, lags, wind, shear, or None. The tolerance is relative, and the absolute
    one in SI units is the same number; the right-hand side is compiled.
    """
    envelope, energy, lags, wind, shear = options
    goals, slews = commands(state, action, params, envelope, energy, lags)
    y = state_of(state, goals, lags)
    corners = [c for c in corner_times(y, goals, slews, lags) if 0.0 < c < params["dt"]]
    places = [0.0, *sorted(corners), float(params["dt"])]
    for begin, end in zip(places, places[1:], strict=False):
        found = solve_ivp(
            lambda _, at: slopes(at, goals, slews, lags, wind, shear), (begin, end), y, method,
            rtol=tolerance, atol=tolerance,
        )  # fmt: skip
        y = found.y[:, -1]
    write_state(state, y)
