"""The lecture's autopilot."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from vr_envs.controllers.autopilot_channels import Gains, gains_of
from vr_envs.envs.autopilot_observation import BAND, actions_for, limits, read
from vr_envs.envs.scene import Scene

# the angle atan(v_x / v) is turned in this time [s]; the lecture leaves it out, its step is 1 s
TURN_TIME = 1.0
# a captured channel is released when its error exceeds this multiple of the threshold
RELEASE = 2.0


class LectureLaw:
    """The lecture's autopilot: each rate proportional to its error, clamped, and off while the error is captured.

    v_y' = clamp(k_y y_err, -V_des, V_cli); a' = clamp(k_a v_err, -A_dec, A_acc); v_x' = clamp(k_h psi_err, V_M)
    turns the heading by atan(v_x' / v). A channel is captured when its error falls below the threshold, and
    acquired again beyond twice the threshold (the lecture gives no hysteresis; without one it chatters).
    Default gains are time constants of 11 s for altitude, 12.5 s for airspeed, 11 s for heading at 150 m/s.
    """

    TUNABLE: ClassVar[Gains] = {
        "altitude_gain": (0.01, 1.0, 1.0 / 11.0),
        "speed_gain": (0.01, 1.0, 1.0 / 12.5),
        "heading_gain": (1.0, 200.0, 150.0 * TURN_TIME / 11.0),
        "altitude_threshold": (0.0, 30.0, BAND[0]),
        "speed_threshold": (0.0, 2.0, BAND[1]),
        "heading_threshold": (0.0, math.radians(1.0), BAND[2]),
    }

    def __init__(self, scene: Scene, **gains: float) -> None:
        """Gains in 1/s, 1/s and (m/s)/rad; thresholds in m, m/s and rad."""
        gain = gains_of(self.TUNABLE, gains)
        self.scene = scene
        self.altitude_gain, self.speed_gain = gain["altitude_gain"], gain["speed_gain"]
        self.heading_gain = gain["heading_gain"]
        self.thresholds = np.array([gain[f"{name}_threshold"] for name in ("altitude", "speed", "heading")])
        self.reset(0)

    def reset(self, n: int) -> None:
        """No channel is captured."""
        self.captured = np.zeros((n, 3), np.bool_)

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        """Actions (n, 3) for observations (n, 23)."""
        reading = read(observations, self.scene)
        size = np.abs(reading.error)
        self.captured = size < np.where(self.captured, RELEASE, 1.0) * self.thresholds
        lateral = self.heading_gain * reading.error[:, 2]
        rates = np.stack(
            [
                self.altitude_gain * reading.error[:, 0],
                self.speed_gain * reading.error[:, 1],
                np.arctan2(lateral, reading.true_speed) / TURN_TIME,
            ],
            axis=1,
        )
        falling, rising = limits(reading, self.scene)
        return actions_for(np.where(self.captured, 0.0, rates), falling, rising)
