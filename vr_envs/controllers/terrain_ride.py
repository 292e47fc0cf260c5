"""Ride laws that need no training, weakest first."""

from __future__ import annotations

from vr_envs.controllers.terrain_ride_law import RideLaw
from vr_envs.controllers.terrain_ride_optimal import ClippedOptimal, LinearQuadratic, Preview
from vr_envs.controllers.terrain_ride_passive import LecturePassive
from vr_envs.controllers.terrain_ride_skyhook import Skyhook, SkyhookAdd, TwoStateSkyhook

BASELINE = "lecture"
LAWS: dict[str, type[RideLaw]] = {
    BASELINE: LecturePassive,
    "skyhook-two-state": TwoStateSkyhook,
    "sh-add": SkyhookAdd,
    "skyhook": Skyhook,
    "clipped-optimal": ClippedOptimal,
    "linear-quadratic": LinearQuadratic,
    "preview": Preview,
}
