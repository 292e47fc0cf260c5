"""A run as Bell's vision system saw it, and what he computed from it: fitted parabolas, maxima, minima, phases.

The camera looks at its regions of interest in turn, so at 1000 Hz with two regions ball and bar are each seen at
500 Hz, 1 ms apart (report, section III).
"""

from __future__ import annotations

import dataclasses

import numpy as np

from vr_envs.experiments.trace import Trace

BOUNCE = 0.03  # of a trace's range: less is noise


@dataclasses.dataclass(frozen=True)
class CameraTrace:
    """Ball and bar as the camera saw them: times (s) from the start of the trace, and heights (m)."""

    ball_time: np.ndarray
    ball: np.ndarray
    bar_time: np.ndarray
    bar: np.ndarray


@dataclasses.dataclass(frozen=True)
class Bounces:
    """What fits to a `CameraTrace` give: n parabolas, n maxima, and n - 1 impacts between them.

    `parabolas`: (n, 3) coefficients of (t - centre)^2, (t - centre), 1; `spans`: (n, 2) s, the samples that each fits.
    `minima`: heights (m) at which neighbouring parabolas meet, at `impact_times` (s); `phases`: those of the bar, rad.
    """

    parabolas: np.ndarray
    centres: np.ndarray
    spans: np.ndarray
    maxima: np.ndarray
    impact_times: np.ndarray
    minima: np.ndarray
    phases: np.ndarray

    def parabola(self, i: int, t: np.ndarray) -> np.ndarray:
        """Height (m) of parabola i at times t (s)."""
        return np.polyval(self.parabolas[i], t - self.centres[i])


def as_seen(trace: Trace, regions: int) -> CameraTrace:
    """The samples of a run, taken at the camera's rate, as it shares them among `regions`: ball first, then bar."""
    time = trace.seconds(trace.samples)
    time = time - time[0]
    return CameraTrace(
        time[0::regions], trace.samples["z"][0::regions], time[1::regions], trace.samples["bar_z"][1::regions]
    )


def fitted(seen: CameraTrace, omega: float) -> Bounces:
    """Parabolas through the samples between the lowest ones, and a sine of `omega` (rad/s) through the bar's.

    Raises:
        ValueError: fewer than two whole flights of four samples or more between their lowest ones.
    """
    z, t = seen.ball, seen.ball_time
    lowest = lowest_samples(z)
    # the impact is within one sample of the lowest; that one may belong to either flight
    flights = [(a + 1, b) for a, b in zip(lowest[:-1], lowest[1:], strict=True) if b - a > 4]
    if len(flights) < 2 or len(flights) != len(lowest) - 1:
        raise ValueError(f"{len(lowest)} lowest samples and {len(flights)} flights long enough to fit; sample faster")
    centres = np.array([0.5 * (t[a] + t[b - 1]) for a, b in flights])
    parabolas = np.array([np.polyfit(t[a:b] - c, z[a:b], 2) for (a, b), c in zip(flights, centres, strict=True)])
    meet = np.array(
        [_meeting(parabolas[i : i + 2], centres[i : i + 2], float(t[k])) for i, k in enumerate(lowest[1:-1])]
    )
    return Bounces(
        parabolas,
        centres,
        np.array([(t[a], t[b - 1]) for a, b in flights]),
        parabolas[:, 2] - parabolas[:, 1] ** 2 / (4.0 * parabolas[:, 0]),
        meet,
        np.array([np.polyval(p, x - c) for p, x, c in zip(parabolas, meet, centres, strict=False)]),
        (omega * meet + bar_phase(seen, omega)) % (2.0 * np.pi),
    )


def lowest_samples(z: np.ndarray) -> list[int]:
    """Rows of the lowest samples between bounces: `z` falls to them and rises from them by `BOUNCE` of its range."""
    least = BOUNCE * np.ptp(z)
    rows, falling, turn = [], False, 0
    for k, height in enumerate(z):
        if (height < z[turn]) == falling:
            turn = k  # further on in the same direction
        elif abs(height - z[turn]) > least:
            if falling:
                rows.append(turn)
            falling, turn = not falling, k
    return rows


def bar_phase(seen: CameraTrace, omega: float) -> float:
    """Phase (rad) at time 0 of the sine fitted to the bar's samples."""
    waves = np.column_stack([np.sin(omega * seen.bar_time), np.cos(omega * seen.bar_time), np.ones_like(seen.bar)])
    sin, cos, _ = np.linalg.lstsq(waves, seen.bar, rcond=None)[0]
    return float(np.arctan2(cos, sin))


def _meeting(parabolas: np.ndarray, centres: np.ndarray, near: float) -> float:
    """Where two parabolas meet, nearest to a time."""
    shift = np.poly1d([1.0, -(centres[1] - centres[0])])
    apart = np.poly1d(parabolas[0]) - np.poly1d(parabolas[1])(shift)
    # equal curvatures to rounding leave a root at infinity, which is not the near one
    times = centres[0] + np.real(apart.roots)
    return float(times[np.argmin(np.abs(times - near))])
