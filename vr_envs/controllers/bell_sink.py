"""Bell's open-loop sink motion for the ball on a bar."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import numpy as np
from scipy.optimize import minimize_scalar

from vr_envs.controllers.bar_design import Design
from vr_envs.controllers.policy import Constant
from vr_envs.envs.scene import Scene

SCAN = 16  # phases between which the best one is searched
BELL_PHASE = 0.5 * math.pi  # Bell's sink (Fig 4.4), where no phase can be computed
PHASE_TOLERANCE = 1e-3


def _share(value: float, span: float) -> float:
    """The action for `value` of a motion with the given value at action 1; without a range there is nothing to ask."""
    return value / span if span > 0.0 else 0.0


def parabolic_action(scene: Scene, x: float, tilt: float, z: float, phase: float) -> np.ndarray:
    """The action for x = A_x sin(w t + pi/2), z = A_z sin(2 w t + pi/2), tilt = A_tilt sin(w t + phase).

    Amplitudes are peak accelerations in m/s^2, rad/s^2 and m/s^2; what the bar cannot do is clipped. Tilt is
    counted about +y: phase +pi/2 is a sink and -pi/2 a source (Bell Fig 4.4).
    """
    p = scene.params
    action = np.zeros(6)
    action[0] = _share(x, p.x_acceleration)
    share = _share(tilt, p.tilt_acceleration)
    action[2], action[3] = share * math.sin(phase), share * math.cos(phase)
    action[4] = _share(z - p.z_acceleration, p.z_acceleration_span)
    return np.clip(action, -1.0, 1.0)


def sink_action(design: Design, scene: Scene, x: float, tilt: float, z: float) -> np.ndarray:
    """The `parabolic_action` at the phase with the smallest growth rate; at +pi/2 where no phase has period one."""

    def growth(phase: float) -> float:
        return design.growth(parabolic_action(scene, x, tilt, z, phase))

    step = 2.0 * math.pi / SCAN
    phases = step * np.arange(SCAN)
    rates = np.array([growth(phase) for phase in phases])
    if not np.isfinite(rates).any():
        return parabolic_action(scene, x, tilt, z, BELL_PHASE)
    found = [(rates.min(), phases[rates.argmin()])]
    # gamma may have two valleys of nearly the same depth, half a turn apart
    for valley in phases[(rates <= np.roll(rates, 1)) & (rates <= np.roll(rates, -1)) & np.isfinite(rates)]:
        best: Any = minimize_scalar(
            growth, bounds=(valley - step, valley + step), method="bounded", options={"xatol": PHASE_TOLERANCE}
        )
        found.append((best.fun, best.x))
    return parabolic_action(scene, x, tilt, z, float(min(found)[1]))


class BellSink(Constant):
    """Bell's open-loop sink motion (section IV): a constant parabolic path with the tilt at the phase that draws most.

    The phase is computed for the scene: it minimises the growth rate gamma of the exact map's horizontal motion.
    """

    TUNABLE: ClassVar[dict[str, tuple[float, float, float]]] = {
        "x_acceleration": (0.0, 10.0, 4.0),
        "tilt_acceleration": (0.0, 100.0 * math.sqrt(2.0), 50.0),  # in phase and quadrature part each reach 100
        "z_acceleration": (4.0, 12.0, 8.0),
    }

    def __init__(self, scene: Scene, **gains: float) -> None:
        """Accelerations in m/s^2 and rad/s^2; defaults are Bell's (Figs 4.4, 4.7)."""
        gain = {name: gains.get(name, default) for name, (_, _, default) in self.TUNABLE.items()}
        super().__init__(
            sink_action(Design(scene), scene, gain["x_acceleration"], gain["tilt_acceleration"], gain["z_acceleration"])
        )
