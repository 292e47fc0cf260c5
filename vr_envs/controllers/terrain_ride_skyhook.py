"""Laws that switch or set a damper by a rule: skyhook (Karnopp, Crosby and Harwood 1974) and its mix with ADD.

A damper takes energy out of the travel, whatever its damping; it pushes the mass against its velocity only while mass
and travel move the same way. The rules are about when to damp, not about the road. Where the action is a force the
skyhook is the real one, and there is nothing to switch.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from vr_envs.controllers.terrain_ride_law import (
    LEAST,
    MODULUS,
    SLOW,
    Ranges,
    RideLaw,
    away_from_zero,
    damping_actions,
    force_actions,
    serves_damper,
    spring_force,
)
from vr_envs.envs.scene import Scene
from vr_envs.envs.terrain_ride_observation import Reading

HARD = (1.0, 20.0, 8.0)


class TwoStateSkyhook(RideLaw):
    """On or off: hard while the damper would push the mass against its velocity (zeta' u' > 0), else soft."""

    TUNABLE: ClassVar[Ranges] = {"hard": HARD, "least": LEAST, "modulus": MODULUS}

    @staticmethod
    def serves(scene: Scene) -> bool:
        """Only a damper between mass and wheel can be switched."""
        return serves_damper(scene)

    def hardens(self, reading: Reading) -> np.ndarray:
        """Where the damper is to be hard, (n,)."""
        return reading.velocity * reading.travel_rate > 0.0

    def suspension(self, reading: Reading) -> np.ndarray:
        """One of two dampings [1/s]: `hard` or `least`; the modulus stays."""
        damping = np.where(self.hardens(reading), self.gains["hard"], self.gains["least"])
        return damping_actions(damping, self.gains["modulus"], self.scene)


class SkyhookAdd(TwoStateSkyhook):
    """Skyhook for slow motion, acceleration-driven damping (ADD) for quick motion (Savaresi and Spelta 2007).

    Where zeta''^2 > alpha^2 zeta'^2 the motion is quicker than the crossover alpha: there the damper is hard while it
    would push the mass against its acceleration (zeta'' u' > 0); elsewhere against its velocity, as the skyhook.
    """

    TUNABLE: ClassVar[Ranges] = {"crossover": (2.0, 100.0, 12.0), **TwoStateSkyhook.TUNABLE}

    def hardens(self, reading: Reading) -> np.ndarray:
        """`crossover`: alpha [rad/s], where both rules meet."""
        slow = self.gains["crossover"] * np.abs(reading.velocity)
        quick = np.abs(reading.acceleration) > slow
        return np.where(quick, reading.acceleration, reading.velocity) * reading.travel_rate > 0.0


class Skyhook(RideLaw):
    """A damper between the mass and the sky, as nearly as the suspension can imitate it.

    The wanted acceleration is -sky zeta'. A semi-active damper between mass and wheel gives -gamma u', so
    gamma = sky zeta' / u', limited to its range; where that is negative the least damping is best.
    """

    TUNABLE: ClassVar[Ranges] = {"sky": (1.0, 40.0, 12.0), "least": LEAST, "modulus": MODULUS}

    @staticmethod
    def serves(scene: Scene) -> bool:
        """A damper of the mass's own velocity is one to the sky already: there the law is the lecture's."""
        return bool(scene.params.active) or serves_damper(scene)

    def suspension(self, reading: Reading) -> np.ndarray:
        """`sky`: damping to the sky [1/s]; `least`: least damping asked of a damper [1/s]."""
        sky, modulus = self.gains["sky"], self.gains["modulus"]
        if self.scene.params.active:
            spring = spring_force(reading.travel, modulus, self.scene)
            return force_actions(spring - sky * reading.velocity, self.scene)
        damping = np.maximum(sky * reading.velocity / away_from_zero(reading.travel_rate, SLOW), self.gains["least"])
        return damping_actions(damping, modulus, self.scene)
