"""Bank and load factors of an aircraft in coordinated flight, for which the wings carry everything.

Vertically the lift balances weight and climb acceleration, L cos(bank) = m (g + v_y'); across the path it turns the
aircraft, L sin(bank) = m v psi'. Path angles are small, as everywhere in this model.
"""

from __future__ import annotations

import math

from vr_envs.models.constants import G
from vr_envs.models.jit import kernel

_PER_G = 1.0 / G  # a kernel multiplies: division by a constant is several times slower


@kernel
def lateral_load_factor(turn_rate: float, speed: float) -> float:
    """Acceleration across the path [g], of the sign of the turn rate [rad/s], at a true airspeed [m/s]."""
    return turn_rate * speed * _PER_G


@kernel
def bank(turn_rate: float, speed: float) -> float:
    """Bank angle [rad] of a level turn, atan(v psi' / g), at a true airspeed [m/s]."""
    return math.atan(lateral_load_factor(turn_rate, speed))


@kernel
def normal_load_factor(turn_rate: float, speed: float, vertical_acceleration: float) -> float:
    """Lift over weight, 1 in straight level flight; `vertical_acceleration`: rate of change of climb [m/s^2]."""
    up, across = 1.0 + vertical_acceleration * _PER_G, lateral_load_factor(turn_rate, speed)
    return math.sqrt(up * up + across * across)
