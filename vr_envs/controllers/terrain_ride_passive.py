"""The lecture's passive spring."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from vr_envs.controllers.terrain_ride_law import (
    MODULUS,
    RANGE,
    Ranges,
    RideLaw,
    damping_actions,
    force_actions,
    spring_force,
)
from vr_envs.envs.scene import Scene
from vr_envs.envs.terrain_ride_observation import Reading
from vr_envs.models.spring import damping_of_restitution

# the lecture quotes its factor k_d for one frame of a 60 Hz display
FRAME = 1.0 / 60.0


class LecturePassive(RideLaw):
    """The lecture's passive spring (3.88, 3.90): the velocity falls by the factor k_d in one frame, for ever.

    The damping is gamma = -ln(k_d) / frame. Both parameters of the lecture's law, the factor k_d and the modulus
    lambda, are chosen once. Where the action is a force, it is that by which the same damper and spring differ from
    the passive ones.
    """

    TUNABLE: ClassVar[Ranges] = {
        "restitution": (math.exp(-RANGE.damping_high * FRAME), math.exp(-RANGE.damping_low * FRAME), 0.95),
        "modulus": MODULUS,
    }

    def __init__(self, scene: Scene, **gains: float) -> None:
        """`restitution`: k_d at 60 Hz, in (0, 1); `modulus`: lambda, as a factor on the nominal one, positive."""
        super().__init__(scene, **gains)
        self.damping = damping_of_restitution(self.gains["restitution"], FRAME)

    def suspension(self, reading: Reading) -> np.ndarray:
        """The same damper and spring always."""
        p, modulus = self.scene.params, self.gains["modulus"]
        if not p.active:
            return damping_actions(np.full(len(reading.travel), self.damping), modulus, self.scene)
        rate = reading.travel_rate if p.relative else reading.velocity
        spring = spring_force(reading.travel, modulus, self.scene)
        return force_actions((p.passive_damping - self.damping) * rate + spring, self.scene)
