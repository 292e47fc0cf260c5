"""Pictures of an aircraft under its autopilot: what it was asked for and did, its attitude and its heading."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from vr_envs.models.atmosphere import airspeed
from vr_envs.models.autopilot import wrap
from vr_envs.models.load_factor import bank
from vr_envs.render.base import Painter
from vr_envs.render.canvas import Box, Point
from vr_envs.render.chart import History, Strip, fitted
from vr_envs.render.style import (
    BLUE,
    GREY,
    GROUND,
    INK,
    MARGIN,
    ORANGE,
    PALE_BLUE,
    PANEL,
    RED,
    RULE,
    SMALL,
    WIDTH,
    signed,
)

if TYPE_CHECKING:
    from vr_envs.envs.scene import Scene

SPAN = 120.0  # s, of the strip charts
# name, unit, least length of the axis
CHANNELS = (("Altitude", "m", 100.0), ("Airspeed", "m/s", 10.0), ("Heading", "\N{DEGREE SIGN}", 20.0))
STRIP_LEFT, STRIP_WIDTH, STRIP_HEIGHT, STRIP_PITCH = 66.0, 360.0, 84.0, 112.0
DIAL = 52.0  # points, radius
MAP = 0.8 * DIAL  # points: the ground track of the strips' time fits into this radius
WIND = 24.0  # points, length of its arrow
PATH_SCALE = DIAL / math.radians(20.0)  # points per radian of climb angle


class AutopilotPainter(Painter):
    """Draws a state with the last two minutes of the episode, as far as it was drawn."""

    TITLE = "Autopilot"

    def __init__(self, scene: Scene, render_mode: str) -> None:
        """See `Painter`."""
        super().__init__(scene, render_mode)
        self._history = History(SPAN)
        self._key: int | None = None
        self._atmosphere = scene.records()[1][list(scene.options).index("atmosphere")]

    def paint(self, state: np.void) -> None:
        """Draw a state."""
        time = int(state["steps"]) * self.scene.params.dt
        self._remember(time, state)
        self.heading(f"t = {time:.0f} s")
        rows = self._history.table()
        for channel in range(3):
            self._strip(channel, time, rows)
        ends = (STRIP_LEFT, f"{SPAN:g} s ago", "left"), (STRIP_LEFT + STRIP_WIDTH, "now", "right")
        for x, label, align in ends:
            self.canvas.text(label, (x, 382.0), GREY, SMALL, align)
        self._attitude(state)
        self._rose(state, rows)
        if state["lost"]:
            self.canvas.text("left the envelope", (WIDTH - MARGIN, 44.0), RED, align="right")

    def _remember(self, time: float, state: np.void) -> None:
        """Append values and demands; headings run on through north, the demand the short way round from there."""
        if self._key != int(state["key"]):
            self._history, self._key = History(SPAN), int(state["key"])
        heading = float(state["heading"])
        if not self._history.starts_with(time):
            before = self._history.last()[3]
            heading = before + wrap(heading - before)
        demand = [float(d) for d in state["demand"]]
        demand[2] = heading + wrap(demand[2] - heading)
        speed = float(airspeed(state["altitude"], state["speed"], self._atmosphere))
        place = float(state["x"]), float(state["z"])
        self._history.add(time, float(state["altitude"]), speed, heading, *demand, *place)

    def _strip(self, channel: int, now: float, rows: np.ndarray) -> None:
        name, unit, least = CHANNELS[channel]
        times = rows[:, 0]
        values, demands = rows[:, 1 + channel], rows[:, 4 + channel]
        gap = " "
        if channel == 2:
            values, demands, gap = np.degrees(values), np.degrees(demands), ""
        low, high, step = fitted(np.concatenate([values, demands]), least)
        box = Box(STRIP_LEFT, 60.0 + STRIP_PITCH * channel, STRIP_WIDTH, STRIP_HEIGHT)
        strip = Strip(self.canvas, box, now, SPAN, low, high)
        for k in range(round((high - low) / step) + 1):
            value = low + k * step
            strip.rule(value, signed(f"{value % 360.0 if channel == 2 else value:g}"))
        strip.dashes(times, demands, ORANGE)
        strip.curve(times, values, BLUE, 2.0)
        x, y = strip.view(now, demands[-1])
        self.canvas.polygon([(x, y), (x + 9.0, y - 5.0), (x + 9.0, y + 5.0)], ORANGE)
        self.canvas.disc(strip.view(now, values[-1]), 3.5, BLUE)
        y = box.top - 12.0
        numbers = [v % 360.0 if channel == 2 else v for v in (values[-1], demands[-1])]
        digits = 1 if channel == 1 else 0
        self.canvas.text(name, (box.left, y), INK)
        self.canvas.text(f"{numbers[0]:.{digits}f}{gap}{unit}", (box.left + 190.0, y), BLUE, align="right")
        self.canvas.text(f"demand {numbers[1]:.{digits}f}{gap}{unit}", (box.right, y), ORANGE, align="right")

    def _attitude(self, state: np.void) -> None:
        """Climb angle, its sine v_y / v, and the bank of a coordinated turn."""
        cx, cy = centre = (WIDTH - MARGIN - 84.0, 118.0)
        rise, speed = float(state["vertical_speed"]), float(state["speed"])
        climb = math.atan2(rise, math.sqrt(max(0.0, speed * speed - rise * rise)))
        roll = bank(float(state["turn_rate"]), speed)
        # the sky's up, seen from the aircraft: y up
        ux, uy = -math.sin(roll), math.cos(roll)

        def point(along: float, up: float) -> Point:
            return cx + along * uy + up * ux, cy + along * ux - up * uy

        horizon = max(-DIAL, min(DIAL, -climb * PATH_SCALE))
        self.canvas.disc(centre, DIAL, PALE_BLUE)
        first = math.acos(horizon / DIAL)
        arc = np.linspace(first, 2.0 * math.pi - first, 60)
        self.canvas.polygon([point(DIAL * math.sin(a), DIAL * math.cos(a)) for a in arc], GROUND)
        half = math.sqrt(DIAL * DIAL - horizon * horizon)
        self.canvas.line([point(-half, horizon), point(half, horizon)], PANEL, 1.6)
        for degrees in (-10, -5, 5, 10):
            up = horizon + math.radians(degrees) * PATH_SCALE
            reach = 14.0 if degrees % 10 == 0 else 8.0
            if math.hypot(up, reach) < DIAL:
                self.canvas.line([point(-reach, up), point(reach, up)], PANEL, 1.2)
        for side in (-1.0, 1.0):
            self.canvas.line([(cx + side * 30.0, cy), (cx + side * 12.0, cy), (cx + side * 7.0, cy + 6.0)], INK, 3.0)
        self.canvas.disc(centre, 2.5, INK)
        self.canvas.ring(centre, DIAL, GREY, 1.5)
        turn = math.degrees(state["turn_rate"])
        self._note(cx, cy + DIAL + 14.0, f"climb {rise:+.1f} m/s")
        self._note(cx, cy + DIAL + 29.0, f"bank {math.degrees(roll):+.0f}\N{DEGREE SIGN}")
        self._note(cx, 354.0 + 14.0, f"turn {turn:+.1f} \N{DEGREE SIGN}/s")

    def _note(self, x: float, y: float, string: str) -> None:
        self.canvas.text(signed(string), (x, y), INK, SMALL, "centre")

    def _rose(self, state: np.void, rows: np.ndarray) -> None:
        """The compass card, heading up, with the ground track in it; the demand is a mark on its rim."""
        cx, cy = centre = (WIDTH - MARGIN - 84.0, 295.0)
        heading = float(state["heading"])

        def point(direction: float, radius: float) -> Point:
            return cx + radius * math.sin(direction - heading), cy - radius * math.cos(direction - heading)

        self.canvas.disc(centre, DIAL, PANEL)
        self.canvas.ring(centre, DIAL, RULE, 1.5)
        for degrees in range(0, 360, 10):
            direction = math.radians(degrees)
            inner = DIAL - (8.0 if degrees % 30 == 0 else 4.0)
            self.canvas.line([point(direction, inner), point(direction, DIAL - 1.0)], GREY)
            if degrees % 90 == 0:
                self.canvas.text(f"{degrees}", point(direction, DIAL - 18.0), GREY, SMALL, "centre")
        demand = float(state["demand"][2])
        mark = [point(demand - 0.11, DIAL + 8.0), point(demand + 0.11, DIAL + 8.0), point(demand, DIAL - 1.0)]
        self.canvas.polygon(mark, ORANGE)
        self.canvas.line([(cx, cy - DIAL + 1.0), (cx, cy - DIAL + 11.0)], BLUE, 2.5)
        if self.scene.options["track"] is not None:
            away = rows[:, 7:9] - rows[-1, 7:9]
            distance, direction = np.hypot(*away.T), np.arctan2(*away.T)
            scale = MAP / max(1.0, distance.max())
            track = [point(d, r * scale) for d, r in zip(direction, distance, strict=True)]
            self.canvas.line(track, PALE_BLUE, 2.0)
            self._wind(float(state["altitude"]), heading, (cx - DIAL - 14.0, cy - DIAL - 2.0))
        # the aircraft from above
        self.canvas.line([(cx, cy - 13.0), (cx, cy + 12.0)], BLUE, 3.0)
        self.canvas.polygon([(cx, cy - 6.0), (cx - 15.0, cy + 5.0), (cx + 15.0, cy + 5.0)], BLUE)
        self.canvas.polygon([(cx, cy + 7.0), (cx - 6.0, cy + 13.0), (cx + 6.0, cy + 13.0)], BLUE)

    def _wind(self, altitude: float, heading: float, centre: Point) -> None:
        """An arrow that blows with the wind at the aircraft, heading up, and its speed."""
        wind, shear = self.scene.options["wind"], self.scene.options["shear"]
        east = north = 0.0
        for part, speed in ((wind, wind and wind.speed), (shear, shear and shear.gradient * altitude)):
            if part is not None:
                east, north = east - speed * math.sin(part.origin), north - speed * math.cos(part.origin)
        if east == north == 0.0:
            return
        direction = math.atan2(east, north) - heading
        x, y = 0.5 * WIND * math.sin(direction), -0.5 * WIND * math.cos(direction)
        cx, cy = centre
        tip = cx + x, cy + y
        self.canvas.line([(cx - x, cy - y), tip], GREY, 1.6)
        for side in (-2.6, 2.6):
            barb = tip[0] + 6.0 * math.sin(direction + side), tip[1] - 6.0 * math.cos(direction + side)
            self.canvas.line([barb, tip], GREY, 1.6)
        self._note(cx, cy + 0.5 * WIND + 8.0, f"{math.hypot(east, north):.0f} m/s")


PAINTER = AutopilotPainter
