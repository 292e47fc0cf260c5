"""What a run of the simulation hands back: impacts, flights between them, apexes, samples, final state."""

from __future__ import annotations

import dataclasses

import numpy as np

from vr_envs.models.ball_on_bar import Params

APEX = np.dtype([("cycle", "i8"), ("time", "f8"), ("x", "f8"), ("z", "f8")])
"""Highest point of a flight between two impacts."""


def flight_times(impacts: np.ndarray, params: Params) -> np.ndarray:
    """Times (s) from each impact to the next along the last axis, rests included; one shorter than `impacts`."""
    return np.diff(impacts["cycle"]) * params.period + np.diff(impacts["time"])


def free_flights(impacts: np.ndarray, params: Params) -> np.ndarray:
    """Whether the flight that impact i began ends at impact i + 1, along the last axis; else the ball rested."""
    first, second = impacts[..., :-1], impacts[..., 1:]
    t = flight_times(impacts, params)
    reached = first["z"] + (first["w_out"] - 0.5 * params.gravity * t) * t
    return np.abs(reached - second["z"]) <= 1e-9 * (np.abs(first["w_out"] * t) + np.abs(first["z"]))


@dataclasses.dataclass(frozen=True, repr=False, eq=False)
class Trace:
    """What happened in a run. `impacts` and `samples` are structured arrays: `trace.impacts["phase"]`.

    Attributes:
        params: of the run.
        impacts: one row each: `cycle` (base cycles since the start of the first run) and `time` in it (s), `phase` of
            the bar's z (rad), `x` and `z` of the ball (m), its velocity after it `u_out`, `w_out` (m/s), and, relative
            to the bar along its normal and tangent, before and after, `normal_in`, `tangent_in`, `normal_out`,
            `tangent_out` (m/s).
        samples: `cycle`, `time`, `x` and `z` of the ball, `bar_x`, `bar_tilt` (rad) and `bar_z`, at `sample_rate`.
        final: a record of the model's `State`, from which another run can go on.
    """

    params: Params
    impacts: np.ndarray
    samples: np.ndarray
    final: np.void

    def __repr__(self) -> str:
        """How much it holds, in one line."""
        told = ", lost" if self.lost else ""
        return f"Trace({len(self.impacts)} impacts, {len(self.samples)} samples{told})"

    @property
    def lost(self) -> bool:
        """Whether the ball left the bar, which ended the run."""
        return bool(self.final["lost"])

    def seconds(self, rows: np.ndarray) -> np.ndarray:
        """Time (s) since the start of the first run of impacts, samples or apexes."""
        return rows["cycle"] * self.params.period + rows["time"]

    @property
    def free(self) -> np.ndarray:
        """(impacts - 1,) bool, see `free_flights`."""
        return free_flights(self.impacts, self.params)

    @property
    def flight_times(self) -> np.ndarray:
        """(impacts - 1,) s, see `flight_times`."""
        return flight_times(self.impacts, self.params)

    @property
    def apexes(self) -> np.ndarray:
        """Highest points of those flights between two impacts that have one: `cycle`, `time` (s), `x`, `z` (m)."""
        rise = self.impacts["w_out"][:-1] / self.params.gravity
        has = self.free & (rise > 0.0) & (rise < self.flight_times)
        start, rise = self.impacts[:-1][has], rise[has]
        rows = np.zeros(len(start), APEX)
        turns, rows["time"] = np.divmod(start["time"] + rise, self.params.period)
        rows["cycle"] = start["cycle"] + turns.astype(int)
        rows["x"] = start["x"] + start["u_out"] * rise
        rows["z"] = start["z"] + 0.5 * self.params.gravity * rise**2
        return rows
