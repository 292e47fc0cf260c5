"""Linear-quadratic feedback about Bell's sink motion."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from scipy.linalg import solve_discrete_are

from vr_envs.controllers.bar_design import Design, within_reach
from vr_envs.controllers.bell_sink import BellSink, sink_action
from vr_envs.envs.scene import Scene


def riccati(
    a: np.ndarray, b: np.ndarray, state_cost: np.ndarray, action_cost: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(P, K): cost-to-go s'Ps and gain of the law action = -K s that minimises the sum of s'Qs + action'R action.

    Raises:
        numpy.linalg.LinAlgError: a mode that does not decay cannot be controlled.
    """
    p = solve_discrete_are(a, b, state_cost, action_cost)
    return p, np.linalg.solve(action_cost + b.T @ p @ b, b.T @ p @ a)


class LinearQuadratic:
    """All six parts of the bar's motion in proportion to the deviation from the orbit of Bell's sink motion.

    The gain minimises the sum over cycles of (x / reward width)^2 + effort |deviation of the action|^2 for the
    linearised cycle map. With a motion held over a cycle the two impacts meet opposite tilts, so it is its changes that
    kick the ball: the present motion is part of the state. Where there is no such gain (no period one, nothing that
    moves the ball along the bar, or actions every half cycle) the law is the sink motion.
    """

    TUNABLE: ClassVar[dict[str, tuple[float, float, float]]] = {
        **BellSink.TUNABLE,
        "effort": (1e-3, 1e4, 1.0),
        "z_effort": (1e-3, 1e4, 1.0),
    }

    def __init__(self, scene: Scene, **gains: float) -> None:
        """`effort` of x and tilt, `z_effort` of z: cost of a deviation by the whole range; the rest as `BellSink`."""
        gain = {name: gains.get(name, default) for name, (_, _, default) in self.TUNABLE.items()}
        self.design = Design(scene)
        accelerations = (gain[f"{name}_acceleration"] for name in ("x", "tilt", "z"))
        self.action = sink_action(self.design, scene, *accelerations)
        width = len(self.design.units) + 6
        self.target, self.gain = np.zeros(width), np.zeros((6, width))
        try:
            orbit = self.design.orbit(self.action)
            a, b = self.design.matrices(orbit.map)
            place = np.zeros(width)
            place[0] = scene.params.half_length / scene.params.reward_width
            effort = np.diag([gain["effort"]] * 4 + [gain["z_effort"]] * 2)
            _, self.gain = riccati(a, b, np.outer(place, place), effort)
        except (ValueError, np.linalg.LinAlgError):
            return
        self.target = np.concatenate([orbit.ball / self.design.units, self.action])

    def reset(self, n: int) -> None:
        """Nothing to forget."""

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        """Actions (n, 6) for observations (n, width)."""
        return within_reach(self.action, (self.target - self.design.state(observations)) @ self.gain.T)
