"""Bell's sink motion with the bounces held on their orbit in the fewest impacts."""

from __future__ import annotations

import numpy as np

from vr_envs.controllers.bar_design import Design
from vr_envs.controllers.bell_sink import BellSink
from vr_envs.envs.scene import Scene

VERTICAL = slice(2, 4)  # of a design's state: z and w
Z_PARTS = slice(4, 6)  # of an action
RANK = 1e-9


class VerticalDeadBeat(BellSink):
    """Bell's sink motion, whose z makes the bar meet the ball with the velocity that launches it as in period one.

    An impact launches the ball at v+ = (1 + alpha) U - alpha v-, U the bar's velocity. Two impacts fall in a base
    cycle, and both parts of z are free: they are chosen so that after the two the ball has height and velocity of the
    period-one orbit, by the linearised cycle map. Without a range of z, or where that orbit does not exist, it is the
    sink motion alone.
    """

    def __init__(self, scene: Scene, **gains: float) -> None:
        """`gains` are those of `BellSink`."""
        super().__init__(scene, **gains)
        self.design = Design(scene)
        width = len(self.design.units) + 6
        self.target, self.gain = np.zeros(width), np.zeros((2, width))
        try:
            orbit = self.design.orbit(self.action)
            a, b = self.design.matrices(orbit.map)
        except ValueError:
            return
        self.target = np.concatenate([orbit.ball / self.design.units, self.action])
        self.gain = np.linalg.pinv(b[VERTICAL, Z_PARTS], rcond=RANK) @ a[VERTICAL]

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        """Actions (n, 6) for observations (n, width)."""
        actions = np.tile(self.action.astype(float), (len(observations), 1))
        actions[:, Z_PARTS] -= (self.design.state(observations) - self.target) @ self.gain.T
        return np.clip(actions, -1.0, 1.0).astype(np.float32)
