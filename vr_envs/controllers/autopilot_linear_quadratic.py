"""Linear-quadratic control of each channel, with its lag discretised exactly."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from vr_envs.controllers.autopilot_channels import BANDS, NAMES, Channels, Gains, capture, gains_of, lead, triple
from vr_envs.controllers.linear_quadratic import riccati
from vr_envs.envs.scene import Scene


def channel_matrices(lag: float, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """(A, B) of a channel over an interval, without its limits; exact.

    State: error, rate and last command, the rates relative to the demand's; input: the change of the command.
    rate1 = p rate + (1 - p) c, e1 = e - T (1 - p) rate - (dt - T (1 - p)) c with c the new command, p = e^(-dt/T).
    """
    decay = math.exp(-dt / lag) if lag > 0.0 else 0.0
    late = lag * (1.0 - decay)
    on_command = np.array([late - dt, 1.0 - decay, 1.0])
    a = np.array([[1.0, -late, 0.0], [0.0, decay, 0.0], [0.0, 0.0, 0.0]])
    a[:, 2] += on_command
    return a, on_command[:, None]


class LinearQuadratic:
    """The change of each command that minimises the sum of (e / band)^2 + effort (change / limit)^2, limited.

    The state is (error, rate, last command), relative to the demand. The Riccati law knows no limits; beyond the
    errors from which the aircraft could not stop in time it would overshoot, so the command is kept within the
    square-root capture of the error that the lag will leave and a band more, which leaves small errors alone.
    """

    TUNABLE: ClassVar[Gains] = {
        "altitude_effort": (0.1, 1e5, 300.0),
        "speed_effort": (0.1, 1e5, 300.0),
        "heading_effort": (0.1, 1e5, 300.0),
        "altitude_share": (0.1, 1.0, 0.6),
        "speed_share": (0.1, 1.0, 0.6),
        "heading_share": (0.1, 1.0, 0.6),
    }

    def __init__(self, scene: Scene, **gains: float) -> None:
        """Efforts: cost of changing a command by its whole limit; shares: of the slew limits, for the capture."""
        gain = gains_of(self.TUNABLE, gains)
        self.channels = Channels(scene)
        self.share = triple(gain, "share")
        p = scene.params
        limits = (max(p.climb, p.descent), max(p.acceleration, p.deceleration), p.turn)
        self.gain = np.zeros((3, 3))
        for k, (name, limit, band) in enumerate(zip(NAMES, limits, BANDS, strict=True)):
            a, b = channel_matrices(self.channels.lag[k], self.channels.dt)
            cost = np.diag([1.0 / band**2, 0.0, 0.0])
            _, gains_of_state = riccati(a, b, cost, np.array([[gain[f"{name}_effort"] / limit**2]]))
            self.gain[k] = gains_of_state[0]

    def reset(self, n: int) -> None:
        """Nothing has been commanded."""
        self.channels.reset(n)

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        """Actions (n, 3) for observations (n, 23)."""
        flight = self.channels.flight(observations)
        rate, last = flight.rate - flight.demand_rate, flight.command - flight.demand_rate
        change = -(self.gain[:, 0] * flight.error + self.gain[:, 1] * rate + self.gain[:, 2] * last)
        reach = np.abs(lead(flight.error, flight, self.channels.lag)) + BANDS
        bound = capture(reach, np.full(3, 1.0 / self.channels.dt), self.share * flight.slew)
        return self.channels.actions(flight.demand_rate + np.clip(last + change, -bound, bound), flight)
