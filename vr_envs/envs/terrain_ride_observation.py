"""The ride's observation and actions: sensors with small errors, the actuators, and the road ahead.

What a quarter car and a choice of speed add stands between the sensors of the lecture's vehicle and the actuators.
"""

from __future__ import annotations

import dataclasses
import math
from typing import NamedTuple

import numpy as np

from vr_envs.envs.scene import Scene
from vr_envs.envs.task import Channel
from vr_envs.models.jit import kernel
from vr_envs.models.noise import uniform
from vr_envs.models.record import quantity
from vr_envs.models.road import place_on_road, road_height
from vr_envs.models.terrain import undulation_ahead

# What 1 stands for in an observation; everything is clipped at LIMIT times that.
TRAVEL, RATE, ACCELERATION = 0.05, 0.5, 2.0  # m, m/s, m/s^2
DEFLECTION, HUB_VELOCITY = 0.02, 1.0  # m, m/s
LIMIT = 5.0
NOISE_DRAWS = 1 << 50  # first counter of the sensors' draws, four for each observation
HUB_DRAWS = 1 << 51  # of the hub's two sensors


@dataclasses.dataclass(frozen=True)
class Preview:
    """Heights of the road ahead of the wheel, over the road under it."""

    horizon: float = quantity(0.3, "s", "time to reach the farthest sample", low=0.01, high=10.0)
    samples: int = quantity(10, "", "evenly spaced samples", low=1, high=60)


@dataclasses.dataclass(frozen=True)
class SensorNoise:
    """Standard deviations of the sensors' errors, which are uniform and independent."""

    travel: float = quantity(0.0005, "m", "of the travel", low=0.0, high=0.1)
    travel_rate: float = quantity(0.02, "m/s", "of the travel rate", low=0.0, high=10.0)
    velocity: float = quantity(0.02, "m/s", "of the velocity", low=0.0, high=10.0)
    acceleration: float = quantity(0.1, "m/s^2", "of the acceleration", low=0.0, high=100.0)
    deflection: float = quantity(0.0005, "m", "of the tyre's deflection", low=0.0, high=0.1)
    hub_velocity: float = quantity(0.05, "m/s", "of the hub's velocity", low=0.0, high=10.0)


@kernel
def _put(row, i, value, one):  # type: ignore[no-untyped-def]
    row[i] = min(LIMIT, max(-LIMIT, value * (1.0 / one)))


@kernel
def _error(state, counter, deviation):  # type: ignore[no-untyped-def]
    return deviation * math.sqrt(12.0) * (uniform(state.key, counter) - 0.5)


@kernel
def _observe_hub(state, row, noise):  # type: ignore[no-untyped-def]
    deflection, velocity = state.deflection, state.hub_velocity
    if noise is not None:
        counter = HUB_DRAWS + 2 * state.steps
        deflection += _error(state, counter, noise.deflection)
        velocity += _error(state, counter + 1, noise.hub_velocity)
    _put(row, 5, deflection, DEFLECTION)
    _put(row, 6, velocity, HUB_VELOCITY)


@kernel
def lateness(state, params, cruise):
    """Distance [m] by which the ride is behind its schedule, negative ahead of it."""
    return cruise.schedule * state.steps * params.dt - state.distance


@kernel
def observe(
    state, row, params, undulation, road, profile, bumps, obstacle, wheel, tyre, stop, payload, lag, cruise,
    preview, noise, textbook, metrics,
):  # type: ignore[no-untyped-def]  # fmt: skip
    """Write the observation of a record into `row` (float32, the channels of `channels`)."""
    travel, rate, velocity, acceleration = state.travel, state.travel_rate, state.velocity, state.acceleration
    if noise is not None:
        counter = NOISE_DRAWS + 4 * state.steps
        travel += _error(state, counter, noise.travel)
        rate += _error(state, counter + 1, noise.travel_rate)
        velocity += _error(state, counter + 2, noise.velocity)
        acceleration += _error(state, counter + 3, noise.acceleration)
    _put(row, 0, travel, TRAVEL)
    _put(row, 1, rate, RATE)
    _put(row, 2, velocity, RATE)
    _put(row, 3, acceleration, ACCELERATION)
    _put(row, 4, state.weighted, ACCELERATION)
    first = 5
    if tyre is not None:
        _observe_hub(state, row, noise)
        first += 2
    if cruise is not None:
        _put(row, first, state.speed, cruise.fastest)
        _put(row, first + 1, lateness(state, params, cruise), cruise.lateness)
        first += 2
    row[first] = state.position[0]
    first += 1
    if params.active == 0.0:
        row[first] = state.position[1]
        first += 1
    if preview is not None:
        ahead = params.speed * preview.horizon / preview.samples
        here, place, stride = 0.0, 0.0, 0.0
        if road is not None:
            place, stride = place_on_road(state, road), ahead / road.knot_spacing
            here += road_height(state, place)
        if undulation is not None:
            here += undulation_ahead(state, 0.0, undulation)
        for i in range(preview.samples):
            height = -here
            if road is not None:
                height += road_height(state, place + stride * (i + 1))
            if undulation is not None:
                height += undulation_ahead(state, ahead * (i + 1), undulation)
            _put(row, first + i, height, TRAVEL)


class Reading(NamedTuple):
    """What an observation batch says, in SI units; one row per environment. Zeros for what a scene does not have."""

    travel: np.ndarray  # m, (n,)
    travel_rate: np.ndarray  # m/s, (n,)
    velocity: np.ndarray  # m/s, (n,)
    acceleration: np.ndarray  # m/s^2, (n,)
    weighted: np.ndarray  # m/s^2, (n,)
    deflection: np.ndarray  # of the tyre, m, (n,)
    hub_velocity: np.ndarray  # m/s, (n,)
    speed: np.ndarray  # over the ground, m/s, (n,)
    lateness: np.ndarray  # distance behind the schedule, m, (n,)
    position: np.ndarray  # of the suspension's actuators, in [-1, 1], (n, their number)
    ahead: np.ndarray  # m, road over the road under the wheel, (n, samples of the preview)


def read(observations: np.ndarray, scene: Scene) -> Reading:
    """The inverse of `observe` for a batch (n, width)."""
    row = np.asarray(observations, np.float64)
    zero = np.zeros(len(row))
    deflection = hub_velocity = late = zero
    speed, first = np.full(len(row), scene.params.speed), 5
    if scene.options["tyre"] is not None:
        deflection, hub_velocity = row[:, 5] * DEFLECTION, row[:, 6] * HUB_VELOCITY
        first += 2
    cruise = scene.options["cruise"]
    if cruise is not None:
        speed, late = row[:, first] * cruise.fastest, row[:, first + 1] * cruise.lateness
        first += 2
    ahead = first + len(suspension_channels(scene))
    return Reading(
        travel=row[:, 0] * TRAVEL,
        travel_rate=row[:, 1] * RATE,
        velocity=row[:, 2] * RATE,
        acceleration=row[:, 3] * ACCELERATION,
        weighted=row[:, 4] * ACCELERATION,
        deflection=deflection,
        hub_velocity=hub_velocity,
        speed=speed,
        lateness=late,
        position=row[:, first:ahead],
        ahead=row[:, ahead:] * TRAVEL,
    )


def distances_ahead(scene: Scene) -> np.ndarray:
    """Distances [m] ahead of the wheel of the preview's samples; none without a preview."""
    preview = scene.options["preview"]
    if preview is None:
        return np.zeros(0)
    return scene.params.speed * preview.horizon * np.arange(1, preview.samples + 1) / preview.samples


def suspension_channels(scene: Scene) -> tuple[Channel, ...]:
    """Damping and modulus, or the force."""
    p = scene.params
    if p.active:
        return (Channel("force", "N", f"between mass and wheel, lifts the mass if > 0; 1 is {p.force:g} N"),)
    return (
        Channel(
            "damping", "1/s", f"c/m on a logarithmic scale, {p.damping_low:g} at -1 to {p.damping_high:g} 1/s at 1"
        ),
        Channel(
            "modulus", "1", f"of the spring on a logarithmic scale, {p.modulus_low:g} at -1 to {p.modulus_high:g} at 1"
        ),
    )


def action_channels(scene: Scene) -> tuple[Channel, ...]:
    """What the suspension is told, and the speed where it can be chosen."""
    cruise = scene.options["cruise"]
    if cruise is None:
        return suspension_channels(scene)
    speed = Channel("speed", "m/s", f"over the ground, {cruise.slowest:g} at -1 to {cruise.fastest:g} m/s at 1")
    return (*suspension_channels(scene), speed)


def channels(scene: Scene) -> tuple[Channel, ...]:
    """The numbers of an observation; a controller finds them by name."""
    tyre, cruise = scene.options["tyre"], scene.options["cruise"]
    sensors = [
        ("travel", "m", TRAVEL, "height of the mass over the wheel, from levelled rest"),
        ("travel rate", "m/s", RATE, "mean over the last tick"),
        ("velocity", "m/s", RATE, "vertical, of the mass"),
        ("acceleration", "m/s^2", ACCELERATION, "vertical, of the mass, mean over the last tick"),
        ("weighted acceleration", "m/s^2", ACCELERATION, "the acceleration through Wk, without sensor error"),
    ]
    if tyre is not None:
        sensors += [
            ("tyre deflection", "m", DEFLECTION, "height of the hub over the ground, from levelled rest"),
            ("hub velocity", "m/s", HUB_VELOCITY, "vertical, of the wheel"),
        ]
    if cruise is not None:
        sensors += [
            ("speed", "m/s", cruise.fastest, "over the ground"),
            ("lateness", "m", cruise.lateness, "distance behind the schedule"),
        ]
    # a choice of speed makes times of the distances that are seen
    ahead = [f"{d:.3g} m" if cruise is not None else f"{d / scene.params.speed:.3g} s" for d in distances_ahead(scene)]
    roads = [(f"road {where} ahead", "m", TRAVEL, "height over the road under the wheel") for where in ahead]
    measured, seen = (
        [Channel(name, unit, f"{doc}; 1 is {one:g} {unit}", -LIMIT, LIMIT) for name, unit, one, doc in group]
        for group in (sensors, roads)
    )
    actuators = [Channel(f"{c.name} actuator", c.unit, f"its position; {c.doc}") for c in suspension_channels(scene)]
    return (*measured, *actuators, *seen)
