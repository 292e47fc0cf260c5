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
  The ground is a thick segment, so that nothing tunnels, in the place of the piece of road over which the wheel is.
  Its surface is one radius of the wheel below the path, less the overlap in which a contact lasts.
- Wheel of finite radius (option `wheel`): a disc on the bare profile, all of whose pieces within reach are segments;
  its path is not calculated but comes of the contacts. The exact model makes it straight between the road's knots.
- Without a tyre the wheel follows the ground whatever pulls at it: it is so heavy that nothing does, and a force
  presses it down as hard as the sharpest crest in the interval asks for.
- With a tyre the wheel's mass is at the hub. The tyre is a spring from the hub to a patch that touches the ground,
  whose mass falls with the square of the step; a slide joint of the tyre's free length lifts the patch with the hub.
- Penetration beyond the overlap is put right within one step (collision bias 0).

The space is built anew from the record in every tick, so a step is a pure function of record and action.
"""

from __future__ import annotations

import math

import numpy as np
import pymunk
from pymunk.constraints import DampedSpring, GrooveJoint, SlideJoint

from vr_envs.envs.scene import Scene
from vr_envs.models.clock import MEET, equal_steps, left_after, piece_of, to_next_tick
from vr_envs.models.constants import G
from vr_envs.models.cruise import acceleration_to, commanded_speed
from vr_envs.models.quarter_car import lift_off
from vr_envs.models.ride_options import TICK
from vr_envs.models.terrain_ride import actuate, begin_tick, end_tick, suspension
from vr_envs.rigid_body.ground import BareGround, Ground, Profiles

HEIGHT = 100.0  # m, from the wheel to the hub and from there to the mass, at rest: more than any of them moves
FAR = 1e4  # m, ends of grooves
ORIGIN = 0.0, 0.0
HEAVY = 1e3  # mass of a wheel without tyre, in sprung masses
SLACK = 1e-3  # m/s, by which the wheel is pressed down harder than the ground asks for
TAME = 2.0  # inverse of the patch's angular frequency times the step; stable above 1/2
GROUND = ("undulation", "road", "profile", "bumps", "obstacle", "wheel")


class TerrainRideSimulator:
    """Moves the state of a ride in one scene."""

    def __init__(self, scene: Scene) -> None:
        """`scene` has the engine `rigid_body`."""
        self.scene = scene
        self.params, options = scene.records()
        self.options = dict(zip(scene.options, options, strict=True))
        self.ground = tuple(self.options[name] for name in GROUND)
        self.profiles = None if self.options["wheel"] is None else Profiles(self.ground)
        self.step = scene.simulators["rigid_body"].step

    def advance(self, state: np.void, action: np.ndarray) -> None:
        """Move `state` in place by one control interval.

        Args:
            state: record of the task's `State`.
            action: numbers in [-1, 1]: damping and modulus, or the force; then the speed, where it is an action.
        """
        lag, cruise, tyre, metrics = (self.options[name] for name in ("lag", "cruise", "tyre", "metrics"))
        state["touches"] = 0
        if lag is None:
            actuate(state, action, lag, cruise)
        total, target = self.scene.params.dt + float(state["owed"]), self.scene.params.speed
        if cruise is not None:
            target = commanded_speed(action[-1], cruise)
        left, first, ticks = total, float(state["time_to_tick"]) or TICK, 0
        while left > MEET:
            if state["time_to_tick"] == 0.0:
                begin_tick(state, action, lag, cruise)
            piece = piece_of(left, state["time_to_tick"])
            vehicle = Vehicle(self, state, piece, target)
            vehicle.run()
            left -= piece
            state["time_to_tick"], ticked = to_next_tick(state["time_to_tick"], piece, 0.0)
            if ticked:
                end_tick(state, vehicle.gamma, self.params, tyre, metrics)
                ticks += 1
                left = left_after(total, first, ticks, TICK)
        state["owed"] = left

    def ways(self, state: np.void, times: np.ndarray, target: float) -> np.ndarray:
        """How far (m) the wheel has come after the times (s), the last of which is where the record will be."""
        cruise = self.options["cruise"]
        if cruise is None:
            return self.scene.params.speed * times
        speed = float(state["speed"])
        acceleration, until = acceleration_to(speed, target, cruise)
        early = np.minimum(times, until)
        state["speed"] = target if times[-1] >= until else speed + acceleration * times[-1]
        return (speed + 0.5 * acceleration * early) * early + target * (times - early)


class Vehicle:
    """The space of one tick or a part of one, and the record that it moves."""

    def __init__(self, simulator: TerrainRideSimulator, state: np.void, time: float, target: float) -> None:
        """The vehicle of `state`, for a `time` (s) in which its speed goes towards `target` (m/s)."""
        self.simulator, self.state, self.params = simulator, state, simulator.scene.params
        self.stop, self.tyre = (simulator.scene.options[name] for name in ("stop", "tyre"))
        self.side, self.touches = float(state["side"]), 0
        self.steps = equal_steps(time, simulator.step)
        self.dt = time / self.steps
        self.gamma, self.w2, self.force = suspension(state, simulator.params)
        times = np.append(self.dt * (np.arange(self.steps + 1) - 0.5), time)
        ways = simulator.ways(state, times, target)
        if simulator.profiles is None:
            self.ground = Ground(state, ways, self.dt, simulator.ground)
        else:
            self.ground = BareGround(state, ways, self.dt, simulator.ground, simulator.profiles)
        self.press = self.ground.change + SLACK
        overlap = self.press * self.dt
        self.space = pymunk.Space()
        self.space.gravity = 0.0, -G
        self.space.collision_bias = 0.0
        self.space.collision_slop = 2.0 * overlap
        self._build(self.ground.lay(self.space, overlap))

    def _body(self, mass: float, height: float, velocity: float) -> pymunk.Body:
        """A body that moves up and down in a groove, half a step back from where it is at `height`."""
        body = pymunk.Body(mass, math.inf)
        body.velocity = 0.0, velocity
        body.position = 0.0, height - 0.5 * self.dt * velocity
        groove = GrooveJoint(self.space.static_body, body, (0.0, -FAR), (0.0, FAR), ORIGIN)
        self.space.add(body, groove)
        return body

    def _build(self, radius: float) -> None:
        """The bodies and springs, from the wheel of a `radius` (m) upwards."""
        state, p = self.state, self.params
        if self.tyre is None:
            self.base = 0.0
            self.wheel = self.hub = self._body(HEAVY * p.mass, 0.0, self.ground.rate)
            self.pull = -self.press / self.dt * self.wheel.mass
        else:
            self.base = HEIGHT
            self._build_tyre(HEIGHT + float(state["deflection"]), float(state["hub_velocity"]))
            self.pull = 0.0
        self.space.add(pymunk.Circle(self.wheel, radius))
        height = self.base + float(state["deflection"]) + HEIGHT + float(state["travel"])
        self.mass = self._body(p.mass, height, float(state["velocity"]))
        self.length = HEIGHT + (G + self.force) / self.w2
        damping = p.mass * self.gamma
        spring = DampedSpring(self.hub, self.mass, ORIGIN, ORIGIN, self.length, p.mass * self.w2, damping * p.relative)
        if self.stop is not None:
            spring.force_func = self._force
        self.space.add(spring)
        if not p.relative:
            self.space.add(DampedSpring(self.space.static_body, self.mass, (0.0, -FAR), ORIGIN, 0.0, 0.0, damping))

    def _build_tyre(self, height: float, velocity: float) -> None:
        """Hub at a height over the ground, its tyre and the patch that touches the ground."""
        rate = self.tyre.rate
        self.free = HEIGHT + lift_off(self.simulator.params, self.simulator.options["tyre"])
        self.hub = self._body(self.tyre.unsprung_mass, height, velocity)
        low, falling = 0.0, self.ground.rate
        if height > self.free:
            low, falling = height - self.free, velocity
        self.wheel = self._body(rate * (TAME * self.dt) ** 2, low, falling)
        spring = DampedSpring(self.wheel, self.hub, ORIGIN, ORIGIN, self.free, rate, 0.0)
        reach = SlideJoint(self.wheel, self.hub, ORIGIN, ORIGIN, 0.0, self.free)
        self.space.add(spring, reach)

    def _force(self, spring: DampedSpring, length: float) -> float:
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
        ground, lift, state = self.ground, self.params.mass * float(self.state["payload"]), self.state
        airborne = bool(state["airborne"])
        for step in range(self.steps):
            ground.roll(step)
            self.mass.force = 0.0, lift
            self.wheel.force = 0.0, self.pull
            self.space.step(self.dt)
            if self.tyre is not None:
                lifted = self.hub.position.y - ground.heights[step] > self.free
                state["liftoffs"] += lifted and not airborne
                state["airborne_time"] += self.dt * lifted
                airborne = lifted
        state["airborne"] = airborne
        state["touches"] += self.touches
        state["side"] = self.side
        hub = ground.end if self.tyre is None else self._now(self.hub) - self.base
        state["travel"] = self._now(self.mass) - self.base - HEIGHT - hub
        state["velocity"] = self.mass.velocity.y
        if self.tyre is not None:
            state["deflection"] = hub - ground.end
            state["hub_velocity"] = self.hub.velocity.y

    def _now(self, body: pymunk.Body) -> float:
        """Height of a body at the end of the last step, half a step ahead of its place in the space."""
        return body.position.y + 0.5 * self.dt * body.velocity.y


SIMULATOR = TerrainRideSimulator
