"""The ball on the bar as a Chipmunk space: a kinematic bar, a circle, fixed time steps.

Chipmunk finds a contact at the end of the step in which the shapes have met, so impacts are up to a step late and
everything but free flight is of first order in the step. What the space is made of:

- Frame: Chipmunk's x and y are x and z here; its angle counts the other way round than the tilt about +y.
- Free flight: Chipmunk moves with the velocity before it accelerates. Its velocity is taken as that in the middle
  of a step (leapfrog), which makes the parabola exact.
- Bar: in each step it has the mean velocity of the exact motion, so it is where the motion says at every step's end.
  A thick, long segment, so that nothing tunnels; its surface lies one radius of the ball below the path of the
  ball's centre, which is what the motion of the bar describes.
- Restitution: Chipmunk multiplies the elasticities of two shapes; the bar's is 1.
- Tangential law: friction large enough to grip always. A gripping ball of inertia ratio k loses k/(1 + k) of its
  slip. The loss c of a ball without spin is that of inertia ratio c/(1 - c) whose spin relative to the bar is
  forgotten before every contact.
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

from vr_envs.envs.scene import Scene
from vr_envs.models.ball_on_bar import demanded, piece_at
from vr_envs.models.bar import frame_at
from vr_envs.models.jit import kernel
from vr_envs.models.noise import normal_pair

GRIP = 1e9  # coefficient of friction of shapes that never slip
RADIUS = 0.0025  # m, of a ball without spin, whose size has no effect
DEPTH = 0.05  # m, thickness of the bar, above what any step can penetrate
REACH = 1e3  # length of the segment over that of the bar: a ball beyond the bar's end meets its plane and is lost
MASSLESS = 1e-9  # inertia ratio in place of 0, which Chipmunk does not take
FEW = 4.0  # steps in which a resting ball may fall: they set the allowed overlap and the slowest impact
BALL, BAR = 1, 2  # collision types


@kernel
def _track(old, new, n, params):
    """Place (x, z) and Chipmunk's angle of the bar at n + 1 equally spaced times of a cycle, shape (n + 1, 3)."""
    track = np.empty((n + 1, 3))
    for k in range(n + 1):
        s = params.period * k / n
        frame = frame_at(piece_at(old, new, s, params), s)
        track[k, 0], track[k, 1], track[k, 2] = frame.x[0], frame.z[0], -frame.tilt[0]
    return track


class BallOnBarSimulator:
    """Moves the state of a ball on a bar in one scene.

    The space is built anew from the record at every control interval, so a step is a pure function of record and
    action, as with the exact model.
    """

    def __init__(self, scene: Scene) -> None:
        """`scene` has the engine `rigid_body`."""
        p = scene.params
        self.scene = scene
        self.params, _ = scene.records()
        self.steps = math.ceil(p.period / scene.simulators["rigid_body"].step - 1e-9)
        self.dt = p.period / self.steps
        spin, loss = scene.options["spin"], p.tangential_loss
        self.radius = RADIUS if spin is None else spin.radius
        if spin is not None:
            ratio = max(spin.inertia_ratio, MASSLESS)
        else:
            ratio = loss / (1.0 - loss) if loss < 1.0 else math.inf
        self.moment = ratio * self.radius**2 if ratio > 0.0 else math.inf
        self.friction = GRIP if ratio > 0.0 else 0.0

    def advance(self, state: np.void, action: np.ndarray) -> None:
        """Move `state` in place by one base cycle while the bar goes to the motion that `action` asks for.

        Args:
            state: record of the task's `State`; a lost ball stays where it left the bar.
            action: six numbers in [-1, 1].
        """
        self.cycle(state, demanded(action, self.params))

    def cycle(self, state: np.void, new: tuple[float, ...], until: float | None = None) -> None:
        """Move `state` by one base cycle, or to the step nearest to the time `until` (s) in it.

        Args:
            state: as for `advance`.
            new: the motion to which the bar goes, see `vr_envs.models.bar`.
            until: None, or a time in the cycle.
        """
        if state["lost"] or state["fault"]:
            return
        old = tuple(state["motion"].tolist())
        track = _track(old, new, self.steps, self.params)
        _Bounces(self, state, track[0]).run(track, self.steps if until is None else round(until / self.dt))
        state["motion"] = new


class _Bounces:
    """The space of one control interval, and the record that it moves."""

    def __init__(self, simulator: BallOnBarSimulator, state: np.void, place: np.ndarray) -> None:
        p = simulator.scene.params
        self.state = state
        self.dt = simulator.dt
        self.half_length, self.gravity, self.mean = p.half_length, p.gravity, p.restitution
        self.radius = simulator.radius
        self.scatter, self.spin = (simulator.scene.options[name] for name in ("scatter", "spin"))
        self.space = pymunk.Space()
        self.space.gravity = 0.0, -p.gravity
        self.space.iterations = 1
        self.space.collision_bias = 0.0
        self.space.collision_slop = FEW * p.gravity * self.dt**2
        self.bar = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        self.bar.position, self.bar.angle = tuple(place[:2].tolist()), float(place[2])
        end, level = REACH * p.half_length, -self.radius - DEPTH
        surface = pymunk.Segment(self.bar, (-end, level), (end, level), DEPTH)
        surface.elasticity, surface.friction, surface.collision_type = 1.0, 1.0, BAR
        self.ball = pymunk.Body(1.0, simulator.moment)
        self.ball.position = float(state["x"]), float(state["z"])
        self.ball.velocity = float(state["u"]), float(state["w"]) - 0.5 * p.gravity * self.dt
        self.ball.angular_velocity = -float(state["spin"]) / self.radius
        circle = pymunk.Circle(self.ball, self.radius)
        circle.elasticity, circle.friction, circle.collision_type = p.restitution, simulator.friction, BALL
        self.space.add(self.bar, surface, self.ball, circle)
        self.space.on_collision(BALL, BAR, pre_solve=self._touch)
        self.restitution = p.restitution  # of the contact that lasts
        self.slowest = FEW * p.gravity * self.dt  # m/s

    def run(self, track: np.ndarray, steps: int) -> None:
        """Make the steps and write the record."""
        space, bar, dt, state = self.space, self.bar, self.dt, self.state
        for vx, vz, turn in (np.diff(track[: steps + 1], axis=0) / dt).tolist():
            bar.velocity = vx, vz
            bar.angular_velocity = turn
            space.step(dt)
            if state["lost"]:
                break
        state["x"], state["z"] = self.ball.position
        state["u"], state["w"] = self.ball.velocity
        state["w"] += 0.5 * self.gravity * dt
        if self.spin is not None:
            state["spin"] = -self.radius * self.ball.angular_velocity
        state["resting"], state["d"], state["rate"] = False, 0.0, 0.0

    def _touch(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: Any) -> None:
        """Before a contact is solved: is the ball still above the bar, and how does this impact scatter?"""
        ball, state = self.ball, self.state
        if abs(self.bar.world_to_local(ball.position).x) > self.half_length:
            state["lost"] = True
            arbiter.process_collision = False
            return
        if self.spin is None:
            ball.angular_velocity = self.bar.angular_velocity
        if arbiter.is_first_contact:
            contacts = arbiter.contact_point_set
            approach = ball.velocity - self.bar.velocity_at_world_point(ball.position)
            if approach.dot(contacts.normal) > self.slowest:
                self._scatter(arbiter, contacts, approach)
                state["impacts"] += 1
        if self.scatter is not None:
            arbiter.restitution = self.restitution

    def _scatter(self, arbiter: pymunk.Arbiter, contacts: pymunk.ContactPointSet, approach: pymunk.Vec2d) -> None:
        """Draw restitution and normal of an impact; `approach` is the ball's velocity relative to the bar."""
        if self.scatter is None:
            return
        first, second = normal_pair(self.state["key"], self.state["impacts"] + 1)
        self.restitution = min(1.0, max(0.0, self.mean + self.scatter.restitution * first))
        down = contacts.normal.rotated(-self.scatter.normal * second)  # from the ball to the bar
        if approach.dot(down) <= 0.0:
            return  # a grazing ball meets the smooth surface
        point = contacts.points[0]
        point.point_a = self.ball.position + self.radius * down
        point.point_b = point.point_a + point.distance * down
        contacts.normal = down
        arbiter.contact_point_set = contacts


SIMULATOR = BallOnBarSimulator
