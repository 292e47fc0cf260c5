"""Each channel as fast as it can be stopped again."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from vr_envs.controllers.autopilot_channels import Channels, Flight, Gains, capture, gains_of, lead, triple
from vr_envs.envs.scene import Scene


class SquareRoot:
    """The demand's rate, and on top of it a rate that falls with the root of the error that the lag will leave.

    command = demand rate + capture(e - T' (rate - demand rate)). Near the demand, where the capture is a proportional
    gain k, the lead cancels the lag: with T' = T the error decays as e^(-k t) and e^(-t/T). Far from it the rate
    follows the curve along which a constant deceleration, a share of what the aircraft's slew limit allows, ends at the
    demand. The command is held for an interval dt, which a gain (1 - e^(-k dt)) / dt and a lead of half an interval
    more allow for.
    """

    TUNABLE: ClassVar[Gains] = {
        "altitude_time": (0.5, 30.0, 5.0),
        "speed_time": (0.5, 30.0, 5.0),
        "heading_time": (0.5, 30.0, 4.0),
        "altitude_share": (0.1, 1.0, 0.6),
        "speed_share": (0.1, 1.0, 0.6),
        "heading_share": (0.1, 1.0, 0.6),
        "lead": (0.3, 2.0, 1.0),
    }

    def __init__(self, scene: Scene, **gains: float) -> None:
        """Times: time constants 1 / k [s]; shares: of the slew limits; lead: factor on the lead times."""
        gain = gains_of(self.TUNABLE, gains)
        self.channels = Channels(scene)
        dt = self.channels.dt
        self.gain = -np.expm1(-dt / triple(gain, "time")) / dt
        self.share = triple(gain, "share")
        self.lead = gain["lead"] * (self.channels.lag + 0.5 * dt * (self.channels.lag > 0.0))

    def reset(self, n: int) -> None:
        """Nothing has been commanded."""
        self.channels.reset(n)

    def commands(self, flight: Flight) -> np.ndarray:
        """Rates (n, 3), not limited."""
        left = lead(flight.error, flight, self.lead)
        return flight.demand_rate + capture(left, self.gain, self.share * flight.slew)

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        """Actions (n, 3) for observations (n, 23)."""
        flight = self.channels.flight(observations)
        return self.channels.actions(self.commands(flight), flight)
