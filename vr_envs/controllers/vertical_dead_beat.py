"""Bell's sink motion with the bounces brought back to their orbit in the fewest impacts that the bar can manage."""

from __future__ import annotations

import numpy as np

from vr_envs.controllers.bar_design import Design, within_reach
from vr_envs.controllers.bell_sink import BellSink
from vr_envs.envs.scene import Scene

VERTICAL = [2, 3]  # z and w in a design's state
Z_PARTS = slice(4, 6)  # of an action
CYCLES = 2  # in which the bounces are brought back


def dead_beat_plan(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The z actions (CYCLES, 2, width) per deviation s that bring height and velocity back after `CYCLES` cycles.

    `a`, `b`: as `Design.matrices`. Two actions of two parts for two conditions: the smallest that do it. Only the
    vertical deviation and the present z motion count; what the bar's tilt adds away from its centre is left out.
    """
    width = len(a)
    vertical = [*VERTICAL, width - 2, width - 1]
    reached = np.hstack([(np.linalg.matrix_power(a, CYCLES - 1 - k) @ b[:, Z_PARTS])[VERTICAL] for k in range(CYCLES)])
    plan = np.zeros((2 * CYCLES, width))
    plan[:, vertical] = -np.linalg.pinv(reached) @ np.linalg.matrix_power(a, CYCLES)[np.ix_(VERTICAL, vertical)]
    return plan.reshape(CYCLES, 2, width)


class VerticalDeadBeat(BellSink):
    """Bell's sink motion, whose z makes the bar meet the ball with the velocities that launch it as in period one.

    An impact launches the ball at v+ = (1 + alpha) U + alpha |v-|, U the bar's velocity. Both parts of z in the next
    two base cycles, four impacts, are chosen so that the ball then has the height and velocity of the period-one
    orbit of the exact map's linearisation, with the smallest change of the motion; in one cycle it would take far
    more than the bar has. The first action of that plan is taken, and the plan made anew. Without a range of z,
    where that orbit does not exist, or with actions every half cycle, it is the sink motion alone.
    """

    def __init__(self, scene: Scene, **gains: float) -> None:
        """`gains` are those of `BellSink`."""
        super().__init__(scene, **gains)
        self.design = Design(scene)
        width = len(self.design.units) + 6
        self.target, self.gain = np.zeros(width), np.zeros((2, width))
        try:
            orbit = self.design.orbit(self.action)
            matrices = self.design.matrices(orbit.map)
        except ValueError:
            return
        self.target = np.concatenate([orbit.ball / self.design.units, self.action])
        self.gain = dead_beat_plan(*matrices)[0]

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        """Actions (n, 6) for observations (n, width)."""
        changes = np.zeros((len(observations), 6))
        changes[:, Z_PARTS] = (self.design.state(observations) - self.target) @ self.gain.T
        return within_reach(self.action, changes)
