"""The aircraft by scipy's adaptive integrators."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from vr_envs.bench.accuracy.autopilot_loops import air_of, commands, corner_times, slopes, state_of, write_state
from vr_envs.bench.accuracy.autopilot_reference import SEEN
from vr_envs.models.jit import bound, kernel


@kernel
def slopes_at(y, held, lags, wind, shear, air):
    """`slopes` at an array y; `held`: the rates' goals and slews."""
    goals, slews = (held[0], held[1], held[2]), (held[3], held[4], held[5])
    return slopes((y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7]), goals, slews, lags, wind, shear, air)


def integrated(
    start: np.void, actions: np.ndarray, params: np.void, options: tuple[Any, ...], method: str, tolerance: float
) -> Callable[[], np.ndarray]:
    """Work that flies the episode by `solve_ivp`, restarted at control instants and corners, and returns what is seen.

    That is `SEEN` after each interval, (intervals, 5), not numbers if scipy gives up. `options`: records of envelope,
    energy, lags, wind, shear, or None. The tolerance is relative, and the absolute one in SI units is the same number.
    The right-hand side is compiled, and has its arguments converted beforehand.
    """
    envelope, energy, lags, wind, shear = options
    place, held = np.empty(8), np.empty(6)
    slopes_there = bound(slopes_at, place, held, lags, wind, shear, air_of(wind, shear))

    def rates(_: float, at: np.ndarray) -> tuple[float, ...]:
        place[:] = at
        return slopes_there()

    def work() -> np.ndarray:
        state, seen = start.copy(), np.full((len(actions), len(SEEN)), np.nan)
        for row, action in zip(seen, actions, strict=True):
            goals, slews = commands(state, action, params, envelope, energy, lags)
            y = state_of(state, goals, lags)
            held[:] = *goals, *slews
            corners = [c for c in corner_times(y, goals, slews, lags) if 0.0 < c < params["dt"]]
            places = [0.0, *sorted(corners), float(params["dt"])]
            for begin, end in zip(places, places[1:], strict=False):
                found = solve_ivp(rates, (begin, end), y, method, rtol=tolerance, atol=tolerance)
                if not found.success:
                    return seen
                y = found.y[:, -1]
            write_state(state, y)
            row[:] = [state[name] for name in SEEN]
        return seen

    return work
