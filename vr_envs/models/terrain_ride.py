"""Mass on a spring and damper over rough ground: the lecture's wheel that follows it, or a quarter car.

Frame: heights up. zeta is the height of the mass above its levelled static equilibrium, r the height of the terrain
under the wheel, u = zeta - r the travel of the spring (> 0: extended). Gravity has gone into the equilibrium, and the
spring is levelled there: changing its modulus while it runs does not lift the mass. What happens between wheel, mass
and ground is in `follower` and, with the option `tyre`, in `quarter_car`. What both share is in `ride_pieces`: the
road's pieces and the forward speed; and here: actuators and ticks.

Actuators, and what is measured, belong to ticks of 0.01 s, whatever the control interval is. Between them the ride is
exact over any time, so a whole ride has no integration error and does not depend on how it is split.
"""

from __future__ import annotations

import dataclasses
import math

from vr_envs.models.clock import MEET, left_after, piece_of, to_next_tick
from vr_envs.models.cruise import commanded_speed
from vr_envs.models.elementary import exp
from vr_envs.models.jit import kernel
from vr_envs.models.quarter_car import settle
from vr_envs.models.record import quantity
from vr_envs.models.ride_meter import MeterState, sample
from vr_envs.models.ride_options import TICK
from vr_envs.models.ride_pieces import ride
from vr_envs.models.ride_textbook import drift, kick, step_of
from vr_envs.models.road import RoadState
from vr_envs.models.terrain import WAVES


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
    owed: float = quantity(0.0, "s", "by which the last interval ended early", low=-2.0 * MEET, high=2.0 * MEET)
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
def actuate(state, action, lag, cruise):
    """Move the suspension's actuators towards the command, over one tick, and hold their mean.

    The positions are those when the tick ends, and the means those that act in it. Without a lag they are there at
    once. With `cruise` the last command is the speed's.
    """
    width = action.shape[0]
    if cruise is not None:
        width -= 1
    for i in range(width):
        command = action[i]
        if lag is None:
            state.held[i] = command
            state.position[i] = command
        else:
            position = state.position[i]
            gap = command - position
            state.held[i] = command - lag.missing * gap
            state.position[i] = position + lag.share * gap


@kernel
def suspension(state, params):
    """Damping gamma [1/s], w2 [1/s^2] and force over sprung mass [m/s^2] that the positions held give."""
    if params.active > 0.0:
        return params.passive_damping, params.w2, params.push * state.held[0]
    gamma = exp(params.damping_centre + params.damping_half * state.held[0])
    modulus = exp(params.modulus_centre + params.modulus_half * state.held[1])
    return gamma, params.w2 * modulus, 0.0


@kernel
def rest(state, params, tyre):
    """Put the mass, on level ground, where spring and tyre balance force and payload; at the scene's speed."""
    _, w2, force = suspension(state, params)
    state.travel = (force + state.payload) / w2
    state.speed = params.speed
    if tyre is not None:
        settle(state, params, tyre)


@kernel
def begin_tick(state, action, lag, cruise):
    """What is fixed for a tick: the mean positions of actuators that lag, and where its means are taken from."""
    state.time_to_tick = TICK
    state.tick_travel, state.tick_velocity = state.travel, state.velocity
    if lag is not None:
        actuate(state, action, lag, cruise)


@kernel
def _take_means(state, travel, velocity, gamma, params, tyre, metrics):
    """The means over a tick that has ended, from travel and velocity at its begin, and the measurements."""
    state.travel_rate = (state.travel - travel) * (1.0 / TICK)
    state.acceleration = (state.velocity - velocity) * (1.0 / TICK)
    sample(state, gamma, params, tyre, metrics)


@kernel
def end_tick(state, gamma, params, tyre, metrics):
    """The means over the tick that has ended, and the measurements; `gamma` [1/s] was the damping at its end."""
    _take_means(state, state.tick_travel, state.tick_velocity, gamma, params, tyre, metrics)


@kernel
def even(state, params):
    """Whether the next control interval is one whole tick."""
    return (state.time_to_tick == 0.0) & (abs(params.dt + state.owed - TICK) <= MEET)


@kernel
def advance_evenly(state, action, params, undulation, road, profile, bumps, obstacle, wheel, stop, lag, metrics):
    """`advance` of a record for which `even` holds, on lanes too."""
    state.touches = 0
    actuate(state, action, lag, None)
    travel, velocity = state.travel, state.velocity
    gamma, w2, force = suspension(state, params)
    ride(
        state, TICK, gamma, w2, force, params.speed, params,
        undulation, road, profile, bumps, obstacle, wheel, None, stop, None,
    )  # fmt: skip
    _take_means(state, travel, velocity, gamma, params, None, metrics)
    state.owed = left_after(params.dt + state.owed, TICK, 1, TICK)


@kernel
def advance(
    state, action, params, undulation, road, profile, bumps, obstacle, wheel, tyre, stop, lag, cruise, textbook, metrics
):
    """Move by one control interval, from tick to tick.

    `action` in [-1, 1]: damping and modulus (logarithmic), or the force; then the speed, an action with `cruise`.
    Actuators that lag move at the ticks, others at once.
    """
    if tyre is None and cruise is None and textbook is None:
        if even(state, params):
            advance_evenly(state, action, params, undulation, road, profile, bumps, obstacle, wheel, stop, lag, metrics)
            return
    state.touches = 0
    if lag is None:
        actuate(state, action, lag, cruise)
    total, target, step, rise = params.dt + state.owed, params.speed, 0.0, 0.0
    if cruise is not None:
        target = commanded_speed(action[action.shape[0] - 1], cruise)
    if textbook is not None:
        step = step_of(params, textbook)
    to_step, to_tick = step, state.time_to_tick
    first, ticks = (to_tick if to_tick > 0.0 else TICK), 0
    left = total
    while left > MEET:
        if to_tick == 0.0:
            to_tick = TICK
            begin_tick(state, action, lag, cruise)
        piece = piece_of(left, to_tick)
        gamma, w2, force = suspension(state, params)
        if textbook is None:
            ride(
                state, piece, gamma, w2, force, target, params,
                undulation, road, profile, bumps, obstacle, wheel, tyre, stop, cruise,
            )  # fmt: skip
        else:
            piece = piece_of(piece, to_step)
            rise += drift(state, piece, params, undulation, road, profile, bumps, obstacle, wheel)
            to_step, stepped = to_next_tick(to_step, piece, step)
            if stepped:
                kick(state, step, rise, gamma, w2, force + state.payload, textbook)
                rise = 0.0
        left -= piece
        to_tick, ticked = to_next_tick(to_tick, piece, 0.0)
        if ticked:
            end_tick(state, gamma, params, tyre, metrics)
            ticks += 1
            left = left_after(total, first, ticks, TICK)
    state.time_to_tick, state.owed = to_tick, left
