"""What moves the ride in place of the exact model: the engines of the task, each with its settings."""

from __future__ import annotations

import dataclasses
from typing import ClassVar

from vr_envs.models.record import quantity
from vr_envs.models.ride_options import Textbook


@dataclasses.dataclass(frozen=True)
class RigidBody:
    """Engine: Chipmunk bodies that move in fixed time steps (package pymunk): mass, hub, wheel, springs, terrain."""

    OPTIONS: ClassVar[tuple[str, ...]] = (
        "undulation", "road", "profile", "bumps", "obstacle", "wheel", "tyre", "stop", "payload", "lag", "cruise",
        "preview", "noise", "metrics",
    )  # fmt: skip

    step: float = quantity(
        1e-4, "s", "time step at most; the time between two ticks is a whole number of equal steps", low=1e-6, high=1e-3
    )


ENGINES: dict[str, type] = {"textbook": Textbook, "rigid_body": RigidBody}
"""The engines other than the exact one, name -> settings."""
