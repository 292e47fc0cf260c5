"""Laws for the ball on a bar."""

from __future__ import annotations

from vr_envs.controllers.bell_sink import BellSink
from vr_envs.controllers.linear_quadratic import LinearQuadratic
from vr_envs.controllers.receding_horizon import RecedingHorizon
from vr_envs.controllers.vertical_dead_beat import VerticalDeadBeat

BASELINE = "bell-sink"
LAWS: dict[str, type] = {
    BASELINE: BellSink,
    "dead-beat": VerticalDeadBeat,
    "linear-quadratic": LinearQuadratic,
    "receding-horizon": RecedingHorizon,
}
