"""Pictures of a ball on a bar: bar and ball from the side, the bar's phasors, and where the ball has been.

Between two states the ball's path is that of the scene's engine: the interval is run again up to each instant shown.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vr_envs.envs.world import simulator_of
from vr_envs.models.ball_on_bar import interval
from vr_envs.models.bar import Frame
from vr_envs.models.drive import bar_at, base_cycle
from vr_envs.render.base import Painter
from vr_envs.render.canvas import Box, Point, View
from vr_envs.render.chart import History, Strip, nice_step
from vr_envs.render.style import (
    BLUE,
    GREY,
    INK,
    MARGIN,
    ORANGE,
    PALE_ORANGE,
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

BAR_LEVEL = 232.0  # point of the bar's mean height
BALL = 8.0  # points, radius; the ball's lowest point is the model's ball
TOP = 40.0  # point below which the scene begins
SCENE = Box(0.0, TOP, WIDTH, BAR_LEVEL + 40.0 - TOP)  # what is drawn to scale stays in it
HEADROOM = 165.0  # points for twice the height of the period-one bounce, and the sag of a curved bar
TRAIL_CYCLES, TRAIL_PARTS = 4.0, 24
CHART_SPAN = 10.0  # s
CURVE_POINTS = 33
DIAL = 28.0  # points, radius: the largest amplitude that an action can ask for


class Moment(NamedTuple):
    """What is to be seen at one instant."""

    time: float  # s since the start of the episode
    since: float  # s since the start of the base cycle
    ball: np.void  # state, as it is by then
    bar: Frame


class BallOnBarPainter(Painter):
    """Draws a state at the start of its control interval; `frames` draws the instants between two states."""

    TITLE = "Ball on a bar"

    def __init__(self, scene: Scene, render_mode: str) -> None:
        """See `Painter`."""
        super().__init__(scene, render_mode)
        self._simulator = simulator_of("ball_on_bar", scene)
        p = scene.params
        x_scale = 0.5 * (WIDTH - 4 * MARGIN) / p.half_length
        bounce = p.gravity * p.period**2 / 32.0  # height of a flight of half a base cycle
        curve = scene.options["curve"]
        sag = 0.0 if curve is None else 0.5 * abs(curve.curvature) * p.half_length**2
        self.magnification = 1.0 / nice_step((2.0 * bounce + sag) * x_scale / HEADROOM)
        self.view = View((0.5 * WIDTH, BAR_LEVEL), x_scale, self.magnification * x_scale)
        self.interval = p.hold * p.period
        self._forget()

    def paint(self, state: np.void) -> None:
        """Draw a state; the trail since the state drawn before, if one interval back, is the exact path."""
        self._begin(state)
        before = self._before
        if before is not None and before["steps"] + 1 == state["steps"]:
            for moment in self._between(before, state, TRAIL_PARTS):
                self._remember(moment)
        self._finish(state)

    def frames(self, before: np.void, after: np.void, n: int) -> Iterator[np.ndarray | None]:
        """`n` pictures of the interval from state `before` to state `after`, the last one of `after`: slow motion.

        Both are states of one episode, one interval apart. Each picture is what `draw` gives.
        """
        self._begin(before)
        parts = n * math.ceil(TRAIL_PARTS / n)
        for k, moment in enumerate(self._between(before, after, parts), 1):
            self._remember(moment)
            if k % (parts // n) == 0:
                self.canvas.clear()
                if k == parts:
                    self._finish(after)
                else:
                    self._draw(moment)
                yield self.deliver()

    def _between(self, before: np.void, after: np.void, parts: int) -> Iterator[Moment]:
        """The `parts` equally spaced instants after `before` up to `after`."""
        old, new = tuple(before["motion"].tolist()), tuple(after["motion"].tolist())
        for k in range(1, parts + 1):
            s = self.interval * k / parts
            ball = before.copy()
            if self._simulator is None:
                interval(ball, new, self.params, *self.options.values(), None, s)
            else:
                self._simulator.interval(ball, new, s)
            # the last time is exactly that of `after`
            yield self._moment((int(before["steps"]) + k / parts) * self.interval, s, ball, old, int(before["steps"]))

    def _moment(self, time: float, s: float, ball: np.void, old: tuple[float, ...], steps: int) -> Moment:
        """The moment `s` after the start of interval number `steps`, when the bar began to leave the motion `old`."""
        number, begin = base_cycle(steps, self.params)
        new = tuple(ball["motion"].tolist())
        passed = int((begin + s) // self.params["period"])
        since = begin + s - passed * self.params["period"]
        from_motion, from_time = (new, 0.0) if passed else (old, begin)
        drive = self.options["frequencies"], self.options["ramp"]
        bar = bar_at(from_motion, new, since, from_time, number + passed, self.params, *drive)
        return Moment(time, since, ball, bar)

    def _begin(self, state: np.void) -> None:
        """Forget what was drawn if `state` is of another episode, or earlier in the same one."""
        last = self._before
        if last is not None and (last["key"] != state["key"] or last["steps"] > state["steps"]):
            self._forget()

    def _forget(self) -> None:
        self._trail = History(TRAIL_CYCLES * self.scene.params.period)
        self._places = History(CHART_SPAN)
        self._before: np.void | None = None

    def _remember(self, moment: Moment) -> None:
        self._trail.add(moment.time, float(moment.ball["x"]), float(moment.ball["z"]))

    def _finish(self, state: np.void) -> None:
        """Draw the state itself and remember it."""
        motion = tuple(state["motion"].tolist())
        steps = int(state["steps"])
        time = steps * self.interval
        self._before = state.copy()
        moment = self._moment(time, 0.0, self._before, motion, steps)
        self._remember(moment)
        self._places.add(time, float(state["x"]))
        self._draw(moment)

    def _draw(self, moment: Moment) -> None:
        state = moment.ball
        self.heading(f"t = {moment.time:.3f} s")
        self._ruler()
        self._path(moment.time)
        self._bar(moment.bar)
        self._ball(state)
        self._dials(moment)
        self._chart(moment.time)
        notes = [signed(f"x = {1e3 * state['x']:+.2f} mm"), f"{int(state['impacts'])} impacts"]
        if state["lost"]:
            notes.append("lost")
        elif state["fault"]:
            notes.append("fault")
        elif state["resting"]:
            notes.append("at rest on the bar")
        for k, note in enumerate(notes):
            self.canvas.text(note, (WIDTH - MARGIN, 50 + 17 * k), RED if k == 2 else INK, SMALL, "right")

    def _ruler(self) -> None:
        """Distance along the bar, and the scale of heights."""
        canvas, half = self.canvas, self.params["half_length"]
        y = BAR_LEVEL + 46.0
        step = nice_step(half / 6.0)
        count = int(half / step * (1.0 + 1e-9))
        canvas.line([self._ruler_point(-half, y), self._ruler_point(half, y)], GREY)
        for k in range(-count, count + 1):
            x, _ = self._ruler_point(k * step, y)
            canvas.line([(x, y - 4.0), (x, y)], GREY)
            canvas.text(signed(f"{1e3 * k * step:g}"), (x, y + 9.0), GREY, SMALL, "centre")
        canvas.text("mm", (WIDTH - 5.0, y + 9.0), GREY, SMALL, "right")
        x, _ = self.view(0.0, 0.0)
        canvas.dashes([(x, 62.0), (x, y - 4.0)], RULE)
        size = nice_step(20.0 / self.view.y_scale)
        length = size * self.view.y_scale
        left, top = MARGIN + 3.0, 46.0
        canvas.line([(left - 3.0, top), (left + 3.0, top)], GREY)
        canvas.line([(left - 3.0, top + length), (left + 3.0, top + length)], GREY)
        canvas.line([(left, top), (left, top + length)], GREY)
        canvas.text(
            f"{1e3 * size:g} mm   heights and tilt \N{MULTIPLICATION SIGN} {self.magnification:g}",
            (left + 9.0, top + 0.5 * length),
            GREY,
            SMALL,
        )

    def _ruler_point(self, x: float, y: float) -> Point:
        return self.view(x, 0.0)[0], y

    def _bar(self, bar: Frame) -> None:
        half, curve = self.params["half_length"], self.options["curve"]
        curvature = 0.0 if curve is None else float(curve["curvature"])
        surface = [
            self.view(bar.x[0] + d * bar.cos + q * bar.sin, bar.z[0] - d * bar.sin + q * bar.cos)
            for d in np.linspace(-half, half, 2 if curve is None else CURVE_POINTS)
            for q in [0.5 * curvature * d * d]
        ]
        (x0, y0), (x1, y1) = surface[0], surface[-1]
        below = 8.0 if curvature <= 0.0 else 8.0 + max(y for _, y in surface) - max(y0, y1)
        with self.canvas.inside(SCENE):
            self.canvas.polygon([*surface, (x1, y1 + below), (x0, y0 + below)], BLUE)
            self.canvas.line(surface, mix(BLUE, INK, 0.45), 1.6)
            x, y = self.view(bar.x[0], bar.z[0])
            self.canvas.polygon([(x, y + 10.0), (x - 6.0, y + 20.0), (x + 6.0, y + 20.0)], BLUE)

    def _path(self, now: float) -> None:
        """The ball's path in the last cycles, fading."""
        rows = self._trail.table()
        points = [(x, y - BALL) for x, y in (self.view(x, z) for x, z in rows[:, 1:])]
        age = (now - rows[:, 0]) / self._trail.span
        with self.canvas.inside(SCENE):
            for a, b, old in zip(points[:-1], points[1:], age, strict=False):
                self.canvas.line([a, b], mix(PALE_ORANGE, PAPER, old), 2.0)

    def _ball(self, ball: np.void) -> None:
        x, y = self.view(float(ball["x"]), float(ball["z"]))
        colour = RED if ball["lost"] else ORANGE
        if y < TOP:
            self.canvas.polygon([(x, TOP + 2.0), (x - 7.0, TOP + 14.0), (x + 7.0, TOP + 14.0)], colour)
            self.canvas.text(f"{1e3 * ball['z']:.1f} mm up", (x, TOP + 22.0), colour, SMALL, "centre")
            return
        with self.canvas.inside(SCENE):
            self.canvas.disc((x, y - BALL), BALL, colour)
            self.canvas.disc((x - 2.5, y - BALL - 2.5), 2.2, mix(colour, PANEL, 0.55))

    def _dials(self, moment: Moment) -> None:
        """Phasors: the horizontal part of an arrow is the displacement now; z turns twice as fast."""
        p, m = self.scene.params, moment.ball["motion"]
        z_most = math.hypot(p.z_centre + p.z_span, p.z_span)
        dials = (
            ("x", m[0:2], math.sqrt(2.0) * p.x_span, 1.0, 1e3, "mm"),
            ("tilt", m[2:4], math.sqrt(2.0) * p.tilt_span, 1.0, 1e3, "mrad"),
            ("z", m[4:6], z_most, 2.0, 1e3, "mm"),
        )
        self.canvas.text("Motion of the bar, amplitude and phase", (MARGIN, 305.0), GREY, SMALL)
        for k, (name, (cosine, sine), most, pace, factor, unit) in enumerate(dials):
            centre = (MARGIN + 42.0 + 92.0 * k, 346.0)
            self.canvas.disc(centre, DIAL, PANEL)
            self.canvas.ring(centre, DIAL, RULE, 1.2)
            for dx, dy in ((1.0, 0.0), (0.0, 1.0)):
                ends = [(centre[0] + e * DIAL * dx, centre[1] + e * DIAL * dy) for e in (-1.0, 1.0)]
                self.canvas.line(ends, RULE)
            angle = pace * self.params["omega"] * moment.since
            turned = (cosine + 1j * -sine) * complex(math.cos(angle), math.sin(angle))
            size = DIAL / most if most > 0.0 else 0.0
            tip = (centre[0] + turned.real * size, centre[1] - turned.imag * size)
            self.canvas.arrow(centre, tip, BLUE)
            self.canvas.disc(centre, 2.0, BLUE)
            amplitude = factor * math.hypot(cosine, sine)
            self.canvas.text(f"{name} {amplitude:.2g} {unit}", (centre[0], 385.0), INK, SMALL, "centre")

    def _chart(self, now: float) -> None:
        """Where the ball was along the bar at the starts of the last cycles."""
        half = self.params["half_length"]
        frame = Box(352.0, 316.0, WIDTH - MARGIN - 352.0, 62.0)
        self.canvas.text(f"Ball along the bar (mm), last {CHART_SPAN:g} s", (352.0, 305.0), GREY, SMALL)
        strip = Strip(self.canvas, frame, now, CHART_SPAN, -half, half)
        for value in (-half, 0.0, half):
            strip.rule(value, signed(f"{1e3 * value:g}"))
        rows = self._places.table()
        strip.curve(rows[:, 0], rows[:, 1], BLUE)
        with self.canvas.inside(frame):
            self.canvas.disc(strip.view(rows[-1, 0], rows[-1, 1]), 3.0, ORANGE)


PAINTER = BallOnBarPainter
