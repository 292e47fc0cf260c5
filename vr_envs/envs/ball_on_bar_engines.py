"""What moves the ball in place of the exact model: the engines of the task, each with its settings."""

from __future__ import annotations

import dataclasses
from typing import ClassVar

from vr_envs.models.ball_options import Textbook
from vr_envs.models.record import quantity


@dataclasses.dataclass(frozen=True)
class RigidBody:
    """Engine: Chipmunk bodies that move in fixed time steps, a kinematic bar and a circle (package pymunk)."""

    OPTIONS: ClassVar[tuple[str, ...]] = (
        "scatter",
        "spin",
        "friction",
        "softening",
        "curve",
        "frequencies",
        "ramp",
        "sensing",
        "camera",
    )

    step: float = quantity(
        1e-4, "s", "time step at most; an interval is a whole number of equal steps", low=1e-6, high=5e-4
    )


ENGINES: dict[str, type] = {"textbook": Textbook, "rigid_body": RigidBody}
"""The engines other than the exact one, name -> settings."""
