"""A scene of the ball on a bar, linearised: what its laws are computed from."""

from __future__ import annotations

import math

import numpy as np

from vr_envs.envs.ball_on_bar import TASK
from vr_envs.envs.ball_on_bar_observation import FALL_SCALE, HEIGHT_SCALE, SPEED_SCALE
from vr_envs.envs.scene import Scene
from vr_envs.models.linearised import CycleMap, Linearised, Orbit, smooth

MOTION = slice(4, 10)  # of an observation: the present motion, as the action that asks for it


class Design:
    """The scene's cycle map in the units of observations and actions.

    A law sees the state s: the ball (x, u, z, w, and spin where there is one), then the present motion (6). What
    has no differentiable map of one cycle (scatter, frequencies of their own, ramps), and a sensor, is left out of it.
    """

    def __init__(self, scene: Scene) -> None:
        """Compiles the scene's kernels if they are not compiled yet."""
        params, options = scene.records()
        p = scene.params
        self.map = CycleMap(params, smooth(options), TASK.state)
        self.hold = float(p.hold)
        spans = (p.x_span, p.x_span, p.tilt_span, p.tilt_span, p.z_span, p.z_span)
        self.spans, self.centre = np.array(spans), np.array([0.0, 0.0, 0.0, 0.0, p.z_centre, 0.0])
        units = [p.half_length, SPEED_SCALE, HEIGHT_SCALE, FALL_SCALE, SPEED_SCALE]
        self.ball_columns = [0, 1, 2, 3, 10][: len(self.map.coordinates)]
        self.units = np.array(units[: len(self.ball_columns)])

    def motion(self, action: np.ndarray) -> np.ndarray:
        """The bar motion (6,) that an action asks for."""
        return self.centre + self.spans * action

    def orbit(self, action: np.ndarray) -> Orbit:
        """The period-one orbit of a constant action; a ValueError if there is none."""
        return self.map.orbit(self.motion(action))

    def growth(self, action: np.ndarray) -> float:
        """Growth rate of the horizontal motion at a constant action, over omega; infinite without period one."""
        try:
            return self.orbit(action).growth
        except ValueError:
            return math.inf

    def state(self, observations: np.ndarray) -> np.ndarray:
        """States s (n, k + 6) of observations (n, width)."""
        return np.concatenate([observations[:, self.ball_columns], observations[:, MOTION]], axis=1, dtype=float)

    def matrices(self, at: Linearised) -> tuple[np.ndarray, np.ndarray]:
        """A (k + 6, k + 6) and B (k + 6, 6) of s' = A s + B action over one control interval, from the map `at`.

        Over an interval of several cycles the bar keeps its motion after the first.

        Raises:
            ValueError: actions come every half a cycle, and the section is the start of a whole one.
        """
        if self.hold < 1.0:
            raise ValueError(f"no design for hold = {self.hold:g} cycles; give a whole number")
        k, rows = len(self.units), self.units[:, None]
        state, old, new = at.state * self.units / rows, at.old * self.spans / rows, at.new * self.spans / rows
        a, b = np.zeros((k + 6, k + 6)), np.zeros((k + 6, 6))
        a[:k, :k], a[:k, k:], b[:k], b[k:] = state, old, new, np.eye(6)
        kept = np.block([[state, old + new], [np.zeros((6, k)), np.eye(6)]])
        later = np.linalg.matrix_power(kept, round(self.hold) - 1)
        return later @ a, later @ b


def within_reach(action: np.ndarray, changes: np.ndarray) -> np.ndarray:
    """Actions (n, 6): `action` (6,) plus `changes` (n, 6), each shortened, not bent, to stay in the box.

    Cutting single parts off would turn a kick that pushes the ball back into another kick; a shorter one lies between
    the feedback and none.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        room = np.where(changes > 0.0, (1.0 - action) / changes, (-1.0 - action) / changes)
    share = np.fmin(1.0, np.where(changes == 0.0, np.inf, room).min(axis=1))
    return np.clip(action + share[:, None] * changes, -1.0, 1.0).astype(np.float32)
