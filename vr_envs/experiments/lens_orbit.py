"""Closed forms of a ball that bounces on a lens once a cycle (period one), near the lens's centre.

Just before an impact the lens moves with U, the ball falls with g T/2; the normal velocity W = g T / (1 + alpha) is
turned into alpha W. The normal there is (-kappa r, 1) to first order in the place r = (x, y), so in a vertical plane
through the axis the tangential velocity before is u - W kappa x, and after it u' = tangential - alpha W kappa x.
With beta = kappa g T^2, in (x, T u): frictionless ((1 - beta, 1), (-beta, 1)), determinant 1 and trace 2 - beta:
neutral with the angle 2 cos(angle) = 2 - beta for 0 < beta < 4, unstable above.
"""

from __future__ import annotations

import cmath
import dataclasses
import math

import numpy as np

from vr_envs.experiments.bounce import period_one_phase
from vr_envs.models.ball_on_bar import Params as BarParams
from vr_envs.models.ball_on_lens import Params, State
from vr_envs.models.ball_options import Spin
from vr_envs.models.impact import collide
from vr_envs.models.lens_flight import surface_height
from vr_envs.models.record import pack


def impact_phase(params: Params) -> float:
    """Phase (rad) of the lens at the impacts of the stable period one.

    Raises:
        ValueError: the lens moves too gently for a period one.
    """
    bar = BarParams(gravity=params.gravity, restitution=params.restitution)
    return period_one_phase(params.acceleration, 1, bar)


def from_apex(params: Params) -> Params:
    """The scene with the phase with which a cycle of the period one starts at the ball's highest point."""
    return dataclasses.replace(params, phase=impact_phase(params) - math.pi)


def period_one_start(params: Params, x: float = 0.0, y: float = 0.0, u: float = 0.0, v: float = 0.0) -> State:
    """The ball at the start of a cycle on its period one, at (x, y) (m) with horizontal velocity (u, v) (m/s).

    Away from the centre the vertical motion is that of the centre, raised by the lens's height under the last impact.
    """
    phase = impact_phase(params)
    since = ((params.phase - phase) / params.omega) % params.period
    half = 0.5 * params.gravity * params.period
    ground = surface_height(math.hypot(x - u * since, y - v * since), params.path_curvature)
    z = ground + params.amplitude * math.sin(phase) + (half - 0.5 * params.gravity * since) * since
    return State(x=x, y=y, z=z, u=u, v=v, w=half - params.gravity * since)


def lens_strength(params: Params) -> float:
    """The number beta = kappa g T^2 that decides the horizontal motion: 8 kappa times the bounce's height."""
    return params.path_curvature * params.gravity * params.period**2


def horizontal_map(params: Params, spin: Spin | None = None) -> np.ndarray:
    """Linear map of (x, T u, T sigma) from before one impact of the period one to before the next, shape (3, 3).

    Without spin of (x, T u), shape (2, 2). sigma is the velocity that the spin takes from the slip of a ball that
    moves along x: R times the spin about +y.
    """
    alpha = params.restitution
    fall = lens_strength(params) / (1.0 + alpha)  # kappa W T
    record = None if spin is None else pack(spin)
    columns = []
    for x, u, sigma in np.eye(3):
        _, tangent, rolling = collide(-1.0, u - fall * x, sigma, alpha, params.tangential_loss, record, None)
        after = tangent - alpha * fall * x
        columns.append((x + after, after, rolling))
    size = 2 if spin is None else 3
    return np.array(columns).T[:size, :size]


def travel_frequency(params: Params, spin: Spin | None = None) -> float:
    """Frequency (Hz) of the travel round the lens: the angle of the map's complex pair over 2 pi T; 0 without one."""
    return max(cmath.phase(value) for value in np.linalg.eigvals(horizontal_map(params, spin))) / (
        2.0 * math.pi * params.period
    )


def apex_swings(params: Params, x: complex, y: complex) -> tuple[complex, complex]:
    """How the apex heights of a frictionless ball swing as it travels round the lens, to second order in its place.

    The ball is at (Re x e^{i angle k}, Re y e^{i angle k}) at impact k, angle that of `travel_frequency`; whatever is
    quadratic in the place swings with twice the angle and drives the vertical period one, which answers linearly.

    Args:
        params: the scene.
        x: phasor of the place, m, complex.
        y: the same for y.

    Returns:
        Phasors (m) at twice the angle of the apex above the mean height of the lens: as it is, and less the height
        of the lens at the apex's place.
    """
    alpha, gravity, period, kappa = params.restitution, params.gravity, params.period, params.path_curvature
    phase = impact_phase(params)
    climb = params.omega * params.amplitude * math.cos(phase)
    decelerating = -params.acceleration * math.sin(phase)
    fall = gravity * period / (1.0 + alpha)
    angle = 2.0 * math.pi * travel_frequency(params) * period
    turn, twice = cmath.exp(1j * angle), cmath.exp(2j * angle)
    square = 0.5 * (x * x + y * y)  # of r . r at an impact
    height = 0.5 * kappa * square
    # normal velocity that the slope adds: kappa r . u - W kappa^2 r . r, u the velocity with which the ball comes in
    push = (kappa * (1.0 - 1.0 / turn) / period - fall * kappa * kappa) * square
    # Unknown: lateness t and change of launch velocity v, both as phasors.
    #   W (t' - t) = T v - (height' - height)
    #   v' = -alpha (v - g (t' - t)) + (1 + alpha) (a t' + push')
    late = twice - 1.0
    system = np.array(
        [
            [fall * late, -period],
            [-alpha * gravity * late - (1.0 + alpha) * decelerating * twice, twice + alpha],
        ]
    )
    lateness, launch = np.linalg.solve(system, np.array([-height * late, (1.0 + alpha) * push * twice]))
    raw = climb * lateness + height + 0.5 * period * launch
    return raw, raw - height * (1.0 + turn) ** 2 / 4.0
