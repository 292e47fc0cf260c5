"""What the figures and tables of periodic bounces (3.1 to 3.7) share: setting, camera trace, fits, tables, picture."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

import numpy as np

from vr_envs.experiments.attractors import MOST, ends
from vr_envs.experiments.bounce import (
    orbit_phases,
    period_one_apex,
    period_one_launch,
    period_one_phase,
    vertical,
    z_omega,
    z_period,
)
from vr_envs.experiments.camera_trace import Bounces, CameraTrace, as_seen, fitted
from vr_envs.experiments.experiment import Finding, Outcome
from vr_envs.experiments.look import BALL, BAR, FAINT, FOUND, label
from vr_envs.experiments.orbit_noise import deviations
from vr_envs.experiments.simulation import scan, simulate
from vr_envs.models.ball_on_bar import Params
from vr_envs.models.ball_options import Scatter

if TYPE_CHECKING:
    from matplotlib.figure import Figure, SubFigure

SETTLE = 2000  # base cycles after which the slowest orbit shown here has settled to rounding
SECONDS = 1.0  # length of Bell's traces
SCATTER = 5e-4  # of the restitution from impact to impact; ten times as much throws the ball out of period two
LONG = 1000.0  # s over which the scattered ball is watched


@dataclasses.dataclass(frozen=True)
class Setting:
    """One of Bell's settings: frequency (Hz) and peak acceleration (m/s^2) of z, mode, camera rate (Hz) and regions."""

    frequency: float
    acceleration: float
    m: int
    rate: float
    regions: int

    def settled(self, restitution: float) -> tuple[Params, np.ndarray, np.void]:
        """Parameters, motion and the state after a start near period one has settled."""
        params = vertical(self.frequency, restitution)
        motions, starts = period_one_launch(params, self.acceleration, self.m, nudge=1e-3)
        _, _, finals = scan(params, motions, starts, SETTLE, 1)
        return params, motions[0], finals[0]

    def seen(self, params: Params, motion: np.ndarray, start: np.void | np.ndarray) -> tuple[CameraTrace, Bounces]:
        """One second of camera trace from `start`, with half a flight more on either side, and its fits."""
        cycles = math.ceil((SECONDS + 4 * self.m * z_period(params)) * params.frequency)
        trace = simulate(params, motion, start, cycles, sample_rate=self.rate)
        seen = as_seen(trace, self.regions)
        return seen, fitted(seen, z_omega(params))

    def repeats(self, restitution: float) -> tuple[int, float]:
        """After how many impacts the settled ball repeats, and the mean periods of z between impacts."""
        params, motion, start = self.settled(restitution)
        kept, counts, _ = scan(params, motion, start, 0, 4 * MOST)
        found = ends(kept, counts, params)
        return int(found.period[0]), float(found.interval[0])


def in_a_second(bounces: Bounces) -> slice:
    """The impacts of the first second from the first one on."""
    since = bounces.impact_times - bounces.impact_times[0]
    return slice(0, int(np.searchsorted(since, SECONDS - 1e-6)))


def table(bounces: Bounces) -> dict[str, np.ndarray]:
    """Bell's tables 3.1 and 3.2: one row per impact, with the maximum of the flight that follows it."""
    rows = in_a_second(bounces)
    return {
        "impact": np.arange(1, rows.stop + 1),
        "maximum_mm": 1e3 * bounces.maxima[1:][rows],
        "minimum_mm": 1e3 * bounces.minima[rows],
        "phase_rad": bounces.phases[rows],
    }


def trace_table(seen: CameraTrace) -> dict[str, np.ndarray]:
    """The samples."""
    n = min(len(seen.ball), len(seen.bar))
    return {
        "ball_time_ms": 1e3 * seen.ball_time[:n],
        "ball_mm": 1e3 * seen.ball[:n],
        "bar_time_ms": 1e3 * seen.bar_time[:n],
        "bar_mm": 1e3 * seen.bar[:n],
    }


def statistics(parts: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Mean and standard deviation of every column of `parts`, named by them."""
    return {
        "what": np.array(list(parts)),
        "mean": np.array([np.mean(v) for v in parts.values()]),
        "std": np.array([np.std(v, ddof=1) for v in parts.values()]),
    }


def scattered(
    setting: Setting, settled: tuple[Params, np.ndarray, np.void], period: int
) -> tuple[np.ndarray, np.ndarray]:
    """`LONG` with a restitution scattered by `SCATTER`: standard deviations found, and those of the linearised map.

    Both (period, 3): a row for each impact of the orbit, of maximum (mm), minimum (mm) and phase (rad).
    """
    params, motion, start = settled
    cycles = math.ceil(LONG * params.frequency)
    impacts = simulate(params, motion, start, cycles, {"scatter": Scatter(SCATTER, 0.0)}).impacts[:-1]
    top = impacts["z"] + impacts["w_out"] ** 2 / (2.0 * params.gravity)
    columns = np.array([1e3 * top, 1e3 * impacts["z"], impacts["phase"]])
    found = np.array([columns[:, i::period].std(axis=1, ddof=1) for i in range(period)])
    guess, counts = [columns[2, i::period].mean() for i in range(period)], [setting.m] * period
    phases = orbit_phases(guess, counts, setting.acceleration, params)
    return found, deviations(phases, counts, setting.acceleration, params, SCATTER) * [1e3, 1e3, 1.0]


def draw_trace(figure: Figure | SubFigure, seen: CameraTrace, bounces: Bounces, title: str, top: float) -> None:
    """Bell's pair of pictures: the trace as captured, and the fits with their maxima and minima.

    It shows `SECONDS` from half a flight before the first impact on, up to the height `top` (mm) of Bell's axis.
    """
    above, below = figure.subplots(2, 1, sharex=True)
    begin = 1e3 * (bounces.impact_times[0] - 0.5 * (bounces.impact_times[1] - bounces.impact_times[0]))
    ball_time, bar_time = 1e3 * seen.ball_time - begin, 1e3 * seen.bar_time - begin
    above.plot(ball_time, 1e3 * seen.ball, color=BALL, marker=".", markersize=3, lw=0.6, label="ball")
    above.plot(bar_time, 1e3 * seen.bar, color=BAR, marker=".", markersize=3, lw=0.6, label="bar")
    above.set_xlim(0.0, 1e3 * SECONDS)
    above.set_ylim(top=top)
    label(above, title, "", "height (mm)", legend=True)
    below.set_ylim(*above.get_ylim())
    below.plot(ball_time, 1e3 * seen.ball, ".", color=BALL, markersize=3, label="ball")
    below.plot(bar_time, 1e3 * seen.bar, color=BAR, lw=0.8, label="bar")
    for i, (first, last) in enumerate(bounces.spans):
        t = np.linspace(first, last, 40)
        below.plot(
            1e3 * t - begin,
            1e3 * bounces.parabola(i, t),
            color=FAINT,
            lw=0.8,
            label="fitted parabolas" if not i else None,
        )
    highest = bounces.centres - bounces.parabolas[:, 1] / (2.0 * bounces.parabolas[:, 0])
    below.plot(1e3 * highest - begin, 1e3 * bounces.maxima, "^", color=FOUND, markersize=4, label="maxima")
    below.plot(1e3 * bounces.impact_times - begin, 1e3 * bounces.minima, "v", color=FOUND, markersize=4, label="minima")
    label(below, "maxima and minima calculated from the fits", "time (ms)", "height (mm)", legend=True)


def near(found: float, expected: float, within: float) -> bool:
    """Whether two numbers differ by at most `within`."""
    return abs(found - expected) <= within


def one_findings(setting: Setting, params: Params, bounces: Bounces) -> list[Finding]:
    """Period one of mode m against the closed forms."""
    rows = in_a_second(bounces)
    phase = period_one_phase(setting.acceleration, setting.m, params)
    apex = 1e3 * period_one_apex(setting.acceleration, setting.m, params)
    bounce = 1e3 * params.gravity * (setting.m * z_period(params)) ** 2 / 8.0
    size = 1e3 * setting.acceleration / z_omega(params) ** 2
    phases, tops = bounces.phases[rows], 1e3 * bounces.maxima[rows]
    mean_bounce = float(np.mean(tops) - np.mean(1e3 * bounces.minima[rows]))
    return [
        Finding(
            "impacts in one second",
            f"{setting.frequency / setting.m:g}",
            str(rows.stop),
            rows.stop == round(setting.frequency / setting.m),
        ),
        Finding(
            "phase at impact, mean of the fits",
            f"{phase:.4f} rad (closed form), within 1e-6 rad",
            f"{phases.mean():.7f} rad, std {phases.std(ddof=1):.0e} rad",
            near(float(phases.mean()), phase, 1e-6),
        ),
        Finding(
            "maximum, mean of the fits",
            f"{apex:.4f} mm = A sin(phase) + g (mT)^2/8, A = {size:.4f} mm, within 1e-6 mm",
            f"{tops.mean():.7f} mm, std {tops.std(ddof=1):.0e} mm",
            near(float(tops.mean()), apex, 1e-6),
        ),
        Finding(
            "height of bounce above the impact",
            f"{bounce:.4f} mm = g (mT)^2/8, within 1e-6 mm",
            f"{mean_bounce:.7f} mm",
            near(mean_bounce, bounce, 1e-6),
        ),
    ]


def outcome_of(
    setting: Setting,
    settled: tuple[Params, np.ndarray, np.void],
    seen: CameraTrace,
    bounces: Bounces,
    findings: list[Finding],
    parts: dict[str, np.ndarray],
    period: int,
    title: str,
    top: float,
) -> Outcome:
    """The outcome of one setting: `findings` and those of a scattered restitution; `parts` go into the statistics.

    `title` and `top` are those of `draw_trace`.
    """
    found, expected = scattered(setting, settled, period)
    findings.append(
        Finding(
            f"{LONG:g} s with a restitution scattered by {SCATTER:g}: std of maximum, minimum, phase",
            f"{_told(expected)}, within 5 % (linearised map); the digits of Bell's are lost",
            _told(found),
            bool((np.abs(found / expected - 1.0) < 0.05).all()),
        )
    )
    tables = {"impacts": table(bounces), "statistics": statistics(parts), "trace": trace_table(seen)}
    return Outcome(tuple(findings), tables, lambda figure: draw_trace(figure, seen, bounces, title, top))


def _told(rows: np.ndarray) -> str:
    return "; ".join(f"{1e3 * top:.3g} µm, {1e3 * low:.3g} µm, {1e3 * phase:.3g} mrad" for top, low, phase in rows)


def halves(bounces: Bounces) -> dict[str, np.ndarray]:
    """The columns of the table apart for odd and even impacts, the lower bounce first."""
    columns = {k: v for k, v in table(bounces).items() if k != "impact"}
    first_low = columns["maximum_mm"][0] < columns["maximum_mm"][1]
    order = ("odds", "evens") if first_low else ("evens", "odds")
    start = {"odds": 0, "evens": 1}
    return {f"{name}_{part}": values[start[part] :: 2] for part in order for name, values in columns.items()}


def two_findings(setting: Setting, params: Params, bounces: Bounces) -> list[Finding]:
    """Period two of mode m against the orbit's equations."""
    rows = in_a_second(bounces)
    phases, tops = bounces.phases[rows], bounces.maxima[1:][rows]
    high = tops > tops.mean()
    found = np.array([phases[high].mean(), phases[~high].mean()])
    expected = orbit_phases(found, [setting.m, setting.m], setting.acceleration, params)
    flights = setting.frequency / setting.m
    return [
        Finding(
            "bounces in one second, high and low",
            f"{flights / 2:g} and {flights / 2:g}",
            f"{high.sum()} and {(~high).sum()}",
            bool(high.sum() == (~high).sum() == round(flights / 2)),
        ),
        Finding(
            "phases at impact before the high and the low bounce, means of the fits",
            f"{expected[0]:.4f} and {expected[1]:.4f} rad (orbit's equations), within 1e-6 rad",
            f"{found[0]:.7f} and {found[1]:.7f} rad",
            bool(np.abs(found - expected).max() < 1e-6),
        ),
        Finding(
            "which phase launches the higher bounce",
            "the smaller (Bell)",
            "the smaller" if found[0] < found[1] else "the larger",
            bool(found[0] < found[1]),
        ),
    ]
