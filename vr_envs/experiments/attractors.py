"""Where a bouncing ball ends: which orbit it repeats, or that it comes to rest between impacts, or neither yet."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vr_envs.experiments.bounce import launches, z_omega, z_period
from vr_envs.experiments.simulation import scan
from vr_envs.experiments.trace import flight_times, free_flights
from vr_envs.models.ball_on_bar import Params

MOST = 12  # impacts in the longest orbit told from an irregular one
SAME = 1e-7  # rad and relative speed by which two impacts of a repeated orbit may differ


class Ends(NamedTuple):
    """Of each run: what its last impacts show."""

    rested: np.ndarray  # (n,) bool: the ball rested on the bar (locking), or never left it again
    period: np.ndarray  # (n,) impacts after which a bouncing ball repeats; 0: rested, or not within MOST
    interval: np.ndarray  # (n,) mean time between impacts in periods of z: the mode m of a periodic orbit

    def share(self, period: int, interval: float) -> float:
        """Share of the runs that repeat after `period` impacts at this mean interval."""
        return float(np.mean((self.period == period) & (np.abs(self.interval - interval) < 1e-6)))


def recurrence(impacts: np.ndarray) -> np.ndarray:
    """Impacts after which rows (n, k) repeat: the smallest number up to `MOST`, or 0 if there is none."""
    phase, speed = impacts["phase"], impacts["normal_out"]
    found = np.zeros(len(impacts), int)
    for lag in range(MOST, 0, -1):
        turned = np.abs(np.angle(np.exp(1j * (phase[:, lag:] - phase[:, :-lag]))))
        moved = np.abs(speed[:, lag:] - speed[:, :-lag])
        same = (turned <= SAME).all(axis=1) & (moved <= SAME * speed[:, lag:].max(axis=1)[:, None]).all(axis=1)
        found[same] = lag
    return found


def ends(impacts: np.ndarray, counts: np.ndarray, params: Params) -> Ends:
    """What the impacts (n, k) and counts (n,) that a `scan` kept show."""
    rested = (counts < impacts.shape[1]) | ~free_flights(impacts, params).all(axis=1)
    interval = flight_times(impacts, params).mean(axis=1) / z_period(params)
    period = np.where(rested, 0, recurrence(impacts))
    for p in np.unique(period[period > 0]):
        rows = period == p
        interval[rows] = flight_times(impacts[rows][:, -p - 1 :], params).sum(axis=1) / p / z_period(params)
    return Ends(rested, period, np.where(rested, np.nan, interval))


def grid_of_starts(
    params: Params, acceleration: float, n: int, highest: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """n x n starts over phase and relative speed: (motions, states, tau (n,), W (n,)).

    tau is the phase over 2 pi, W the speed relative to the bar over pi g / omega, up to `highest` (Luck and Mehta).
    """
    tau, speed = (np.arange(n) + 0.5) / n, highest * (np.arange(n) + 0.5) / n
    phases, speeds = (a.ravel() for a in np.meshgrid(2.0 * np.pi * tau, speed, indexing="ij"))
    unit = np.pi * params.gravity / z_omega(params)
    return *launches(params, acceleration, phases, speeds * unit), tau, speed


def ends_of_starts(
    params: Params, motions: np.ndarray, states: np.ndarray, skip: int, keep: int
) -> tuple[Ends, np.ndarray, np.ndarray]:
    """Where starts end after `skip` base cycles: (ends, impacts kept (n, keep), final states)."""
    kept, counts, finals = scan(params, motions, states, skip, keep)
    return ends(kept, counts, params), kept, finals
