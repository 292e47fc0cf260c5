"""Horizontal growth rates of the ball on the moving bar (Bell section IV), by contact law.

The bar moves as x = A_x sin(w t + pi/2), z = A_z sin(2 w t + pi/2), tilt = A_t sin(w t + phi); amplitudes are given as
peak accelerations. Tilt is the right-handed rotation about +y (y away from the camera): positive lowers the right end.
The rate gamma is that of the period-one orbit, from the multipliers of the exact map (`models/linearised.py`).

Bell prints neither restitution nor frequency of these figures, and the digits of his tilt acceleration are lost. Here
they are his measured 0.856, z at 30 Hz and 200 rad/s^2, with which the sizes on his axes come out for c = 2/7. Only the
tilt amplitude and the ratios of the accelerations to gravity matter, so another frequency stands for another tilt.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable

import numpy as np

from vr_envs.models.ball_on_bar import Params
from vr_envs.models.ball_options import OPTIONS, Spin
from vr_envs.models.linearised import CycleMap
from vr_envs.models.record import pack

RESTITUTION = 0.856
FREQUENCY = 15.0  # Hz, of x and tilt; z has twice as much
Z_ACCELERATION = 8.0  # m/s^2
TILT_ACCELERATION = 200.0  # rad/s^2


@dataclasses.dataclass(frozen=True)
class ContactLaw:
    """A tangential law: part `loss` of the sliding velocity is lost at an impact, or a sphere that grips and spins."""

    name: str
    loss: float
    spins: bool = False

    def cycle_map(self, frequency: float = FREQUENCY) -> CycleMap:
        """The map of the ball with this law; `frequency` of x and tilt, Hz."""
        params = Params(restitution=RESTITUTION, tangential_loss=self.loss, frequency=frequency)
        return CycleMap(pack(params), [pack(Spin()) if name == "spin" and self.spins else None for name in OPTIONS])


FRICTIONLESS = ContactLaw("frictionless, c = 0", 0.0)
PARTIAL = ContactLaw("c = 2/7, no spin", 2.0 / 7.0)
STICKING = ContactLaw("c = 1, no spin", 1.0)
SPHERE = ContactLaw("solid sphere with spin", 0.0, spins=True)
LAWS = (FRICTIONLESS, PARTIAL, STICKING, SPHERE)


def parabolic(cycle_map: CycleMap, x: float, tilt: float, phase: float, z: float = Z_ACCELERATION) -> np.ndarray:
    """The six phasors of Bell's motion from peak accelerations (m/s^2, rad/s^2, m/s^2) and the tilt's phase phi."""
    w2 = float(cycle_map.params["omega"]) ** 2
    return np.array([x / w2, 0.0, tilt / w2 * math.sin(phase), tilt / w2 * math.cos(phase), z / (4.0 * w2), 0.0])


def growth_rates(cycle_map: CycleMap, x: float, tilts: Iterable[float], phases: np.ndarray) -> np.ndarray:
    """gamma / omega (tilts, phases) at the x acceleration `x`, for tilt accelerations `tilts` and phases phi."""
    return np.array(
        [[cycle_map.orbit(parabolic(cycle_map, x, tilt, phase)).growth for phase in phases] for tilt in tilts]
    )


def harmonics(phases: np.ndarray, rates: np.ndarray) -> tuple[float, float, float]:
    """Mean, amplitude of the first harmonic, and that of the second, of rates over one turn of evenly spaced phases."""
    weights = rates / len(phases)
    first, second = (abs(2.0 * np.sum(weights * np.exp(-1j * k * phases))) for k in (1, 2))
    return float(weights.sum()), float(first), float(second)
