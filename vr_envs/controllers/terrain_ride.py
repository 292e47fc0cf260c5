"""Ride laws that need no training: the lecture's passive spring, and the skyhook damper."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from vr_envs.envs.scene import Scene
from vr_envs.envs.terrain_ride_observation import read
from vr_envs.models.spring import damping_of_restitution

BASELINE = "lecture"
# the lecture quotes its factor k_d for one frame of a 60 Hz display
FRAME = 1.0 / 60.0
# travel rate [m/s] below which a damper's force is too small to matter, and its sign uncertain
SLOW = 1e-3


def _gains(tunable: dict[str, tuple[float, float, float]], given: dict[str, float]) -> dict[str, float]:
    return {name: given.get(name, limits[2]) for name, limits in tunable.items()}


def damping_actions(damping: np.ndarray, scene: Scene) -> np.ndarray:
    """Actions (n, 2) for the damping [1/s], clipped to what the damper can do, with the spring's modulus at 1."""
    p = scene.params
    modulus = np.clip(-p.modulus_centre / p.modulus_half, -1.0, 1.0)
    position = np.clip((np.log(damping) - p.damping_centre) / p.damping_half, -1.0, 1.0)
    return np.stack([position, np.full_like(position, modulus)], axis=1).astype(np.float32)


def force_actions(acceleration: np.ndarray, scene: Scene) -> np.ndarray:
    """Actions (n, 1) for the acceleration [m/s^2] that the force is to give."""
    return np.clip(acceleration / scene.params.push, -1.0, 1.0)[:, None].astype(np.float32)


class LecturePassive:
    """The lecture's passive spring (3.88, 3.90): the velocity falls by the factor k_d in one frame, for ever.

    The damping is gamma = -ln(k_d) / frame, the modulus stays as it is. Where the action is a force, the force is
    that of the same damper beside the passive one.
    """

    TUNABLE: ClassVar[dict[str, tuple[float, float, float]]] = {"restitution": (0.8, 0.999, 0.95)}

    def __init__(self, scene: Scene, **gains: float) -> None:
        """`restitution`: k_d at 60 Hz, in (0, 1)."""
        self.scene = scene
        self.damping = damping_of_restitution(_gains(self.TUNABLE, gains)["restitution"], FRAME)

    def reset(self, n: int) -> None:
        """Nothing to forget."""

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        """Actions for observations (n, width)."""
        p = self.scene.params
        if not p.active:
            return damping_actions(np.full(len(observations), self.damping), self.scene)
        reading = read(observations, self.scene)
        rate = reading.travel_rate if p.relative else reading.velocity
        return force_actions((p.passive_damping - self.damping) * rate, self.scene)


class Skyhook:
    """A damper between the mass and the sky, as nearly as the suspension can imitate it.

    The wanted acceleration is -sky zeta'. A semi-active damper between mass and wheel gives -gamma u', so
    gamma = sky zeta' / u', limited to its range; where that is negative the least damping is best.
    """

    TUNABLE: ClassVar[dict[str, tuple[float, float, float]]] = {"sky": (1.0, 40.0, 12.0), "least": (0.1, 5.0, 0.6)}

    def __init__(self, scene: Scene, **gains: float) -> None:
        """`sky`: damping to the sky [1/s]; `least`: least damping that is asked of the damper [1/s]."""
        self.scene = scene
        self.gains = _gains(self.TUNABLE, gains)

    def reset(self, n: int) -> None:
        """Nothing to forget."""

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        """Actions for observations (n, width)."""
        p, sky = self.scene.params, self.gains["sky"]
        reading = read(observations, self.scene)
        if p.active:
            return force_actions(-sky * reading.velocity, self.scene)
        if not p.relative:
            return damping_actions(np.full(len(observations), sky), self.scene)
        rate = np.where(np.abs(reading.travel_rate) < SLOW, SLOW, reading.travel_rate)
        return damping_actions(np.maximum(sky * reading.velocity / rate, self.gains["least"]), self.scene)


LAWS: dict[str, type] = {BASELINE: LecturePassive, "skyhook": Skyhook}
