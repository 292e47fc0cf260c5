"""The ground of a Chipmunk space: the pieces of a road or of sines that a wheel covers in a short time."""

from __future__ import annotations

import math

import numpy as np
import pymunk

from vr_envs.models.jit import kernel
from vr_envs.models.record import dtype_of
from vr_envs.models.road import RoadAlone, draw_road, pass_knot, slope_of_road
from vr_envs.models.terrain import roll_undulation, undulation_ahead

FACET = 8.0  # steps on one straight piece of a sine
DEPTH = 0.05  # m, half the thickness of the ground, more than any step can penetrate
REACH = 1.0  # m, by which the piece under the wheel goes on beyond its ends
RADIUS = 0.05  # m, of the circle of a wheel that is a point; it has no effect
Point = tuple[float, float]
Options = tuple[np.void | None, ...]


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
        pass_knot(state, True, road, profile, bumps, obstacle, wheel)
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

    `heights`: of the wheel's path in the middle of each step; `end`: after the last one; `rate`: the speed (m/s) at
    which the path rises now; `change`: by which that differs on the way, m/s. Heights are in m from the present one.
    """

    def __init__(self, state: np.void, ways: np.ndarray, dt: float, options: Options) -> None:
        """The ground on which the wheel of `state` covers `ways`, and which the record then has behind it.

        Args:
            state: a ride's; its terrain moves on, and its distance.
            ways: m, shape (steps + 2,): half a step ago, in the middle of each step `dt` (s), and at the end.
            dt: s.
            options: records of undulation, road, profile, bumps, obstacle and wheel, or None.
        """
        self.speeds = (np.diff(ways[:-1]) / dt).tolist()
        self.body = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        self.body.position = -float(ways[0]), 0.0
        corners = self._corners(state, ways, options)
        x, y = corners.T
        self.corners, self.slopes = corners, np.diff(y) / np.diff(x)
        self.pieces = np.searchsorted(x[1:-1], ways[1:-1], side="right").tolist()
        self.heights = np.interp(ways[1:-1], x, y).tolist()
        self.end = float(np.interp(ways[-1], x, y))
        self.rate = self.speeds[0] * float(self.slopes[self.pieces[0]])
        self.change = max(self.speeds) * float(np.ptp(self.slopes))

    def _corners(self, state: np.void, ways: np.ndarray, options: Options) -> np.ndarray:
        distance, facet, road = float(ways[-1]), FACET * float(np.diff(ways[:-1]).min()), options[1]
        length = distance if road is None else float(road["knot_spacing"])
        corners = np.empty((math.ceil((distance / length + 3.0) * (length / facet + 2.0)), 2))
        return corners[: path_ahead(state, distance, facet, *options, corners)]

    def lay(self, space: pymunk.Space, overlap: float) -> float:
        """Put the ground into a space, for a wheel that is to lie an `overlap` (m) deep in it; that wheel's radius.

        The surface of a piece is one radius, less the overlap, below the wheel's path, along its normal.
        """
        down = np.stack([self.slopes, -np.ones(len(self.slopes))], axis=1) / np.hypot(self.slopes, 1.0)[:, None]
        beyond = REACH * np.stack([-down[:, 1], down[:, 0]], axis=1)
        core = (RADIUS - overlap + DEPTH) * down
        left, right = self.corners[:-1] + core - beyond, self.corners[1:] + core + beyond
        self.ends: list[tuple[Point, Point]] = [
            ((a, b), (c, d)) for (a, b), (c, d) in zip(left.tolist(), right.tolist(), strict=True)
        ]
        self.now = self.pieces[0]
        begin, end = self.ends[self.now]
        self.surface = pymunk.Segment(self.body, begin, end, DEPTH)
        space.add(self.body, self.surface)
        return RADIUS

    def roll(self, step: int) -> None:
        """Make ready for a step: the speed, and the piece that will be under the wheel in its middle."""
        self.body.velocity = -self.speeds[step], 0.0
        if self.pieces[step] != self.now:
            self.now = self.pieces[step]
            begin, end = self.ends[self.now]
            self.surface.unsafe_set_endpoints(begin, end)


class Profiles:
    """The bare profiles of episodes: heights (m) of knots before a wheel of finite radius goes over them."""

    def __init__(self, options: Options) -> None:
        """`options` as for `Ground`."""
        self.options = *options[:5], None
        self.key: int | None = None
        self.heights = np.empty(0)

    def between(self, key: int, first: int, last: int) -> np.ndarray:
        """Heights of the knots `first` to `last`; the road before knot 0 is level."""
        if key != self.key or last >= len(self.heights):
            state = np.zeros(1, dtype_of(RoadAlone))[0]
            state["key"], self.key = key, key
            self.heights = np.empty(2 * last + 2)
            draw_road(state, self.heights, *self.options[1:])
        return self.heights[np.maximum(np.arange(first, last + 1), 0)]


class BareGround(Ground):
    """The profile itself, all of it that a wheel of finite radius may touch, as segments that meet."""

    def __init__(self, state: np.void, ways: np.ndarray, dt: float, options: Options, profiles: Profiles) -> None:
        """As for `Ground`, with a wheel among the `options`."""
        road, wheel = options[1], options[5]
        assert road is not None and wheel is not None  # a scene with a wheel has a road
        spacing, self.radius = float(road["knot_spacing"]), float(wheel["radius"])
        knot, place = int(state["knot"]), float(state["to_knot"]) - spacing
        back = math.ceil((self.radius - place) / spacing) + 1
        ahead = math.ceil((ways[-1] + self.radius - place) / spacing) + 1
        heights = profiles.between(int(state["key"]), knot - back, knot + ahead)
        x = place + spacing * np.arange(-back, ahead + 1)
        super().__init__(state, ways, dt, options)
        level = envelope(np.zeros(1), x, heights, self.radius)[0]
        self.profile = np.stack([x, heights - level - self.radius], axis=1)
        path = envelope(np.append(ways, 0.0), x, heights, self.radius) - level
        self.heights, self.end = path[1:-2].tolist(), float(path[-2])
        rates = np.diff(path[:-2]) / dt
        self.rate, self.change = float(rates[0]), float(np.ptp(rates))

    def lay(self, space: pymunk.Space, overlap: float) -> float:
        """As for `Ground`; it is the wheel that is larger by the overlap."""
        corners = [(a, b) for a, b in self.profile.tolist()]
        space.add(self.body)
        for before, begin, end, after in zip(corners, corners[1:], corners[2:], corners[3:], strict=False):
            segment = pymunk.Segment(self.body, begin, end, 0.0)
            segment.set_neighbors(before, after)
            space.add(segment)
        return self.radius + overlap

    def roll(self, step: int) -> None:
        """Make ready for a step: the speed."""
        self.body.velocity = -self.speeds[step], 0.0


def envelope(places: np.ndarray, x: np.ndarray, heights: np.ndarray, radius: float) -> np.ndarray:
    """Height (m) over its radius of the centre of a disc that stands on a polygon (x, heights), at `places` (m).

    The highest of all discs about points of the polygon: on each side of it the one that touches it, or an end.
    """
    slope = np.diff(heights) / np.diff(x)
    left, right = x[:-1] - places[:, None], x[1:] - places[:, None]
    touch = np.clip(radius * slope / np.hypot(slope, 1.0), left, right)
    near = np.abs(touch) < radius
    drop = radius - np.sqrt(np.where(near, radius**2 - touch**2, 0.0))
    return np.where(near, heights[:-1] + slope * (touch - left) - drop, -np.inf).max(axis=1)
