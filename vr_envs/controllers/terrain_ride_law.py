"""What the laws of the ride share: from what they want of the suspension to actions, and the speed where it is free."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from vr_envs.envs.scene import Scene
from vr_envs.envs.terrain_ride_observation import Reading, read
from vr_envs.models.terrain_ride import Params

# travel rate [m/s] below which a damper's force is too small to matter, and its sign uncertain
SLOW = 1e-3
# s: a ride that is late, or early, makes that good in this time
CATCH_UP = 2.0
# what the actuators of the default scene can do bounds the gains: beyond it a gain would have no effect
RANGE = Params()
MODULUS = (RANGE.modulus_low, RANGE.modulus_high, 1.0)
LEAST = (RANGE.damping_low, 5.0, 0.6)

Ranges = dict[str, tuple[float, float, float]]


def damping_actions(damping: np.ndarray, modulus: np.ndarray | float, scene: Scene) -> np.ndarray:
    """Actions (n, 2) for the damping [1/s] and the modulus of the spring, clipped to what the actuators can do."""
    p = scene.params
    position = (np.log(damping) - p.damping_centre) / p.damping_half
    spring = (np.log(modulus) - p.modulus_centre) / p.modulus_half
    return np.clip(np.stack([position, np.broadcast_to(spring, position.shape)], axis=1), -1.0, 1.0)


def force_actions(acceleration: np.ndarray, scene: Scene) -> np.ndarray:
    """Actions (n, 1) for the acceleration [m/s^2] that the force is to give."""
    return np.clip(acceleration / scene.params.push, -1.0, 1.0)[:, None]


def spring_force(travel: np.ndarray, modulus: float, scene: Scene) -> np.ndarray:
    """Acceleration [m/s^2] that makes the passive spring, whose modulus is 1, one of the given modulus."""
    return (1.0 - modulus) * scene.params.w2 * travel


def settings(position: np.ndarray, scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Damping [1/s] and modulus at the actuators' positions (n, 2)."""
    p = scene.params
    damping = np.exp(p.damping_centre + p.damping_half * position[:, 0])
    return damping, np.exp(p.modulus_centre + p.modulus_half * position[:, 1])


def away_from_zero(values: np.ndarray, least: float) -> np.ndarray:
    """`values`, those smaller than `least` replaced by it: something to divide by."""
    return np.where(np.abs(values) < least, least, values)


def serves_damper(scene: Scene) -> bool:
    """Whether there is a damper between mass and wheel whose damping is the action."""
    return not scene.params.active and bool(scene.params.relative)


class RideLaw:
    """A law of the ride. Subclasses say what the suspension does; where the speed is free it keeps to the schedule."""

    TUNABLE: ClassVar[Ranges]

    def __init__(self, scene: Scene, **gains: float) -> None:
        """`gains`: any of `TUNABLE`, name -> (low, high, default)."""
        self.scene = scene
        self.gains = {name: gains.get(name, default) for name, (_, _, default) in self.TUNABLE.items()}

    @staticmethod
    def serves(scene: Scene) -> bool:
        """Whether the law makes sense in `scene`; the ladder leaves it out where it does not."""
        return True

    def reset(self, n: int) -> None:
        """Nothing to forget."""

    def suspension(self, reading: Reading) -> np.ndarray:
        """Actions of the suspension, (n, 2) or (n, 1), within [-1, 1]."""
        raise NotImplementedError

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        """Actions for observations (n, width)."""
        reading = read(observations, self.scene)
        actions, cruise = self.suspension(reading), self.scene.options["cruise"]
        if cruise is not None:
            wanted = cruise.schedule + reading.lateness / CATCH_UP
            share = (wanted - cruise.slowest) / (cruise.fastest - cruise.slowest)
            actions = np.column_stack([actions, np.clip(2.0 * share - 1.0, -1.0, 1.0)])
        return actions.astype(np.float32)
