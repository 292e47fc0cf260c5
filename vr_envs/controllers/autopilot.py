"""The autopilot laws that need no training, weakest first."""

from __future__ import annotations

from vr_envs.controllers.autopilot_lecture import LectureLaw
from vr_envs.controllers.autopilot_linear_quadratic import LinearQuadratic
from vr_envs.controllers.autopilot_proportional_integral import ProportionalIntegral
from vr_envs.controllers.autopilot_square_root import SquareRoot
from vr_envs.controllers.autopilot_total_energy import TotalEnergy

BASELINE = "lecture"
LAWS: dict[str, type] = {
    BASELINE: LectureLaw,
    "proportional-integral": ProportionalIntegral,
    "linear-quadratic": LinearQuadratic,
    "square-root": SquareRoot,
    "total-energy": TotalEnergy,
}
