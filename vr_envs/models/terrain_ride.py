"""Mass on a spring and damper over a wheel that follows the terrain (the lecture's equations 3.89 and 3.90).

Frame: heights up. zeta is the height of the mass above its levelled static equilibrium, r the height of the terrain
under the wheel, u = zeta - r the travel of the spring (> 0: extended). The wheel is a point that never leaves the
ground. Gravity has gone into the equilibrium, and the spring is levelled there: changing its modulus while it runs
does not lift the mass. With gamma = c/m, w2 = k/m and the acceleration `push` that payload and force give,

    zeta'' + gamma zeta' + w2 zeta = w2 r + [gamma r'] + push                               (3.90, exact in time)

The term in brackets is there for a damper between mass and wheel ("relative"), and not for the lecture's factor k_d,
which damps the mass's own velocity ("absolute"). h of 3.89 is read as the height of the terrain since the start, the
only reading that does not depend on the step.

On a straight piece of road u obeys a free damped spring with a constant push; over sines the particular solution is a
phasor. Both are exact over any time, so a whole ride has no integration error.
"""

from __future__ import annotations

import dataclasses
import math

from vr_envs.models.clock import piece_of, to_next_tick
from vr_envs.models.jit import kernel
from vr_envs.models.record import quantity
from vr_envs.models.ride_meter import MeterState, sample
from vr_envs.models.ride_options import TICK
from vr_envs.models.ride_textbook import drift, kick, step_of
from vr_envs.models.road import RoadState, pass_knot, slope_of_road
from vr_envs.models.spring import free_motion
from vr_envs.models.terrain import WAVES, roll_undulation, wave
from vr_envs.models.travel_stop import move_with_stop


@dataclasses.dataclass(frozen=True)
class Params:
    """A quarter of a car without its tyre; mass and spring rate as widely used, ride frequency 1.21 Hz."""

    mass: float = quantity(290.0, "kg", "sprung mass", low=1.0, high=1e5)
    spring_rate: float = quantity(16812.0, "N/m", "spring rate at modulus 1", low=1.0, high=1e7)
    speed: float = quantity(20.0, "m/s", "speed over the ground", low=0.1, high=100.0)
    damping: str = quantity("relative", "", "what the damper acts on", choices=("relative", "absolute"))
    damping_low: float = quantity(0.3, "1/s", "least damping c/m", low=1e-3, high=1e3)
    damping_high: float = quantity(10.0, "1/s", "greatest damping c/m", low=1e-3, high=1e3)
    modulus_low: float = quantity(0.5, "", "least spring modulus, as a fraction", low=0.01, high=100.0)
    modulus_high: float = quantity(2.0, "", "greatest spring modulus, as a fraction", low=0.01, high=100.0)
    actuation: str = quantity(
        "semi_active", "", "damping and modulus, or a force between mass and wheel", choices=("semi_active", "active")
    )
    passive_damping: float = quantity(1.0, "1/s", "c/m beside the force", low=1e-3, high=1e3)
    force: float = quantity(1450.0, "N", "largest force", low=1.0, high=1e6)
    comfort: float = quantity(1.0, "m/s^2", "weighted acceleration that halves the reward", low=1e-3, high=1e3)
    rattle: float = quantity(0.03, "m", "travel that halves the reward", low=1e-4, high=10.0)
    dt: float = quantity(TICK, "s", "control interval", low=1e-3, high=10.0)

    DERIVED = (
        "w2", "relative", "active", "push", "damping_centre", "damping_half", "modulus_centre", "modulus_half",
    )  # fmt: skip

    @property
    def w2(self) -> float:
        """Square of the natural angular frequency at modulus 1 [1/s^2]."""
        return self.spring_rate / self.mass

    @property
    def relative(self) -> float:
        """1 for relative, 0 for absolute damping."""
        return float(self.damping == "relative")

    @property
    def active(self) -> float:
        """1 where the action is a force."""
        return float(self.actuation == "active")

    @property
    def push(self) -> float:
        """Acceleration of the largest force [m/s^2]."""
        return self.force / self.mass

    @property
    def damping_centre(self) -> float:
        """Logarithm of the damping at position 0."""
        return 0.5 * math.log(self.damping_high * self.damping_low)

    @property
    def damping_half(self) -> float:
        """Half the logarithmic range of the damping."""
        return 0.5 * math.log(self.damping_high / self.damping_low)

    @property
    def modulus_centre(self) -> float:
        """Logarithm of the modulus at position 0."""
        return 0.5 * math.log(self.modulus_high * self.modulus_low)

    @property
    def modulus_half(self) -> float:
        """Half the logarithmic range of the modulus."""
        return 0.5 * math.log(self.modulus_high / self.modulus_low)


@dataclasses.dataclass(frozen=True)
class State(RoadState, MeterState):
    """The ride, the terrain that it has drawn, and what has been measured."""

    key: int = quantity(0, "", "episode key", kind="key")
    steps: int = quantity(0, "", "control intervals done", low=0)
    time_to_tick: float = quantity(0.0, "s", "until this tick ends; 0: one begins", low=0.0, high=TICK)
    climb: float = quantity(0.0, "m", "height of the ground over that at the start, kept by the textbook engine")
    travel: float = quantity(0.0, "m", "u = zeta - r, or of the suspension of a quarter car")
    velocity: float = quantity(0.0, "m/s", "zeta', of the mass, up")
    deflection: float = quantity(0.0, "m", "height of the hub over the ground, from static; compressed: < 0")
    hub_velocity: float = quantity(0.0, "m/s", "of the hub of a quarter car, up")
    tick_travel: float = quantity(0.0, "m", "travel when this tick began")
    tick_velocity: float = quantity(0.0, "m/s", "velocity of the mass when this tick began")
    travel_rate: float = quantity(0.0, "m/s", "mean of u' over the last tick")
    acceleration: float = quantity(0.0, "m/s^2", "mean of zeta'' over the last tick")
    payload: float = quantity(0.0, "m/s^2", "constant acceleration that an unknown load gives")
    side: float = quantity(0.0, "", "+1 or -1 in contact with the stop at that end, else 0", low=-1.0, high=1.0)
    touches: int = quantity(0, "", "touches of a stop in the last interval", low=0)
    airborne: bool = quantity(False, "", "the tyre is off the ground")
    liftoffs: int = quantity(0, "", "times that the tyre left the ground so far", low=0)
    airborne_time: float = quantity(0.0, "s", "time that it was off the ground so far", low=0.0)
    fault: bool = quantity(False, "", "a search for a contact, or the contacts in one piece of road, did not end")
    position: float = quantity(0.0, "", "of the actuators, when this tick began", shape=(2,), low=-1.0, high=1.0)
    held: float = quantity(0.0, "", "mean position over this tick, acts", shape=(2,), low=-1.0, high=1.0)
    speed: float = quantity(0.0, "m/s", "over the ground", low=0.0, high=100.0)
    distance: float = quantity(0.0, "m", "covered so far", low=0.0)
    wave_cos: float = quantity(0.0, "", "cosines of the undulation's phases", shape=(WAVES,))
    wave_sin: float = quantity(0.0, "", "sines of the undulation's phases", shape=(WAVES,))


@kernel
def actuate(state, action, lag):
    """Move the actuators' positions towards the command, over one tick, and hold their mean; without a lag, be there.

    The positions are those when the tick ends, and the means those that act in it.
    """
    for i in range(action.shape[0]):
        share, missing = 1.0, 0.0
        if lag is not None:
            share, missing = lag.share, lag.missing
        gap = action[i] - state.position[i]
        state.held[i] = action[i] - missing * gap
        state.position[i] += share * gap


@kernel
def suspension(state, params):
    """Damping gamma [1/s], w2 [1/s^2] and push [m/s^2] that the positions held and the payload give."""
    if params.active > 0.0:
        return params.passive_damping, params.w2, state.payload + params.push * state.held[0]
    gamma = math.exp(params.damping_centre + params.damping_half * state.held[0])
    modulus = math.exp(params.modulus_centre + params.modulus_half * state.held[1])
    return gamma, params.w2 * modulus, state.payload


@kernel
def over_sines(state, gamma, w2, params, undulation):
    """Height r of the sines under the wheel, and the steady ride over them: its height and velocity.

    The transfer function from r to zeta at the angular frequency W is
    (w2 + [i gamma W]) / (w2 - W^2 + i gamma W).
    """
    terrain, height, velocity = 0.0, 0.0, 0.0
    for i in range(WAVES):
        amplitude, number = wave(i, undulation)
        frequency = number * params.speed
        sine, cosine = amplitude * state.wave_sin[i], amplitude * state.wave_cos[i]
        drag, spring = gamma * frequency, w2 - frequency * frequency
        size = spring * spring + drag * drag
        real = (w2 * spring + params.relative * drag * drag) / size
        imaginary = drag * (params.relative * spring - w2) / size
        terrain += sine
        height += real * sine + imaginary * cosine
        velocity += frequency * (real * cosine - imaginary * sine)
    return terrain, height, velocity


@kernel
def straight(state, u, v, slope, gamma, w2, push, t, params, stop):
    """Ride for the time t over ground of one slope [height over time, m/s]: travel and velocity of the mass."""
    push -= (1.0 - params.relative) * gamma * slope
    if stop is None:
        x, rate = free_motion(u - push / w2, v - slope, gamma, w2, t)
        return x + push / w2, rate + slope
    u, rate, state.side, touches, fault = move_with_stop(
        u, v - slope, state.side, gamma, w2, push, stop.rate / params.mass, stop.travel, t
    )
    state.touches += touches
    if fault:
        state.fault = True
    return u, rate + slope


@kernel
def ride(state, t, gamma, w2, push, params, undulation, road, profile, bumps, obstacle, wheel, tyre, stop, cruise):
    """Ride for the time t [s] with constant damping, spring and push, exactly.

    Over sines, u here is the travel without them and without the steady ride over them. A stop excludes sines.
    """
    u, v = state.travel, state.velocity
    if undulation is not None:
        terrain, height, velocity = over_sines(state, gamma, w2, params, undulation)
        u, v = u + terrain - height, v - velocity
    if road is None:
        u, v = straight(state, u, v, 0.0, gamma, w2, push, t, params, stop)
    else:
        left = t
        while left > 0.0:
            slope = slope_of_road(state, road) * params.speed
            piece = state.to_knot / params.speed
            if piece <= left:
                u, v = straight(state, u, v, slope, gamma, w2, push, piece, params, stop)
                pass_knot(state, road, profile, bumps, obstacle, wheel)
            else:
                u, v = straight(state, u, v, slope, gamma, w2, push, left, params, stop)
                state.to_knot = max(0.0, state.to_knot - params.speed * left)
            left -= piece
    if undulation is not None:
        roll_undulation(state, params.speed * t, undulation)
        terrain, height, velocity = over_sines(state, gamma, w2, params, undulation)
        u, v = u - terrain + height, v + velocity
    state.travel, state.velocity = u, v


@kernel
def begin_tick(state, action, lag):
    """What is fixed for a tick: the mean positions of actuators that lag, and where its means are taken from."""
    state.time_to_tick = TICK
    state.tick_travel, state.tick_velocity = state.travel, state.velocity
    if lag is not None:
        actuate(state, action, lag)


@kernel
def end_tick(state, gamma, params, tyre):
    """The means over the tick that has ended, and the measurements; `gamma` [1/s] was the damping at its end."""
    state.travel_rate = (state.travel - state.tick_travel) / TICK
    state.acceleration = (state.velocity - state.tick_velocity) / TICK
    sample(state, gamma, params, tyre)


@kernel
def advance(
    state, action, params, undulation, road, profile, bumps, obstacle, wheel, tyre, stop, lag, cruise, textbook
):
    """Move by one control interval; `action` in [-1, 1]: damping and modulus (logarithmic), or the force.

    Actuators that lag move at the ticks, others at once.
    """
    state.touches = 0
    if lag is None:
        actuate(state, action, lag)
    left, step, rise = params.dt, 0.0, 0.0
    if textbook is not None:
        step = step_of(params, textbook)
    to_step = step
    while left > 0.0:
        if state.time_to_tick == 0.0:
            begin_tick(state, action, lag)
        piece = piece_of(left, state.time_to_tick)
        gamma, w2, push = suspension(state, params)
        if textbook is None:
            ride(
                state, piece, gamma, w2, push, params,
                undulation, road, profile, bumps, obstacle, wheel, tyre, stop, cruise,
            )  # fmt: skip
        else:
            piece = piece_of(piece, to_step)
            rise += drift(state, piece, params, undulation, road, profile, bumps, obstacle, wheel)
            to_step, stepped = to_next_tick(to_step, piece, step)
            if stepped:
                kick(state, step, rise, gamma, w2, push, textbook)
                rise = 0.0
        left -= piece
        state.time_to_tick, ticked = to_next_tick(state.time_to_tick, piece, 0.0)
        if ticked:
            end_tick(state, gamma, params, tyre)
