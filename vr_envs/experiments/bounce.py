"""Closed forms of a ball that bounces on a bar moving up and down only, z = A sin(omega t), and its scaled units.

Sources: Bell (bouncing-ball report), section III; Luck and Mehta 1993. Everything is a function of the frequency of z,
which is twice the base frequency. A mode (n, m) repeats after n impacts, each after m periods of z in the mean.
Accelerations are peak values A omega^2, m/s^2. Only Gamma = A omega^2 / (pi g) and the restitution matter; the
frequency is a scale.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from vr_envs.experiments.simulation import ball, bar_motion
from vr_envs.models.ball_on_bar import Params

NEWTON_STEPS = 50
Scalars = TypeVar("Scalars", float, np.ndarray)


def vertical(frequency: float, restitution: float) -> Params:
    """A bar whose z moves at `frequency` (Hz)."""
    return Params(frequency=0.5 * frequency, restitution=restitution)


def z_omega(params: Params) -> float:
    """Angular frequency of z, rad/s."""
    return 2.0 * params.omega


def z_period(params: Params) -> float:
    """Period of z, s."""
    return 0.5 * params.period


def scaled(acceleration: Scalars, gravity: float) -> Scalars:
    """Gamma of Luck and Mehta. Bell prints A omega^2 / pi g."""
    return acceleration / (math.pi * gravity)


def lower_bound(m: int, params: Params) -> float:
    """Peak acceleration from which period one of mode m exists: pi g m (1 - alpha) / (1 + alpha)."""
    return math.pi * params.gravity * m * (1.0 - params.restitution) / (1.0 + params.restitution)


def upper_bound(m: int, params: Params) -> float:
    """Peak acceleration at which period one of mode m flips into period two."""
    alpha = params.restitution
    return math.hypot(lower_bound(m, params), 2.0 * params.gravity * (1.0 + alpha**2) / (1.0 + alpha) ** 2)


def period_one_phase(acceleration: float, m: int, params: Params) -> float:
    """Phase of the impact in stable period one, rad in [0, pi/2).

    Raises:
        ValueError: the acceleration is below the lower bound.
    """
    least = lower_bound(m, params)
    if acceleration < least:
        raise ValueError(f"period one with m = {m} needs a peak acceleration of {least:.4g} m/s^2; got {acceleration}")
    return math.acos(least / acceleration)


def period_one_apex(acceleration: float, m: int, params: Params) -> float:
    """Highest point of the ball in period one above the bar's mean position, m."""
    size = acceleration / z_omega(params) ** 2
    flight = m * z_period(params)
    return size * math.sin(period_one_phase(acceleration, m, params)) + params.gravity * flight**2 / 8.0


def restitution_of_phase(acceleration: float, phase: float, m: int, gravity: float) -> float:
    """The restitution with which period one has this phase."""
    need, push = math.pi * m * gravity, acceleration * math.cos(phase)
    return (need - push) / (need + push)


def orbit_residual(
    phases: Sequence[float] | np.ndarray,
    counts: Sequence[int],
    acceleration: float,
    restitution: float,
    gravity: float,
    omega: float,
) -> np.ndarray:
    """How far phases of impact are from a periodic orbit: v_i - (1 + alpha) U_i + alpha v_i^-, over g T.

    `counts[i]`: periods of z between impact i and the next, by number of the period in which they lie. The heights of
    two impacts and the time between them give the velocities.
    """
    phases = np.asarray(phases, float)
    size = acceleration / omega**2
    flight = (2.0 * math.pi * np.asarray(counts) + np.roll(phases, -1) - phases) / omega
    height = size * np.sin(phases)
    out = (np.roll(height, -1) - height) / flight + 0.5 * gravity * flight
    back = np.roll(out - gravity * flight, 1)
    push = size * omega * np.cos(phases)
    return (out - (1.0 + restitution) * push + restitution * back) / (gravity * 2.0 * math.pi / omega)


def newton(function, guess: Sequence[float] | np.ndarray) -> np.ndarray:
    """Root of a smooth function R^n -> R^n near `guess`, by Newton's method with central differences.

    Raises:
        ArithmeticError: it does not converge.
    """
    x = np.array(guess, float)
    for _ in range(NEWTON_STEPS):
        h = 1e-6 * np.maximum(1.0, np.abs(x))
        slope = np.column_stack([(function(x + d) - function(x - d)) / (2.0 * d.max()) for d in np.diag(h)])
        step = np.linalg.solve(slope, function(x))
        x = x - step
        if np.abs(step).max() < 1e-13 * np.abs(x).max():
            return x
    raise ArithmeticError(f"no root found near {list(guess)}")


def orbit_phases(
    guess: Sequence[float] | np.ndarray, counts: Sequence[int], acceleration: float, params: Params
) -> np.ndarray:
    """Phases of the periodic orbit near `guess`, from the equations of motion alone."""
    args = counts, acceleration, params.restitution, params.gravity, z_omega(params)
    return newton(lambda phases: orbit_residual(phases, *args), guess)


def orbit_apexes(
    phases: Sequence[float] | np.ndarray, counts: Sequence[int], acceleration: float, params: Params
) -> np.ndarray:
    """Highest point (m) above the bar's mean position of the flight after each impact of an orbit."""
    omega = z_omega(params)
    height = acceleration / omega**2 * np.sin(phases)
    flight = (2.0 * np.pi * np.asarray(counts) + np.roll(phases, -1) - phases) / omega
    out = (np.roll(height, -1) - height) / flight + 0.5 * params.gravity * flight
    return height + out**2 / (2.0 * params.gravity)


def launches(
    params: Params, accelerations: np.ndarray | float, phases: np.ndarray | float, speeds: np.ndarray | float
) -> tuple[np.ndarray, np.ndarray]:
    """Starts from the bar's surface: (motions (n, 6), states (n,)) for `scan`.

    Args:
        params: of the bar.
        accelerations: peak accelerations of z, m/s^2.
        phases: of z at the start, rad.
        speeds: of the ball relative to the bar, m/s.
    """
    rows = np.broadcast_arrays(*(np.atleast_1d(np.asarray(a, float)) for a in (accelerations, phases, speeds)))
    motions = bar_motion(params, z=rows[0], z_phase=rows[1])
    states = np.repeat(ball(motions[0]), len(motions))
    states["motion"] = motions
    states["z"] = motions[:, 4]
    states["w"] = z_omega(params) * motions[:, 5] + rows[2]
    return motions, states


def period_one_launch(
    params: Params, accelerations: np.ndarray | float, m: int, nudge: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """`launches` on period one of mode m, at phase 0 where it does not exist; the speed is `nudge` (m/s) off."""
    accelerations = np.atleast_1d(np.asarray(accelerations, float))
    least = lower_bound(m, params)
    phases = np.array([period_one_phase(max(a, least), m, params) for a in accelerations])
    push = accelerations / z_omega(params) * np.cos(phases)
    return launches(params, accelerations, phases, 0.5 * params.gravity * m * z_period(params) - push + nudge)
