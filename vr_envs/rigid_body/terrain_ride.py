"""The ride as a Chipmunk space: a mass, a wheel, a damped spring between them, and the road that runs below.

Chipmunk moves all bodies with their velocities, finds the contacts of the shapes where they are then, and changes the
velocities; a contact, a slope or a stop is felt up to a step late, and so everything is of first order in the step.
What the space is made of:

- Frame: it moves along with the vehicle; y is up, and the road is a body that runs backwards at the vehicle's speed.
  Every body moves in a vertical groove and does not turn.
- Time: a space begins half a step behind its record and ends half a step behind the end, each body along its velocity,
  so that a step is a move over half of it, the change of velocities, and the other half: free motion is of second
  order, the fall of a body exact.
- Levelled spring: its natural length is such that it carries the mass at the travel 0, whatever its modulus. A stop
  adds to its force beyond the stop's travel. A damper that acts on the mass's own velocity is fixed to the frame.
- Wheel: a circle whose centre follows the path that the scene describes; contacts are frictionless and do not bounce.
  The road is made of thick segments, so that nothing tunnels; each counts only while the wheel is over it, and its
  surface is one radius of the wheel below the path, raised by the overlap in which a contact lasts.
- Without a tyre the wheel follows the ground whatever pulls at it: it is so heavy that nothing does, and a force
  presses it down as hard as the sharpest crest in the interval asks for.
- With a tyre the wheel's mass is at the hub. The tyre is a spring from the hub to a patch that touches the ground,
  whose mass falls with the square of the step; a slide joint of the tyre's free length lifts the patch with the hub.
- Chipmunk's ways with stacks of boxes are off: contacts and joints are put right within one step.

The space is built anew from the record in every tick, so a step is a pure function of record and action.
"""

from __future__ import annotations

import math

import numpy as np
import pymunk

from vr_envs.envs.scene import Scene
from vr_envs.models.clock import piece_of, to_next_tick
from vr_envs.models.jit import kernel
from vr_envs.models.ride_options import TICK, G
from vr_envs.models.road import pass_knot, slope_of_road
from vr_envs.models.terrain import roll_undulation, undulation_ahead
from vr_envs.models.terrain_ride import actuate, begin_tick, end_tick, suspension

HEIGHT = 100.0  # m, from the wheel to the hub and from there to the mass, at rest: more than any of them moves
FAR = 1e4  # m, ends of grooves
RADIUS = 0.05  # m, of the circle; it has no effect
DEPTH = 0.05  # m, half the thickness of the road, more than any step can penetrate
GROUND = ("undulation", "road", "profile", "bumps", "obstacle", "wheel")
REACH = 1.0  # m, by which the piece of road under the wheel goes on beyond its ends
HEAVY = 1e3  # mass of a wheel without tyre, in sprung masses
SLACK = 1e-3  # m/s, by which the wheel is pressed down harder than the road asks for
TAME = 2.0  # inverse of the patch's angular frequency times the step; stable above 1/2
FACET = 8.0  # steps on one straight piece of a sine


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
        for i in range(count + 1):
            corners[i, 1] += undulation_ahead(state, corners[i, 0], undulation)
            corners[i, 1] -= undulation_ahead(state, 0.0, undulation)
        roll_undulation(state, distance, undulation)
    return count + 1


class TerrainRideSimulator:
    """Moves the state of a ride in one scene."""

    def __init__(self, scene: Scene) -> None:
        """`scene` has the engine `rigid_body`."""
        self.scene = scene
        self.params, options = scene.records()
        self.options = dict(zip(scene.options, options, strict=True))
        self.ground = tuple(self.options[name] for name in GROUND)
        self.step = scene.simulators["rigid_body"].step
        p, road = scene.params, scene.options["road"]
        facets = TICK / (FACET * self.step) + 2.0
        knots = 1.0 if road is None else p.speed * TICK / road.knot_spacing + 3.0
        self.room = math.ceil(knots * facets)

    def advance(self, state: np.void, action: np.ndarray) -> None:
        """Move `state` in place by one control interval.

        Args:
            state: record of the task's `State`.
            action: numbers in [-1, 1]: damping and modulus, or the force.
        """
        lag, tyre = self.options["lag"], self.options["tyre"]
        state["touches"] = 0
        if lag is None:
            actuate(state, action, lag)
        left = self.scene.params.dt
        while left > 0.0:
            if state["time_to_tick"] == 0.0:
                begin_tick(state, action, lag)
            piece = piece_of(left, state["time_to_tick"])
            vehicle = Vehicle(self, state, piece)
            vehicle.run()
            left -= piece
            state["time_to_tick"], ticked = to_next_tick(state["time_to_tick"], piece, 0.0)
            if ticked:
                end_tick(state, vehicle.gamma, self.params, tyre)


class Vehicle:
    """The space of one tick or a part of one, and the record that it moves."""

    def __init__(self, simulator: TerrainRideSimulator, state: np.void, time: float) -> None:
        """The vehicle of `state`, and the road that it covers in `time` [s]."""
        p = simulator.scene.params
        self.simulator, self.state = simulator, state
        self.stop, self.tyre = (simulator.scene.options[name] for name in ("stop", "tyre"))
        self.steps = math.ceil(time / simulator.step - 1e-9)
        self.dt = time / self.steps
        self.gamma, self.w2, push = suspension(state, simulator.params)
        # of the push per mass, the payload acts from outside, the actuator between mass and hub
        self.between = push - float(state["payload"])
        self.lift = p.mass * float(state["payload"])
        self._lay_road(p.speed * time)
        self.space = pymunk.Space()
        self.space.gravity = 0.0, -G
        self.space.collision_bias = 0.0
        self.space.collision_slop = 2.0 * self.overlap
        self.side, self.touches = float(state["side"]), 0
        self._build()

    def _lay_road(self, distance: float) -> None:
        """The road of this space: which piece is under the wheel, and how high, in the middle of each step."""
        simulator, speed = self.simulator, self.simulator.scene.params.speed
        corners = np.empty((simulator.room, 2))
        count = path_ahead(self.state, distance, FACET * self.dt * speed, *simulator.ground, corners)
        x, y = corners[:count].T
        slopes = np.diff(y) / np.diff(x)
        places = speed * self.dt * (np.arange(self.steps) + 0.5)
        self.pieces = np.searchsorted(x[1:-1], places, side="right").tolist()
        self.heights = np.interp(places, x, y).tolist()
        self.end = float(np.interp(distance, x, y))
        self.rate = speed * float(slopes[self.pieces[0]])  # m/s, of the wheel at the beginning
        self.press = speed * float(np.ptp(slopes)) + SLACK
        self.overlap = self.press * self.dt
        down = np.stack([slopes, -np.ones(len(slopes))], axis=1) / np.hypot(slopes, 1.0)[:, None]
        beyond = REACH * np.stack([-down[:, 1], down[:, 0]], axis=1)
        offset = (RADIUS + DEPTH - self.overlap) * down
        points = corners[:count]
        self.ends = list(
            zip((points[:-1] + offset - beyond).tolist(), (points[1:] + offset + beyond).tolist(), strict=True)
        )

    def _body(self, mass: float, height: float, velocity: float) -> pymunk.Body:
        """A body that moves up and down in a groove, half a step back from where it is at `height`."""
        body = pymunk.Body(mass, math.inf)
        body.velocity = 0.0, velocity
        body.position = 0.0, height - 0.5 * self.dt * velocity
        groove = pymunk.GrooveJoint(self.space.static_body, body, (0.0, -FAR), (0.0, FAR), (0.0, 0.0))
        groove.error_bias = 0.0
        self.space.add(body, groove)
        return body

    def _build(self) -> None:
        """The road, and the bodies and springs on it from below."""
        state, p = self.state, self.simulator.scene.params
        self.road = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        self.road.velocity = -p.speed, 0.0
        self.road.position = 0.5 * self.dt * p.speed, 0.0
        self.surface = pymunk.Segment(self.road, *self.ends[self.pieces[0]], DEPTH)
        self.space.add(self.road, self.surface)
        if self.tyre is None:
            self.base = 0.0
            self.wheel = self.hub = self._body(HEAVY * p.mass, 0.0, self.rate)
        else:
            self.base = HEIGHT
            self._build_tyre(HEIGHT + float(state["deflection"]), float(state["hub_velocity"]))
        self.space.add(pymunk.Circle(self.wheel, RADIUS))
        height = self.base + float(state["deflection"]) + HEIGHT + float(state["travel"])
        self.mass = self._body(p.mass, height, float(state["velocity"]))
        self.length = HEIGHT + (G + self.between) / self.w2
        damping = p.mass * self.gamma
        spring = pymunk.DampedSpring(
            self.hub, self.mass, (0.0, 0.0), (0.0, 0.0), self.length, p.mass * self.w2, damping * p.relative
        )
        if self.stop is not None:
            spring.force_func = self._force
        self.space.add(spring)
        if not p.relative:
            frame = self.space.static_body
            self.space.add(pymunk.DampedSpring(frame, self.mass, (0.0, -FAR), (0.0, 0.0), 0.0, 0.0, damping))

    def _build_tyre(self, height: float, velocity: float) -> None:
        """Hub at a height over the ground, its tyre and the patch that touches the ground."""
        tyre, total = self.tyre, self.simulator.scene.params.mass + self.tyre.unsprung_mass
        free = HEIGHT + total * G / tyre.rate
        self.hub = self._body(tyre.unsprung_mass, height, velocity)
        lifted = height > free
        self.wheel = self._body(
            tyre.rate * (TAME * self.dt) ** 2, height - free if lifted else 0.0, velocity if lifted else self.rate
        )
        spring = pymunk.DampedSpring(self.wheel, self.hub, (0.0, 0.0), (0.0, 0.0), free, tyre.rate, 0.0)
        reach = pymunk.SlideJoint(self.wheel, self.hub, (0.0, 0.0), (0.0, 0.0), 0.0, free)
        reach.error_bias = 0.0
        self.space.add(spring, reach)
        self.free = free

    def _force(self, spring: pymunk.DampedSpring, length: float) -> float:
        """Force of the suspension at a length, N: its spring, and a stop if it is touched."""
        travel = length - HEIGHT
        beyond = abs(travel) - self.stop.travel
        force = spring.stiffness * (self.length - length)
        if beyond <= 0.0:
            self.side = 0.0
            return force
        if self.side == 0.0:
            self.touches += 1
        self.side = math.copysign(1.0, travel)
        return force - self.side * self.stop.rate * beyond

    def run(self) -> None:
        """Make the steps and write the record."""
        space, dt, state = self.space, self.dt, self.state
        now, airborne = self.pieces[0], bool(state["airborne"])
        pull = 0.0 if self.tyre is not None else -self.press / dt * self.wheel.mass
        for piece, height in zip(self.pieces, self.heights, strict=True):
            if piece != now:
                self.surface.unsafe_set_endpoints(*self.ends[piece])
                now = piece
            self.mass.force = 0.0, self.lift
            self.wheel.force = 0.0, pull
            space.step(dt)
            if self.tyre is not None:
                lifted = self.hub.position.y - height > self.free
                state["liftoffs"] += lifted and not airborne
                state["airborne_time"] += dt * lifted
                airborne = lifted
        state["airborne"] = airborne
        state["touches"] += self.touches
        state["side"] = self.side
        hub = self.end if self.tyre is None else self._now(self.hub) - self.base
        state["travel"] = self._now(self.mass) - self.base - HEIGHT - hub
        state["velocity"] = self.mass.velocity.y
        if self.tyre is not None:
            state["deflection"] = hub - self.end
            state["hub_velocity"] = self.hub.velocity.y

    def _now(self, body: pymunk.Body) -> float:
        """Height of a body at the end of the last step, half a step ahead of its place in the space."""
        return body.position.y + 0.5 * self.dt * body.velocity.y


SIMULATOR = TerrainRideSimulator
