"""Climb and acceleration share one power: who gets it, and when."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from vr_envs.controllers.autopilot_channels import Flight, Gains, climb_per_acceleration, gains_of, power_limits
from vr_envs.controllers.autopilot_square_root import SquareRoot
from vr_envs.envs.scene import Scene

# m: energy heights closer than this to their demands count as this far
NEAR = 1.0


class TotalEnergy(SquareRoot):
    """The square-root law, and where both altitude and airspeed want power or want to be rid of it, a division.

    In units of climb rate, climbing takes v_y and accelerating v a / g; together they stay between -idle sink and the
    climb limit. What is left to the two that pull the same way is divided in the ratio d_y^-p : d_v^-p of the energy
    heights still to go, d_y = |altitude error| and d_v = v |airspeed error| / g: p > 0 serves first what is done sooner
    (which minimises the time that the two wait), p < 0 what takes longer, p = 0 halves it. What one does not need, the
    other gets. Total energy control (Lambregts 1983) divides equally.
    """

    TUNABLE: ClassVar[Gains] = {**SquareRoot.TUNABLE, "priority": (-2.0, 4.0, 1.0)}

    def __init__(self, scene: Scene, **gains: float) -> None:
        """`priority`: the exponent p; the rest as `SquareRoot`."""
        super().__init__(scene, **gains)
        self.scene, self.priority = scene, gains_of(self.TUNABLE, gains)["priority"]

    def commands(self, flight: Flight) -> np.ndarray:
        """Rates (n, 3) within their limits and within the power."""
        commands = flight.clipped(super().commands(flight))
        if self.scene.options["energy"] is None:
            return commands
        per_acceleration = climb_per_acceleration(flight)
        wanted = np.stack([commands[:, 0], commands[:, 1] * per_acceleration], axis=1)
        heights = np.abs(flight.error[:, :2]) * np.stack([np.ones_like(per_acceleration), per_acceleration], axis=1)
        heights = np.maximum(heights, NEAR)
        ratio = (heights[:, 0] / heights[:, 1]) ** self.priority
        share = 1.0 / (1.0 + ratio)
        lowest, highest = power_limits(flight, self.scene)
        rising = _divide(np.maximum(wanted, 0.0), highest - np.minimum(wanted, 0.0).sum(axis=1), share)
        falling = _divide(np.maximum(-wanted, 0.0), -lowest + rising.sum(axis=1), share)
        given = rising - falling
        return np.stack([given[:, 0], given[:, 1] / per_acceleration, commands[:, 2]], axis=1)


def _divide(wanted: np.ndarray, available: np.ndarray, share: np.ndarray) -> np.ndarray:
    """What the two (n, 2) get of what is available (n,), of which `share` (n,) is the first one's if both want it."""
    first = np.minimum(wanted[:, 0], share * available)
    second = np.minimum(wanted[:, 1], available - first)
    return np.stack([np.minimum(wanted[:, 0], available - second), second], axis=1)
