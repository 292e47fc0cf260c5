"""Pictures of the terrain ride: ground, wheel, spring, damper and mass, the travel that is left, the acceleration.

The hub of a quarter car moves over the ground as its tyre gives way; a tyre off the ground is red.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from vr_envs.models.road import RING, place_on_road, road_height
from vr_envs.models.terrain import WAVES, undulation_ahead, wave
from vr_envs.models.terrain_ride import suspension
from vr_envs.render.base import Painter
from vr_envs.render.canvas import Box, Point, View
from vr_envs.render.chart import History, Strip, fitted, nice_step
from vr_envs.render.style import (
    BLUE,
    GREY,
    GROUND,
    HEIGHT,
    INK,
    MARGIN,
    ORANGE,
    PALE_BLUE,
    PALE_GROUND,
    PANEL,
    PAPER,
    RED,
    RULE,
    SMALL,
    WIDTH,
    mix,
    signed,
)

if TYPE_CHECKING:
    from vr_envs.envs.scene import Scene

SPAN = 5.0  # s, of the acceleration chart
WHEEL_X, GROUND_LEVEL = 230.0, 320.0  # points: the wheel, and the ground's mean height
WHEEL = 17.0  # points, radius
REST_LENGTH = 64.0  # points between carrier and mass at zero travel
MASS_HEIGHT = 34.0
SHORTEST = 16.0
SKY_LEVEL = 132.0  # point of the ceiling on which a damper of the mass's own velocity hangs
RISE = 70.0  # points for the highest ground and an ordinary travel
AHEAD_ON_WAVES = 30.0  # m of ground in view
AHEAD_ON_ROAD = 50  # knots of it, or more for a preview that reaches further


class TerrainRidePainter(Painter):
    """Draws a state, with the ground behind the wheel that earlier pictures have shown."""

    TITLE = "Terrain ride"

    def __init__(self, scene: Scene, render_mode: str) -> None:
        """See `Painter`."""
        super().__init__(scene, render_mode)
        road = scene.options["road"]
        self.ahead = AHEAD_ON_ROAD
        if road is not None and scene.options["preview"] is not None:
            reach = scene.params.speed * scene.options["preview"].horizon / road.knot_spacing
            self.ahead = min(RING - 4, max(AHEAD_ON_ROAD, math.ceil(1.05 * reach)))
        ahead = AHEAD_ON_WAVES if road is None else self.ahead * road.knot_spacing
        self.x_scale = (WIDTH - WHEEL_X) / ahead
        self._forget()

    def _forget(self) -> None:
        self._knots: dict[int, float] = {}  # heights of the road's knots, seen so far
        self._history = History(SPAN)
        self._seen = (-1, -1)

    def paint(self, state: np.void) -> None:
        """Draw a state."""
        key, steps = int(state["key"]), int(state["steps"])
        if self._seen[0] != key or steps < self._seen[1]:
            self._forget()
        self._seen = key, steps
        time = steps * self.scene.params.dt
        self._history.add(time, float(state["acceleration"]), float(state["weighted"]))
        magnification = self._magnification(state)
        view = View((WHEEL_X, GROUND_LEVEL), self.x_scale, self.x_scale * magnification)
        self.heading(f"t = {time:.2f} s")
        self._chart(time)
        self._settings(state)
        ground = self._ground(state, view)
        self._vehicle(state, view, ground)
        self._gauge(state)
        speed = self.scene.params.speed if self.scene.options["cruise"] is None else round(float(state["speed"]), 1)
        note = f"{speed:g} m/s, heights \N{MULTIPLICATION SIGN} {magnification:g}"
        self.canvas.text(note, (WIDTH - MARGIN, 141.0), GREY, SMALL, "right")

    def _magnification(self, state: np.void) -> float:
        """How many times larger heights are drawn than lengths: 1, 2, 5 times a power of ten."""
        bumps, waves = self.scene.options["bumps"], self.options["undulation"]
        highest = self.scene.params.rattle + 2.0 * float(state["roughness_sd"]) + (0.0 if bumps is None else bumps.high)
        if waves is not None:
            highest += sum(wave(i, waves)[0] for i in range(WAVES))
        return 1.0 / nice_step(highest * self.x_scale / RISE)

    def _profile(self, state: np.void) -> tuple[np.ndarray, np.ndarray]:
        """Distances ahead of the wheel (m), from left to right, and the heights of the ground there (m)."""
        road, waves = self.options["road"], self.options["undulation"]
        left, right = -WHEEL_X / self.x_scale, (WIDTH - WHEEL_X) / self.x_scale
        if road is None:
            distances = np.linspace(left, right, 160)
            heights = np.zeros(len(distances))
        else:
            spacing, place, knot = self.scene.options["road"].knot_spacing, place_on_road(state, road), state["knot"]
            for k in range(self.ahead + 3):
                self._knots[int(knot) + k] = road_height(state, float(k))
            oldest = int(knot) + math.floor(left / spacing)
            self._knots = {k: height for k, height in self._knots.items() if k >= oldest}
            numbers = sorted(self._knots)
            distances = (np.array(numbers) - float(knot) - place) * spacing
            heights = np.array([self._knots[k] for k in numbers])
        if waves is not None:
            heights += [undulation_ahead(state, float(d), waves) for d in distances]
        return distances, heights

    def _ground(self, state: np.void, view: View) -> float:
        """Draw the ground; its height under the wheel (m)."""
        canvas = self.canvas
        distances, heights = self._profile(state)
        line = [view(float(d), float(h)) for d, h in zip(distances, heights, strict=True)]
        # before the first knot that was seen nothing is known
        line.insert(0, (min(0.0, line[0][0]), line[0][1]))
        canvas.polygon([*line, (WIDTH, HEIGHT), (0.0, HEIGHT)], PALE_GROUND)
        canvas.line(line, GROUND, 2.5)
        preview = self.scene.options["preview"]
        if preview is not None:
            reach = self.scene.params.speed * preview.horizon
            known = np.append(distances[(distances > 0.0) & (distances < reach)], reach)
            points = [view(float(d), float(np.interp(d, distances, heights))) for d in (0.0, *known)]
            canvas.line(points, ORANGE, 2.5)
            x, y = points[-1]
            canvas.text(f"preview {preview.horizon:g} s", (x, y + 13.0), ORANGE, SMALL, "right")
        travelled = float(state["distance"])
        step = nice_step(60.0 / self.x_scale)
        for k in range(
            math.ceil((travelled + distances[0]) / step), math.floor((travelled + distances[-1]) / step) + 1
        ):
            x, _ = view(k * step - travelled, 0.0)
            canvas.text(f"{k * step:g} m", (x, HEIGHT - 30.0), GROUND, SMALL, "centre")
            canvas.line([(x, HEIGHT - 42.0), (x, HEIGHT - 37.0)], GROUND)
        return float(np.interp(0.0, distances, heights))

    def _vehicle(self, state: np.void, view: View, ground: float) -> None:
        canvas, p = self.canvas, self.scene.params
        tyre = self.scene.options["tyre"] is not None
        x, y = view(0.0, ground + (float(state["deflection"]) if tyre else 0.0))
        carrier = y - 2.0 * WHEEL - 7.0
        mass = carrier - max(SHORTEST, REST_LENGTH + float(state["travel"]) * view.y_scale)
        top = mass - MASS_HEIGHT
        stiff, hard = (0.5 * (float(v) + 1.0) for v in (state["held"][1], state["held"][0]))
        if p.actuation == "active":
            stiff, hard = 0.5, 0.2
        canvas.line([(x, y - WHEEL), (x, carrier)], INK, 4.0)
        canvas.line([(x - 26.0, carrier), (x + 26.0, carrier)], INK, 4.0)
        canvas.disc((x, y - WHEEL), WHEEL, RED if tyre and state["airborne"] else INK)
        canvas.disc((x, y - WHEEL), 0.62 * WHEEL, PANEL)
        angle = float(state["distance"]) * self.x_scale / WHEEL
        for k in range(3):
            dx, dy = (
                0.6 * WHEEL * math.cos(angle + k * math.pi / 3.0),
                0.6 * WHEEL * math.sin(angle + k * math.pi / 3.0),
            )
            canvas.line([(x - dx, y - WHEEL - dy), (x + dx, y - WHEEL + dy)], GREY, 1.5)
        self._spring((x - 19.0, carrier - 2.0), mass, stiff)
        if p.damping == "absolute" and p.actuation != "active":
            canvas.line([(x - 10.0, SKY_LEVEL), (x + 48.0, SKY_LEVEL)], GREY, 2.0)
            self._damper((x + 19.0, top), min(SKY_LEVEL, top - SHORTEST), hard)
        else:
            self._damper((x + 19.0, carrier - 2.0), mass, hard)
        touching = state["side"] != 0.0
        canvas.box(Box(x - 50.0, top, 100.0, MASS_HEIGHT), RED if touching else BLUE, 5.0)
        canvas.text(f"{p.mass:g} kg", (x, 0.5 * (top + mass)), PANEL, SMALL, "centre")
        if p.actuation == "active":
            push = float(state["held"][0])
            ends = [(x, top - 4.0), (x, top - 4.0 - 34.0 * abs(push))]
            tail, tip = ends if push > 0.0 else ends[::-1]
            canvas.arrow(tail, tip, ORANGE, 4.0, 9.0)

    def _spring(self, foot: Point, top: float, share: float) -> None:
        """A zigzag from `foot` up to `top`, thicker the stiffer: `share` in [0, 1]."""
        x, y = foot
        turns = 7
        points = [(x, y)]
        for k in range(turns):
            side = 11.0 if k % 2 else -11.0
            points.append((x + side, y + (top - y) * (k + 1.0) / (turns + 1.0)))
        points.append((x, top))
        self.canvas.line(points, mix(BLUE, INK, share), 1.5 + 3.0 * share)

    def _damper(self, foot: Point, top: float, share: float) -> None:
        """A cylinder on `foot` and a rod up to `top`; the oil is darker the harder the damping: `share` in [0, 1]."""
        x, y = foot
        length = min(38.0, 0.8 * (y - top))
        self.canvas.box(Box(x - 9.0, y - length, 18.0, length), GREY, 2.0)
        self.canvas.box(Box(x - 7.0, y - length + 2.0, 14.0, length - 4.0), mix(PAPER, INK, 0.1 + 0.75 * share), 1.0)
        piston = y - min(0.5 * length, 0.4 * (y - top))
        self.canvas.line([(x, piston), (x, top)], INK, 3.0)
        self.canvas.line([(x - 6.0, piston), (x + 6.0, piston)], INK, 3.0)

    def _gauge(self, state: np.void) -> None:
        """Travel of the spring between its stops."""
        canvas, stop = self.canvas, self.scene.options["stop"]
        limit = 3.0 * self.scene.params.rattle if stop is None else stop.travel
        most = limit if stop is None else limit + stop.crush
        top, bottom, x = 156.0, 276.0, 62.0
        view = View((x, 0.5 * (top + bottom)), 0.0, 0.5 * (bottom - top) / most)
        canvas.text("Travel (mm)", (MARGIN, top - 17.0), GREY, SMALL)
        canvas.box(Box(x, top, 12.0, bottom - top), PANEL)
        if stop is not None:
            height = view.y_scale * stop.crush
            for y in (top, bottom - height):
                canvas.box(Box(x, y, 12.0, height), mix(RED, PANEL, 0.55))
        for value in (-limit, 0.0, limit):
            _, y = view(0.0, value)
            canvas.line([(x, y), (x + 12.0, y)], GREY)
            canvas.text(signed(f"{1e3 * value:g}"), (x - 5.0, y), GREY, SMALL, "right")
        travel = float(state["travel"])
        _, y = view(0.0, max(-most, min(most, travel)))
        colour = RED if abs(travel) > limit else BLUE
        canvas.polygon([(x + 8.0, y), (x + 19.0, y - 5.5), (x + 19.0, y + 5.5)], colour)
        canvas.text(signed(f"{1e3 * travel:+.0f}"), (x + 23.0, y), colour, SMALL)
        if stop is not None:
            canvas.text(f"{int(state['hits'])} stop hits", (MARGIN, bottom + 14.0), GREY, SMALL)
        if self.scene.options["tyre"] is not None:
            canvas.text(f"{int(state['liftoffs'])} lift-offs", (MARGIN, bottom + 28.0), GREY, SMALL)

    def _settings(self, state: np.void) -> None:
        """What the actuators are set to, each on a scale between its limits."""
        p = self.scene.params
        gamma, w2, _ = suspension(state, self.params)
        if p.actuation == "active":
            force = p.force * float(state["held"][0])
            rows = [("Force", signed(f"{force:+.0f} N"), float(state["held"][0]))]
        else:
            damping, spring = (float(v) for v in state["held"])
            rows = [
                ("Spring", f"{1e-3 * w2 * p.mass:.1f} kN/m", spring),
                ("Damper", f"{1e-3 * gamma * p.mass:.2f} kN s/m", damping),
            ]
        for k, (name, value, position) in enumerate(rows):
            left, right, y = 450.0, WIDTH - MARGIN, 64.0 + 40.0 * k
            self.canvas.text(name, (left, y), INK, SMALL)
            self.canvas.text(value, (right, y), BLUE, SMALL, "right")
            self.canvas.line([(left, y + 14.0), (right, y + 14.0)], RULE, 5.0)
            at = left + 0.5 * (position + 1.0) * (right - left)
            self.canvas.disc((at, y + 14.0), 6.0, BLUE)

    def _chart(self, now: float) -> None:
        """Acceleration of the mass, and as a person feels it."""
        rows = self._history.table()
        low, high, step = fitted(rows[:, 1:], 4.0)
        box = Box(48.0, 58.0, 360.0, 62.0)
        strip = Strip(self.canvas, box, now, SPAN, low, high)
        for k in range(round((high - low) / step) + 1):
            strip.rule(low + k * step, signed(f"{low + k * step:g}"))
        strip.curve(rows[:, 0], rows[:, 1], PALE_BLUE, 1.5)
        strip.curve(rows[:, 0], rows[:, 2], BLUE, 1.8)
        self.canvas.text(
            f"Acceleration of the mass (m/s\N{SUPERSCRIPT TWO}), last {SPAN:g} s", (MARGIN, 46.0), GREY, SMALL
        )
        self.canvas.text("as felt (Wk)", (box.right, 46.0), BLUE, SMALL, "right")


PAINTER = TerrainRidePainter
