"""The ground of a Chipmunk space: the pieces of a road or of sines that a wheel covers in a short time."""

from __future__ import annotations

import math

import numpy as np
import pymunk

from vr_envs.models.jit import kernel
from vr_envs.models.road import pass_knot, slope_of_road
from vr_envs.models.terrain import roll_undulation, undulation_ahead

FACET = 8.0  # steps on one straight piece of a sine
DEPTH = 0.05  # m, half the thickness of the ground, more than any step can penetrate
REACH = 1.0  # m, by which the piece under the wheel goes on beyond its ends
Point = tuple[float, float]


@kernel
def path_ahead(state, distance, facet, undulation, road, profile, bumps, obstacle, wheel, corners):
    """Write the corners (place, height) of the path of the wheel from behind it to `distance` [m] ahead or beyond.

    Both are in m, from where the wheel is. Sines are cut into pieces of at most `facet` [m]. The wheel on the record
    moves to `distance`. Returns the number of corners.
    """
    place, length, height, rise, count, pieces = 0.0, distance, 0.0, 0.0, 0, 1
    if road is not None:
        length = road.knot_spacing
        place = state.to_knot - length
        height = slope_of_road(state, road) * place
    if undulation is not None:
        pieces = math.ceil(length / facet)
    while True:
        if road is not None:
            rise = slope_of_road(state, road) * length
        for i in range(pieces + 1):
            corners[count + i, 0] = place + length * i / pieces
            corners[count + i, 1] = height + rise * i / pieces
        count += pieces
        place, height = place + length, height + rise
        if road is None or place > distance:
            break
        pass_knot(state, road, profile, bumps, obstacle, wheel)
    if road is not None:
        state.to_knot = place - distance
    if undulation is not None:
        level = undulation_ahead(state, 0.0, undulation)
        for i in range(count + 1):
            corners[i, 1] += undulation_ahead(state, corners[i, 0], undulation) - level
        roll_undulation(state, distance, undulation)
    state.distance += distance
    return count + 1


class Ground:
    """A body that runs backwards under the wheel, and the piece of it on which the wheel is.

    `heights`: of the path in the middle of each step; `end`: after the last one; `rate`: the speed (m/s) at which the
    path rises now; `change`: by which that differs between the pieces, m/s. Heights are in m from the present one.
    """

    def __init__(self, state: np.void, ways: np.ndarray, dt: float, options: tuple[np.void | None, ...]) -> None:
        """The ground on which the wheel of `state` covers `ways`, and which the record then has behind it.

        Args:
            state: a ride's; its terrain moves on, and its distance.
            ways: m, shape (steps + 2,): half a step ago, in the middle of each step `dt` (s), and at the end.
            dt: s.
            options: records of undulation, road, profile, bumps, obstacle and wheel, or None.
        """
        distance = float(ways[-1])
        facet = FACET * float(np.diff(ways[:-1]).min())
        road = options[1]
        pieces = 1.0 if road is None else distance / float(road["knot_spacing"]) + 3.0
        length = distance if road is None else float(road["knot_spacing"])
        corners = np.empty((math.ceil(pieces * (length / facet + 2.0)), 2))
        corners = corners[: path_ahead(state, distance, facet, *options, corners)]
        x, y = corners.T
        self.corners, self.slopes = corners, np.diff(y) / np.diff(x)
        self.pieces = np.searchsorted(x[1:-1], ways[1:-1], side="right").tolist()
        self.heights = np.interp(ways[1:-1], x, y).tolist()
        self.end = float(np.interp(distance, x, y))
        self.speeds = (np.diff(ways[:-1]) / dt).tolist()
        self.rate = self.speeds[0] * float(self.slopes[self.pieces[0]])
        self.change = max(self.speeds) * float(np.ptp(self.slopes))
        self.body = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        self.body.position = -float(ways[0]), 0.0

    def lay(self, space: pymunk.Space, depth: float) -> None:
        """Put the ground into a space: the surface of a piece is `depth` (m) below the path, along its normal."""
        down = np.stack([self.slopes, -np.ones(len(self.slopes))], axis=1) / np.hypot(self.slopes, 1.0)[:, None]
        beyond = REACH * np.stack([-down[:, 1], down[:, 0]], axis=1)
        core = (depth + DEPTH) * down
        left, right = self.corners[:-1] + core - beyond, self.corners[1:] + core + beyond
        self.ends: list[tuple[Point, Point]] = [
            ((a, b), (c, d)) for (a, b), (c, d) in zip(left.tolist(), right.tolist(), strict=True)
        ]
        self.now = self.pieces[0]
        begin, end = self.ends[self.now]
        self.surface = pymunk.Segment(self.body, begin, end, DEPTH)
        space.add(self.body, self.surface)

    def roll(self, step: int) -> None:
        """Make ready for a step: the speed, and the piece that will be under the wheel in its middle."""
        self.body.velocity = -self.speeds[step], 0.0
        if self.pieces[step] != self.now:
            self.now = self.pieces[step]
            begin, end = self.ends[self.now]
            self.surface.unsafe_set_endpoints(begin, end)
