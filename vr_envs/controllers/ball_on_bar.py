"""Laws for the ball on a bar."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from vr_envs.controllers.policy import Constant
from vr_envs.envs.scene import Scene

BASELINE = "bell-sink"


def _share(value: float, span: float) -> float:
    """The action for `value` of a motion with the given value at action 1; without a range there is nothing to ask."""
    return value / span if span > 0.0 else 0.0


class BellSink(Constant):
    """Bell's open-loop sink motion (section IV): a constant parabolic path with the tilt at a chosen phase.

    x = A_x sin(w t + pi/2), z = A_z sin(2 w t + pi/2), tilt = A_tilt sin(w t + phase). With the tilt counted about
    +y, phase +pi/2 is a sink and -pi/2 a source (Bell Fig 4.4). Amplitudes are peak accelerations.
    """

    TUNABLE: ClassVar[dict[str, tuple[float, float, float]]] = {
        "x_acceleration": (0.0, 10.0, 4.0),
        "tilt_acceleration": (0.0, 100.0 * math.sqrt(2.0), 50.0),  # in phase and quadrature part each reach 100
        "z_acceleration": (4.0, 12.0, 8.0),
        "phase": (-math.pi, math.pi, 0.5 * math.pi),
    }

    def __init__(self, scene: Scene, **gains: float) -> None:
        """Accelerations in m/s^2 and rad/s^2, `phase` in rad; defaults are Bell's (Figs 4.4, 4.7)."""
        gain = {name: gains.get(name, default) for name, (_, _, default) in self.TUNABLE.items()}
        p = scene.params
        tilt = _share(gain["tilt_acceleration"], p.tilt_acceleration)
        action = np.zeros(6)
        action[0] = _share(gain["x_acceleration"], p.x_acceleration)
        action[2], action[3] = tilt * math.sin(gain["phase"]), tilt * math.cos(gain["phase"])
        action[4] = _share(gain["z_acceleration"] - p.z_acceleration, p.z_acceleration_span)
        super().__init__(np.clip(action, -1.0, 1.0))


LAWS: dict[str, type] = {BASELINE: BellSink}
