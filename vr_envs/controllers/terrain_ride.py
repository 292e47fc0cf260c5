"""Ride laws that need no training: the lecture's passive spring, and the skyhook damper."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from vr_envs.envs.scene import Scene
from vr_envs.envs.terrain_ride_observation import read
from vr_envs.models.spring import damping_of_restitution
from vr_envs.models.terrain_ride import Params

BASELINE = "lecture"
# the lecture quotes its factor k_d for one frame of a 60 Hz display
FRAME = 1.0 / 60.0
# travel rate [m/s] below which a damper's force is too small to matter, and its sign uncertain
SLOW = 1e-3
# what the actuators of the default scene can do bounds the gains: beyond it a gain would have no effect
_RANGE = Params()
_MODULUS = (_RANGE.modulus_low, _RANGE.modulus_high, 1.0)


def _gains(tunable: dict[str, tuple[float, float, float]], given: dict[str, float]) -> dict[str, float]:
    return {name: given.get(name, limits[2]) for name, limits in tunable.items()}


def damping_actions(damping: np.ndarray, modulus: float, scene: Scene) -> np.ndarray:
    """Actions (n, 2) for the damping [1/s] and one modulus of the spring, clipped to what the actuators can do."""
    p = scene.params
    position = np.clip((np.log(damping) - p.damping_centre) / p.damping_half, -1.0, 1.0)
    spring = np.clip((math.log(modulus) - p.modulus_centre) / p.modulus_half, -1.0, 1.0)
    return np.stack([position, np.full_like(position, spring)], axis=1).astype(np.float32)


def force_actions(acceleration: np.ndarray, scene: Scene) -> np.ndarray:
    """Actions (n, 1) for the acceleration [m/s^2] that the force is to give."""
    return np.clip(acceleration / scene.params.push, -1.0, 1.0)[:, None].astype(np.float32)


def spring_force(travel: np.ndarray, modulus: float, scene: Scene) -> np.ndarray:
    """Acceleration [m/s^2] that makes the passive spring, whose modulus is 1, one of the given modulus."""
    return (1.0 - modulus) * scene.params.w2 * travel


class LecturePassive:
    """The lecture's passive spring (3.88, 3.90): the velocity falls by the factor k_d in one frame, for ever.

    The damping is gamma = -ln(k_d) / frame. Both parameters of the lecture's law, the factor k_d and the modulus
    lambda, are chosen once. Where the action is a force, it is that by which the same damper and spring differ from
    the passive ones.
    """

    TUNABLE: ClassVar[dict[str, tuple[float, float, float]]] = {
        "restitution": (math.exp(-_RANGE.damping_high * FRAME), math.exp(-_RANGE.damping_low * FRAME), 0.95),
        "modulus": _MODULUS,
    }

    def __init__(self, scene: Scene, **gains: float) -> None:
        """`restitution`: k_d at 60 Hz, in (0, 1); `modulus`: lambda, as a factor on the nominal one, positive."""
        self.scene = scene
        chosen = _gains(self.TUNABLE, gains)
        self.damping, self.modulus = damping_of_restitution(chosen["restitution"], FRAME), chosen["modulus"]

    def reset(self, n: int) -> None:
        """Nothing to forget."""

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        """Actions for observations (n, width)."""
        p = self.scene.params
        if not p.active:
            return damping_actions(np.full(len(observations), self.damping), self.modulus, self.scene)
        reading = read(observations, self.scene)
        rate = reading.travel_rate if p.relative else reading.velocity
        spring = spring_force(reading.travel, self.modulus, self.scene)
        return force_actions((p.passive_damping - self.damping) * rate + spring, self.scene)


class Skyhook:
    """A damper between the mass and the sky, as nearly as the suspension can imitate it.

    The wanted acceleration is -sky zeta'. A semi-active damper between mass and wheel gives -gamma u', so
    gamma = sky zeta' / u', limited to its range; where that is negative the least damping is best.
    """

    TUNABLE: ClassVar[dict[str, tuple[float, float, float]]] = {
        "sky": (1.0, 40.0, 12.0),
        "least": (_RANGE.damping_low, 5.0, 0.6),
        "modulus": _MODULUS,
    }

    def __init__(self, scene: Scene, **gains: float) -> None:
        """`sky`: damping to the sky [1/s]; `least`: least damping asked of the damper [1/s]; `modulus`: as above."""
        self.scene = scene
        self.gains = _gains(self.TUNABLE, gains)

    def reset(self, n: int) -> None:
        """Nothing to forget."""

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        """Actions for observations (n, width)."""
        p, sky, modulus = self.scene.params, self.gains["sky"], self.gains["modulus"]
        reading = read(observations, self.scene)
        if p.active:
            spring = spring_force(reading.travel, modulus, self.scene)
            return force_actions(spring - sky * reading.velocity, self.scene)
        if not p.relative:
            return damping_actions(np.full(len(observations), sky), modulus, self.scene)
        rate = np.where(np.abs(reading.travel_rate) < SLOW, SLOW, reading.travel_rate)
        damping = np.maximum(sky * reading.velocity / rate, self.gains["least"])
        return damping_actions(damping, modulus, self.scene)


LAWS: dict[str, type] = {BASELINE: LecturePassive, "skyhook": Skyhook}
