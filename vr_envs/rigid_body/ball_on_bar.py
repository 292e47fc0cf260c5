"""The ball on the bar as a Chipmunk space: a kinematic bar, a circle, fixed time steps.

Chipmunk finds a contact at the end of the step in which the shapes have met, so impacts are up to a step late and
everything but free flight is of first order in the step. What the space is made of:

- Frame: Chipmunk's x and y are x and z here; its angle counts the other way round than the tilt about +y.
- Free flight: Chipmunk moves with the velocity before it accelerates. Its velocity is taken as that in the middle
  of a step (leapfrog), which makes the parabola exact.
- Bar: in each step it has the mean velocity of the exact motion, so it is where the motion says at every step's end.
  It is made of facets, one if it is flat: thick segments, so that nothing tunnels, with their surface one radius of
  the ball below the path of the ball's centre, which is what the motion of the bar and its curvature describe. The
  ball meets the facet below it, with the normal of the curved surface there.
- Restitution: Chipmunk multiplies the elasticities of two shapes; the bar's is 1.
- Tangential law: friction, large enough to grip always or with the coefficient of the scene. A gripping ball of
  inertia ratio k loses k/(1 + k) of its slip. The loss c of a ball without spin is that of inertia ratio c/(1 - c)
  whose spin relative to the bar is forgotten before every contact. Tangential restitution is the velocity of a
  conveyor belt, Chipmunk's surface velocity, that the slip is brought to.
- Impacts: contacts that begin faster than what the ball falls in a few steps; slower ones are a resting ball that
  has lost touch for a step. Each draws restitution and normal as an impact of the exact model does, by the same key
  and counter; after its first step the contact has the smooth normal.
- Penetration: corrected within one step (collision bias 0), but for an overlap of what the ball falls in a few
  steps (collision slop), where a resting contact lasts. Chipmunk's own slop, 0.1, is meant for pixels.
- One contact with decoupled normal and tangent: the first iteration of the solver is exact.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pymunk
from pymunk import Vec2d

from vr_envs.envs.scene import Scene
from vr_envs.models.ball_sensors import ages_of, sense
from vr_envs.models.clock import equal_steps
from vr_envs.models.drive import bar_at, base_cycle, demanded
from vr_envs.models.impact import softened
from vr_envs.models.jit import kernel
from vr_envs.models.noise import normal_pair

GRIP = 1e9  # coefficient of friction of shapes that never slip
RADIUS = 0.0025  # m, of a ball without spin, whose size has no effect
DEPTH = 0.05  # m, half the thickness of the bar, above what any step can penetrate
REACH = 1e3  # where the bar's surface goes on to, in half lengths: a ball that meets it beyond the end is lost
SAGITTA = 1e-6  # m, by which the middle of a facet is off the curved surface
MASSLESS = 1e-9  # inertia ratio in place of 0, which Chipmunk does not take
FEW = 4.0  # steps in which a resting ball may fall: they set the allowed overlap and the slowest impact
BALL, BAR = 1, 2  # collision types


@kernel
def track_of(old, new, steps, dt, intervals, params, frequencies, ramp):
    """Place (x, z) and Chipmunk's angle of the bar at `steps` + 1 times `dt` apart, shape (steps + 1, 3).

    They begin with control interval number `intervals`, in which the bar goes from the motion `old` to `new`.
    """
    number, begin = base_cycle(intervals, params)
    track = np.empty((steps + 1, 3))
    for k in range(steps + 1):
        s = begin + k * dt
        passed = int(s / params.period)
        s -= passed * params.period
        if passed == 0:
            frame = bar_at(old, new, s, begin, number, params, frequencies, ramp)
        else:
            frame = bar_at(new, new, s, 0.0, number + passed, params, frequencies, ramp)
        track[k, 0], track[k, 1], track[k, 2] = frame.x[0], frame.z[0], -frame.tilt[0]
    return track


def facets_of(half_length: float, curvature: float) -> np.ndarray:
    """Corners of the path of the ball's centre in the bar's axes, shape (facets + 1, 2), m.

    A curved bar goes on along its tangents beyond its ends.
    """
    end = half_length * REACH
    if curvature == 0.0:
        return np.array([[-end, 0.0], [end, 0.0]])
    count = math.ceil(2.0 * half_length * math.sqrt(abs(curvature) / (8.0 * SAGITTA)))
    along = np.linspace(-half_length, half_length, count + 1)
    rise = 0.5 * curvature * half_length**2
    beyond = rise + curvature * half_length * (end - half_length)
    return np.array([[-end, beyond], *np.stack([along, 0.5 * curvature * along**2], axis=1), [end, beyond]])


class BallOnBarSimulator:
    """Moves the state of a ball on a bar in one scene.

    The space is built anew from the record at every control interval, so a step is a pure function of record and
    action, as with the exact model.
    """

    def __init__(self, scene: Scene) -> None:
        """`scene` has the engine `rigid_body`."""
        self.scene = scene
        self.params, options = scene.records()
        self.options = dict(zip(scene.options, options, strict=True))
        p = scene.params
        self.span = p.hold * p.period
        self.steps = equal_steps(self.span, scene.simulators["rigid_body"].step)
        self.dt = self.span / self.steps
        spin, friction, curve = (scene.options[name] for name in ("spin", "friction", "curve"))
        self.radius = RADIUS if spin is None else spin.radius
        if spin is not None:
            ratio = max(spin.inertia_ratio, MASSLESS)
        else:
            ratio = p.tangential_loss / (1.0 - p.tangential_loss) if p.tangential_loss < 1.0 else math.inf
        self.moment = ratio * self.radius**2 if ratio > 0.0 else math.inf
        grip = GRIP if friction is None else friction.coefficient
        self.friction = grip if ratio > 0.0 else 0.0
        self.curvature = 0.0 if curve is None else curve.curvature
        self.facets = facets_of(p.half_length, self.curvature)
        # the steps before which a sensor looks, the earlier time and the last, and how long after their beginning
        sensing, camera = self.options["sensing"], self.options["camera"]
        senses = sensing is not None or camera is not None
        times = [self.span - age for age in ages_of(sensing, camera)] if senses else []
        begun = [int(t / self.dt + 1e-9) for t in times]
        self.looks = [(k, max(0.0, t - k * self.dt)) for k, t in zip(begun, times, strict=True)]

    def advance(self, state: np.void, action: np.ndarray) -> None:
        """Move `state` in place by one control interval while the bar goes to the motion that `action` asks for.

        Args:
            state: record of the task's `State`; a lost ball stays where it left the bar.
            action: six numbers in [-1, 1].
        """
        self.interval(state, demanded(action, self.params))

    def interval(self, state: np.void, new: tuple[float, ...], until: float | None = None) -> None:
        """Move `state` by one control interval, or to the step nearest to the time `until` (s) in it.

        Args:
            state: as for `advance`.
            new: the motion to which the bar goes, see `vr_envs.models.bar`.
            until: None, or a time in the interval.
        """
        if not (state["lost"] or state["fault"]):
            steps = self.steps if until is None else round(until / self.dt)
            Bounces(self, state, new).run(steps)
        state["motion"] = new


class Bounces:
    """The space of one control interval, and the record that it moves."""

    def __init__(self, simulator: BallOnBarSimulator, state: np.void, new: tuple[float, ...]) -> None:
        """The ball of `state` over the bar as it is at the start of an interval in which it goes to `new`."""
        p, options = simulator.scene.params, simulator.options
        self.state = state
        self.simulator = simulator
        self.track = track_of(
            tuple(state["motion"].tolist()), new, simulator.steps, simulator.dt, int(state["steps"]), simulator.params,
            options["frequencies"], options["ramp"],
        )  # fmt: skip
        self.space = pymunk.Space()
        self.space.gravity = 0.0, -p.gravity
        self.space.iterations = 1
        self.space.collision_bias = 0.0
        self.space.collision_slop = FEW * p.gravity * simulator.dt**2
        self.slowest = FEW * p.gravity * simulator.dt  # m/s
        self.alpha = self.restitution = p.restitution  # of the contact that lasts
        self.step, self.touched = 0, -2  # the present step, and the last one with a contact
        self.earlier = 0.0, 0.0  # m, x and z at the sensor's earlier look
        self.bar = self._build_bar()
        self.ball = self._build_ball()
        self.space.on_collision(BALL, BAR, pre_solve=self._touch)

    def _build_bar(self) -> pymunk.Body:
        bar = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        bar.position, bar.angle = tuple(self.track[0, :2].tolist()), float(self.track[0, 2])
        corners = [Vec2d(*corner) for corner in self.simulator.facets.tolist()]
        shapes = []
        self.ranges: dict[pymunk.Shape, tuple[float, float]] = {}
        for left, right in zip(corners[:-1], corners[1:], strict=True):
            down = -(right - left).perpendicular_normal() * (self.simulator.radius + DEPTH)
            shape = pymunk.Segment(bar, left + down, right + down, DEPTH)
            shape.elasticity, shape.friction, shape.collision_type = 1.0, 1.0, BAR
            self.ranges[shape] = left.x, right.x
            shapes.append(shape)
        self.space.add(bar, *shapes)
        return bar

    def _build_ball(self) -> pymunk.Body:
        simulator, state = self.simulator, self.state
        p = simulator.scene.params
        ball = pymunk.Body(1.0, simulator.moment)
        ball.position = float(state["x"]), float(state["z"])
        ball.velocity = float(state["u"]), float(state["w"]) - 0.5 * p.gravity * simulator.dt
        ball.angular_velocity = -float(state["spin"]) / simulator.radius
        circle = pymunk.Circle(ball, simulator.radius)
        circle.elasticity, circle.friction, circle.collision_type = p.restitution, simulator.friction, BALL
        self.space.add(ball, circle)
        return ball

    def run(self, steps: int) -> None:
        """Make the first `steps` steps of the interval and write the record."""
        space, bar, dt, state = self.space, self.bar, self.simulator.dt, self.state
        looks, done = self.simulator.looks, 0
        for k, (vx, vz, turn) in enumerate((np.diff(self.track[: steps + 1], axis=0) / dt).tolist()):
            while done < len(looks) and looks[done][0] == k:
                self._look(done, looks[done][1])
                done += 1
            self.step = k
            bar.velocity = vx, vz
            bar.angular_velocity = turn
            space.step(dt)
            if state["lost"]:
                break
        for number in range(done, len(looks)):
            self._look(number, 0.0)
        self._write()

    def _look(self, number: int, time: float) -> None:
        """The sensor's look `number`, the earlier (0) or the last (1), a `time` (s) of free flight from now."""
        state, options, gravity = self.state, self.simulator.options, self.simulator.scene.params.gravity
        self._write()
        state["x"] += state["u"] * time
        state["z"] += (state["w"] - 0.5 * gravity * time) * time
        state["w"] -= gravity * time
        if number == 0:
            self.earlier = state["x"], state["z"]
        else:
            sense(state, state["steps"] + 1, *self.earlier, options["sensing"], options["camera"])

    def _write(self) -> None:
        state, ball, simulator = self.state, self.ball, self.simulator
        state["x"], state["z"] = ball.position
        state["u"], state["w"] = ball.velocity
        state["w"] += 0.5 * simulator.scene.params.gravity * simulator.dt
        if simulator.scene.options["spin"] is not None:
            state["spin"] = -simulator.radius * ball.angular_velocity
        state["resting"], state["d"], state["rate"] = False, 0.0, 0.0

    def _touch(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: Any) -> None:
        """Before a contact is solved: which surface, restitution and slip does it have?"""
        ball, bar, state, simulator = self.ball, self.bar, self.state, self.simulator
        options = simulator.options
        d = bar.world_to_local(ball.position).x
        left, right = self.ranges[arbiter.shapes[1]]
        state["lost"] = abs(d) > simulator.scene.params.half_length
        arbiter.process_collision = left <= d < right and not state["lost"]
        if not arbiter.process_collision:
            return
        begins = self.touched < self.step - 1
        self.touched = self.step
        if options["spin"] is None:
            ball.angular_velocity = bar.angular_velocity
        down = Vec2d(simulator.curvature * d, -1.0).normalized().rotated(bar.angle)  # from the ball to the bar
        approach = ball.velocity - bar.velocity_at_world_point(ball.position)
        speed = approach.dot(down)
        if begins:
            if speed > self.slowest:
                down = self._scattered(down, approach)
                state["impacts"] += 1
            self.restitution = softened(self.alpha, speed, options["softening"])
            if speed > self.slowest and options["friction"] is not None:
                self._rebound(arbiter, approach, down)
        arbiter.restitution = self.restitution
        contacts = arbiter.contact_point_set
        point = contacts.points[0]
        point.point_a = ball.position + simulator.radius * down
        point.point_b = point.point_a + point.distance * down
        contacts.normal = down
        arbiter.contact_point_set = contacts

    def _scattered(self, down: Vec2d, approach: Vec2d) -> Vec2d:
        """Draw restitution and normal of an impact on a surface with the normal `down`."""
        scatter, state = self.simulator.scene.options["scatter"], self.state
        if scatter is None:
            return down
        first, second = normal_pair(state["key"], state["impacts"] + 1)
        mean = self.simulator.scene.params.restitution
        self.alpha = min(1.0, max(0.0, mean + scatter.restitution * first))
        turned = down.rotated(-scatter.normal * second)
        return turned if approach.dot(turned) > 0.0 else down  # a grazing ball meets the smooth surface

    def _rebound(self, arbiter: pymunk.Arbiter, approach: Vec2d, down: Vec2d) -> None:
        """Tangential restitution: the slip of an impact is to be reversed in part."""
        spun = (self.ball.angular_velocity - self.bar.angular_velocity) * self.simulator.radius * down
        tangent = down.perpendicular()
        slip = (approach + spun.perpendicular()).dot(tangent)
        arbiter.surface_velocity = -self.simulator.scene.options["friction"].restitution * slip * tangent


SIMULATOR = BallOnBarSimulator
