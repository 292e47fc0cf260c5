"""Proportional-integral control of each channel, with feed-forward, lead and anti-windup."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from vr_envs.controllers.autopilot_channels import BANDS, Channels, Gains, gains_of, lead, triple
from vr_envs.envs.scene import Scene


class ProportionalIntegral:
    """command = demand rate + k l + I, with the lead error l = e - T (rate - demand rate) and I' = k e / T_i.

    The gain is k = (1 - e^(-dt/tau)) / dt for a time constant tau of the closed loop; its other pole is the lag's own.
    Anti-windup: I stands still while the command is beyond a limit (conditional integration), and is bled off with T_i
    while the lead error is larger than a few bands, where the proportional part has all to do; so what it holds is the
    rate that a steady disturbance asks for.
    """

    TUNABLE: ClassVar[Gains] = {
        "altitude_time": (0.5, 40.0, 8.0),
        "speed_time": (0.5, 40.0, 8.0),
        "heading_time": (0.5, 40.0, 6.0),
        "integral_time": (5.0, 2000.0, 60.0),
        "zone": (0.5, 10.0, 3.0),
    }

    def __init__(self, scene: Scene, **gains: float) -> None:
        """Times [s]: tau of each channel, and T_i; `zone`: lead error, in bands, up to which I grows."""
        gain = gains_of(self.TUNABLE, gains)
        self.channels = Channels(scene)
        dt = self.channels.dt
        self.gain = -np.expm1(-dt / triple(gain, "time")) / dt
        self.share = -np.expm1(-dt / gain["integral_time"])
        self.zone = gain["zone"] * BANDS
        self.reset(0)

    def reset(self, n: int) -> None:
        """The integrals are zero."""
        self.channels.reset(n)
        self.integral = np.zeros((n, 3))

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        """Actions (n, 3) for observations (n, 23)."""
        flight = self.channels.flight(observations)
        left = lead(flight.error, flight, self.channels.lag)
        commands = flight.demand_rate + self.gain * left + self.integral
        growth = np.where(np.abs(left) <= self.zone, self.gain * flight.error, -self.integral)
        free = flight.clipped(commands) == commands
        self.integral += np.where(free | (np.abs(left) > self.zone), self.share * growth, 0.0)
        return self.channels.actions(commands, flight)
