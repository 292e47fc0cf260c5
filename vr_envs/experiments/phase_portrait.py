"""Figure 3.12: impacts in the reduced phase space (tau, W), the exact map, and the spiral that approximates it.

tau is the bar's phase at the impact over 2 pi, W the ball's speed relative to the bar after it over pi g / omega, F
the flight before it in periods. For impacts that end a flight, exactly (Luck and Mehta; primes: after the flight)

    W' = alpha (2 F - W - Gamma cos 2 pi tau + Gamma cos 2 pi tau').

Bell's spiral W' = alpha (n + tau' + Gamma cos 2 pi tau') is this with F = W + Gamma cos 2 pi tau and tau = 0.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vr_envs.experiments.bounce import launches, scaled, vertical, z_omega, z_period
from vr_envs.experiments.experiment import Finding, Outcome, Progress
from vr_envs.experiments.look import BALL, FORMULA, FOUND, label, plain_log
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
RECENT = 100  # impacts: a ball that has rested within as many counts as locked
# (restitution, peak acceleration)
REGIMES = ((0.5, 20.0), (0.75, 15.0), (RESTITUTION, GAMMA * math.pi * Params().gravity), (0.75, 25.0))
LONGEST = 2000  # impacts of a run followed for the portrait
FIRST = 10  # impacts of a run left out of the portrait: they show how it was started
TAU, W = "τ: phase of the impact / 2π", "W: speed relative to the bar / (π g / ω)"
SHOWN = 8000  # points in the picture


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


def transient(params: Params, acceleration: float) -> tuple[np.ndarray, np.ndarray]:
    """Impacts (STARTS, k) and how many of each row (STARTS,) come before the ball first rests on the bar."""
    motions, states = random_starts(params, acceleration)
    impacts, counts, _ = scan(params, motions, states, 0, LONGEST)
    free = free_flights(impacts, params) & (np.arange(1, LONGEST) < counts[:, None])
    return impacts, np.where(free.all(axis=1), LONGEST, 1 + np.argmin(free, axis=1))


class Locking(NamedTuple):
    """How the starts of one regime come to rest on the bar."""

    shares: np.ndarray  # (CHECKS,) of the starts, that have rested within the last `RECENT` impacts
    ever: float  # share that has rested at all
    returns: np.ndarray  # impacts from one rest to the next, all starts together


def locking(params: Params, acceleration: float) -> Locking:
    """Rests over the impacts up to the last of `CHECKS`.

    A ball leaves a rest with the bar's own velocity at the phase arcsin(g / Acc), so in exact arithmetic every rest
    is followed by the same impacts, and `returns` are all equal. Rounding makes them differ where the return takes
    longer than an error of 1e-16 needs to grow to the size of the orbit.
    """
    motions, states = random_starts(params, acceleration)
    impacts, counts, _ = scan(params, motions, states, 0, CHECKS[-1])
    rests = ~free_flights(impacts, params) & (np.arange(1, CHECKS[-1]) < counts[:, None])
    shares = np.array([rests[:, max(0, check - 1 - RECENT) : check - 1].any(axis=1).mean() for check in CHECKS])
    return Locking(shares, float(rests.any(axis=1).mean()), np.concatenate([np.diff(np.flatnonzero(r)) for r in rests]))


def phase_portrait(progress: Progress) -> Outcome:
    """The portrait at `GAMMA`, and how many starts lock with time."""
    params = vertical(FREQUENCY, RESTITUTION)
    acceleration = GAMMA * math.pi * params.gravity
    impacts, lengths = transient(params, acceleration)
    number = np.arange(LONGEST)
    exact = np.concatenate([exact_misfit(r[:n], GAMMA, params) for r, n in zip(impacts, lengths, strict=True)])
    settled = impacts[(number >= FIRST) & (number < lengths[:, None])]
    spiral = spiral_misfit(settled, GAMMA, params)
    tau, speed = reduced(settled, params)
    found = [locking(vertical(FREQUENCY, a), acc) for a, acc in progress(REGIMES, desc="regimes")]
    findings = (
        Finding(
            f"exact map over {exact.size} flights, Gamma {GAMMA:g}, restitution {RESTITUTION:g}",
            "largest residual below 1e-12",
            f"{np.abs(exact).max():.0e}",
            bool(np.abs(exact).max() < 1e-12),
        ),
        Finding(
            "distance of the impacts from Bell's spiral, in W",
            f"approximate: median below {params.restitution / 8:.3f}, half that of points strewn at random",
            f"median {np.median(spiral):.3f}, 9 of 10 below {np.quantile(spiral, 0.9):.3f}",
            bool(np.median(spiral) < 0.5 * params.restitution / 4.0),
        ),
        Finding(
            f"share of {STARTS} starts that have rested on the bar by {LONGEST} impacts",
            "above 90 %: the cloud is a transient, not chaos that lasts (Luck and Mehta)",
            f"{np.mean(lengths < LONGEST):.0%}, half of them by {np.median(lengths):.0f} impacts",
            bool(np.mean(lengths < LONGEST) > 0.9),
        ),
        *(_locking(*regime, parts) for regime, parts in zip(REGIMES, found, strict=True)),
    )
    columns: dict[str, np.ndarray] = {"impacts": np.array(CHECKS)}
    for (alpha, acceleration), parts in zip(REGIMES, found, strict=True):
        columns[f"alpha_{alpha:g}_acceleration_{acceleration:.4g}"] = parts.shares
    tables = {"portrait": {"tau": tau, "W": speed, "spiral_misfit": spiral}, "locked": columns}
    return Outcome(findings, tables, lambda figure: _draw(figure, tau[:SHOWN], speed[:SHOWN], found))


def _locking(alpha: float, acceleration: float, found: Locking) -> Finding:
    """The share locked, and whether the locked orbit repeats."""
    told = ", ".join(f"{share:.0%} by {check}" for check, share in zip(CHECKS, found.shares, strict=True))
    gamma = scaled(acceleration, Params().gravity)
    repeats = len(np.unique(found.returns)) == 1
    if acceleration <= 15.0 or alpha <= 0.5:
        expected = "above 90 % in the end, every rest followed by the same impacts"
        agrees = found.shares[-1] > 0.9 and repeats
    elif gamma < 0.7:
        expected = "all have rested by then, but the return is longer than rounding lets one follow: irregular"
        agrees = found.ever == 1.0 and not repeats
    else:
        expected = "below 10 %: irregular, a transient until shown otherwise"
        agrees = found.shares[-1] < 0.1
    between = f"{found.returns.min()}" if repeats else f"{found.returns.min()} to {found.returns.max()}"
    return Finding(
        f"starts locked (rested in the last {RECENT} impacts), restitution {alpha:g}, {acceleration:.4g} m/s^2 "
        f"(Gamma {gamma:.2f})",
        expected,
        f"{told}; {found.ever:.0%} have rested; {between} impacts between rests",
        bool(agrees),
    )


def _draw(figure: Figure, tau: np.ndarray, speed: np.ndarray, found: list[Locking]) -> None:
    figure.set_size_inches(9.0, 8.0)
    portrait, locked = figure.subplots(2, 1, height_ratios=(3, 1))
    portrait.plot(tau, speed, ".", color=BALL, markersize=1.5, label="impacts before the first rest (transient)")
    line = np.linspace(0.0, 1.0, 400)
    top = float(speed.max())
    for n in range(math.ceil(top / RESTITUTION) + 1):
        spiral = RESTITUTION * (n + line + GAMMA * np.cos(2.0 * math.pi * line))
        portrait.plot(line, spiral, color=FOUND, lw=0.8, label="α (n + τ + Γ cos 2πτ)" if n == 0 else None)
    portrait.set_xlim(0.0, 1.0)
    portrait.set_ylim(0.0, 1.05 * top)
    label(portrait, f"Γ = {GAMMA:g}, restitution {RESTITUTION:g} (Fig 3.12)", TAU, W, legend=True)
    for (alpha, acceleration), parts, style in zip(REGIMES, found, ("-", "--", "-.", ":"), strict=True):
        locked.plot(CHECKS, parts.shares, style, color=FORMULA, label=f"α {alpha:g}, {acceleration:.3g} m/s²")
    plain_log(locked, "x", CHECKS)
    locked.set_ylim(0.0, 1.05)
    label(locked, f"starts that rested in the last {RECENT} impacts", "impacts", "share of the starts", legend=True)
