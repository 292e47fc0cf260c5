"""The ball in Chipmunk's fixed time steps: the package's engine `rigid_body`, and pymunk driven directly.

Directly: a kinematic segment with the mean velocity of the bar over each step, a circle, elasticity and friction, and
the settings that a ball of millimetres needs (Chipmunk's own are meant for pixels). A leapfrog start makes free flight
exact. Chipmunk finds a contact at the end of the step in which the shapes have met; that is the impact's time.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pymunk

from vr_envs.bench.accuracy.ball_on_bar_episodes import Episode, Track
from vr_envs.bench.accuracy.ball_on_bar_loops import bar_track
from vr_envs.rigid_body.ball_on_bar import BallOnBarSimulator, Bounces

RADIUS, THICK, LONG = 0.0025, 0.05, 25.0  # m: ball, half the bar's thickness, half its length
GRIP = 1e9


class Watched(Bounces):
    """The engine's space of one control interval, with a list of its impacts: step and approach velocity."""

    def __init__(self, simulator: BallOnBarSimulator, state: np.void, new: tuple[float, ...]) -> None:
        """As `Bounces`."""
        self.seen: list[tuple[int, float]] = []
        super().__init__(simulator, state, new)

    def _touch(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: Any) -> None:
        before, approach = (
            int(self.state["impacts"]),
            self.ball.velocity - self.bar.velocity_at_world_point(self.ball.position),
        )
        super()._touch(arbiter, space, data)
        if self.state["impacts"] > before:
            self.seen.append((self.step + 1, approach.dot(self.bar.rotation_vector.perpendicular())))


def rigid_body(episode: Episode, step: float) -> Callable[[], Track]:
    """The package's engine with steps of at most `step`, one control interval after the other."""
    simulator, motions = BallOnBarSimulator(episode.scene_of({"rigid_body": {"step": step}})), episode.motions.tolist()

    def work() -> Track:
        state, impacts, ends = episode.states()[0], [], []
        for k, motion in enumerate(motions[1:]):
            interval = Watched(simulator, state, tuple(motion))
            interval.run(simulator.steps)
            state["motion"] = motion
            state["steps"] += 1
            impacts += [(k, number * simulator.dt, normal) for number, normal in interval.seen]
            ends.append([float(state[name]) for name in ("x", "z", "u", "w")])
        return Track(np.array(impacts).reshape(-1, 3), np.array(ends))

    return work


def direct(episode: Episode, steps: int) -> Callable[[], Track]:
    """Pymunk with `steps` equal steps a base cycle, told beforehand where the bar is at their ends."""
    dt = float(episode.params["period"]) / steps
    track = bar_track(episode.motions, episode.params, steps)
    return partial(_bounced, episode, steps, dt, track[0].tolist(), (np.diff(track, axis=0) / dt).tolist())


def _bounced(episode: Episode, steps: int, dt: float, place: list[float], velocities: list[list[float]]) -> Track:
    """The episode of `direct`; `place` (x, z, tilt): the bar's at the start, `velocities`: in each step."""
    p = episode.params
    gravity, share = float(p["gravity"]), float(p["tangential_loss"])
    x, z, u, w = episode.place
    space = pymunk.Space()
    space.gravity = 0.0, -gravity
    space.collision_slop = 1e-9
    bar = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    bar.position, bar.angle = (place[0], place[1]), -place[2]
    surface = pymunk.Segment(bar, (-LONG, -RADIUS - THICK), (LONG, -RADIUS - THICK), THICK)
    surface.elasticity, surface.friction, surface.collision_type = 1.0, 1.0, 1
    ball = pymunk.Body(1.0, share / (1.0 - share) * RADIUS**2)
    ball.position, ball.velocity = (x, z), (u, w - 0.5 * gravity * dt)
    circle = pymunk.Circle(ball, RADIUS)
    circle.elasticity, circle.friction, circle.collision_type = float(p["restitution"]), GRIP, 2
    space.add(bar, surface, ball, circle)
    begun: list[tuple[int, float]] = []
    number = 0  # of the step

    def begin(arbiter: pymunk.Arbiter, space: pymunk.Space, data: Any) -> None:
        approach = ball.velocity - bar.velocity_at_world_point(ball.position)
        begun.append((number, approach.dot(bar.rotation_vector.perpendicular())))

    space.on_collision(2, 1, begin=begin)
    ends = []
    for number, (vx, vz, turn) in enumerate(velocities, start=1):
        bar.velocity, bar.angular_velocity = (vx, vz), -turn
        ball.angular_velocity = -turn  # a ball without spin, whose contact slips as its centre does
        space.step(dt)
        if number % steps == 0:
            ends.append([*ball.position, ball.velocity.x, ball.velocity.y + 0.5 * gravity * dt])
    # Chipmunk finds contacts after it has moved: at the end of the step
    impacts = [((n - 1) // steps, ((n - 1) % steps + 1) * dt, min(normal, -math.ulp(0.0))) for n, normal in begun]
    return Track(np.array(impacts).reshape(-1, 3), np.array(ends))
