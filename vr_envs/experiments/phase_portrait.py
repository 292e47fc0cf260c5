"""Figure 3.12: impacts in the reduced phase space (tau, W), the exact map, and the spiral that approximates it.

tau is the bar's phase at the impact over 2 pi, W the ball's speed relative to the bar after it over pi g / omega, F
the flight before it in periods. For impacts that end a flight, exactly (Luck and Mehta; primes: after the flight)

    W' = alpha (2 F - W - Gamma cos 2 pi tau + Gamma cos 2 pi tau').

Bell's spiral W' = alpha (n + tau' + Gamma cos 2 pi tau') is this with F = W + Gamma cos 2 pi tau and tau = 0.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from vr_envs.experiments.bounce import launches, scaled, vertical, z_omega, z_period
from vr_envs.experiments.experiment import Finding, Outcome, Progress
from vr_envs.experiments.look import BALL, FORMULA, FOUND, label
from vr_envs.experiments.simulation import scan
from vr_envs.experiments.trace import flight_times, free_flights
from vr_envs.models.ball_on_bar import Params

if TYPE_CHECKING:
    from matplotlib.figure import Figure

GAMMA, RESTITUTION = 0.65, 0.75  # Bell's value of Gamma is lost
FREQUENCY = 20.0  # Hz; a scale
STARTS, SEED = 300, 1
HIGHEST = 3.0  # W of the fastest start
CHECKS = (125, 250, 500, 1000, 2000, 4000)  # impacts
# (restitution, peak acceleration): shares locked after 4000 impacts, to be compared
REGIMES = ((0.5, 20.0), (0.75, 15.0), (RESTITUTION, GAMMA * math.pi * Params().gravity), (0.75, 25.0))
SHOWN = 6000  # points in the picture


def random_starts(params: Params, acceleration: float) -> tuple[np.ndarray, np.ndarray]:
    """Motions and states of `STARTS` launches, uniform in tau and W."""
    rng = np.random.default_rng(SEED)
    phases = rng.uniform(0.0, 2.0 * math.pi, STARTS)
    speeds = rng.uniform(0.0, HIGHEST, STARTS) * math.pi * params.gravity / z_omega(params)
    return launches(params, acceleration, phases, speeds)


def reduced(impacts: np.ndarray, params: Params) -> tuple[np.ndarray, np.ndarray]:
    """(tau, W) of impacts."""
    return impacts["phase"] / (2.0 * math.pi), impacts["normal_out"] * z_omega(params) / (math.pi * params.gravity)


def exact_misfit(impacts: np.ndarray, gamma: float, params: Params) -> np.ndarray:
    """Residual of the exact map for each flight without rest, along rows of impacts, as one flat array."""
    tau, speed = reduced(impacts, params)
    swing = gamma * np.cos(2.0 * math.pi * tau)
    flight = flight_times(impacts, params) / z_period(params)
    mapped = params.restitution * (2.0 * flight - speed[..., :-1] - swing[..., :-1] + swing[..., 1:])
    return (speed[..., 1:] - mapped)[free_flights(impacts, params)]


def spiral_misfit(impacts: np.ndarray, gamma: float, params: Params) -> np.ndarray:
    """Distance in W of each impact from the nearest turn of Bell's spiral."""
    tau, speed = reduced(impacts, params)
    turns = speed / params.restitution - tau - gamma * np.cos(2.0 * math.pi * tau)
    return params.restitution * np.abs(turns - np.maximum(0.0, np.round(turns)))


def locked_shares(params: Params, acceleration: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Share of the starts that have rested on the bar by each of `CHECKS` impacts.

    Returns:
        The shares, the impacts of the last stretch (STARTS, k), and which starts (STARTS,) had rested by its end.
    """
    motions, states = random_starts(params, acceleration)
    rested = np.zeros(STARTS, bool)
    shares, impacts, before = [], np.empty(0), 0
    for check in CHECKS:
        impacts, counts, states = scan(params, motions, states, 0, check - before)
        rested |= (counts < check - before) | ~free_flights(impacts, params).all(axis=1)
        shares.append(rested.mean())
        before = check
    return np.array(shares), impacts, rested


def phase_portrait(progress: Progress) -> Outcome:
    """The portrait at `GAMMA`, and how many starts lock with time."""
    shares, shown = [], None
    for alpha, acceleration in progress(REGIMES, desc="regimes"):
        params = vertical(FREQUENCY, alpha)
        share, impacts, rested = locked_shares(params, acceleration)
        shares.append(share)
        if (alpha, acceleration) == REGIMES[2]:
            shown = params, impacts[~rested], rested
    assert shown is not None
    params, impacts, rested = shown
    exact = exact_misfit(impacts, GAMMA, params)
    spiral = spiral_misfit(impacts, GAMMA, params)
    tau, speed = (a.ravel()[:SHOWN] for a in reduced(impacts, params))
    findings = (
        Finding(
            f"exact map over {exact.size} flights, Gamma {GAMMA:g}, restitution {RESTITUTION:g}",
            "largest residual below 1e-12",
            f"{np.abs(exact).max():.0e}",
            bool(np.abs(exact).max() < 1e-12),
        ),
        Finding(
            "distance of the impacts from Bell's spiral, in W",
            f"approximate: median well below {params.restitution / 4:.3f}, that of points strewn at random",
            f"median {np.median(spiral):.3f}, 9 of 10 below {np.quantile(spiral, 0.9):.3f}",
            bool(np.median(spiral) < 0.5 * params.restitution / 4.0),
        ),
        Finding(
            f"starts still irregular after {CHECKS[-1]} impacts",
            "labelled transient: more of them lock, the longer they run (Luck and Mehta)",
            f"{np.count_nonzero(~rested)} of {STARTS}",
            bool((np.diff(shares[2]) >= 0.0).all()),
        ),
        *(_locking(alpha, acceleration, share) for (alpha, acceleration), share in zip(REGIMES, shares, strict=True)),
    )
    columns: dict[str, np.ndarray] = {"impacts": np.array(CHECKS)}
    for (alpha, acceleration), share in zip(REGIMES, shares, strict=True):
        columns[f"alpha_{alpha:g}_acceleration_{acceleration:.4g}"] = share
    tables = {"portrait": {"tau": tau, "W": speed, "spiral_misfit": spiral.ravel()[:SHOWN]}, "locked": columns}
    return Outcome(findings, tables, lambda figure: _draw(figure, tau, speed, shares))


def _locking(alpha: float, acceleration: float, shares: np.ndarray) -> Finding:
    """The share locked, against the number in the report's references where there is one."""
    told = ", ".join(f"{share:.0%} by {check}" for check, share in zip(CHECKS, shares, strict=True))
    gamma = scaled(acceleration, Params().gravity)
    few = alpha > 0.5 and acceleration > 16.0
    return Finding(
        f"starts locked, restitution {alpha:g}, {acceleration:.4g} m/s^2 (Gamma {gamma:.2f}), by number of impacts",
        "below half: the transient is long" if few else "nearly all",
        told,
        bool(shares[-1] < 0.5) if few else bool(shares[-1] > 0.9),
    )


def _draw(figure: Figure, tau: np.ndarray, speed: np.ndarray, shares: list[np.ndarray]) -> None:
    figure.set_size_inches(9.0, 8.0)
    portrait, locked = figure.subplots(2, 1, height_ratios=(3, 1))
    portrait.plot(tau, speed, ".", color=BALL, markersize=1.5, label="impacts (transient, not locked by then)")
    line = np.linspace(0.0, 1.0, 400)
    top = float(speed.max())
    for n in range(math.ceil(top / RESTITUTION) + 1):
        spiral = RESTITUTION * (n + line + GAMMA * np.cos(2.0 * math.pi * line))
        portrait.plot(line, spiral, color=FOUND, lw=0.8, label="α (n + τ + Γ cos 2πτ)" if n == 0 else None)
    portrait.set_xlim(0.0, 1.0)
    portrait.set_ylim(0.0, 1.05 * top)
    label(portrait, f"Γ = {GAMMA:g}, restitution {RESTITUTION:g} (Fig 3.12)", "τ", "W", legend=True)
    for (alpha, acceleration), share, style in zip(REGIMES, shares, ("-", "--", "-.", ":"), strict=True):
        locked.semilogx(CHECKS, share, style, color=FORMULA, label=f"α {alpha:g}, {acceleration:.3g} m/s²")
    locked.set_ylim(0.0, 1.05)
    label(locked, "share locked", "impacts", "", legend=True)
