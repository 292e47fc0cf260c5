"""The ride's observation: sensors with small errors, the actuators, and the road ahead."""

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
LIMIT = 5.0
NOISE_DRAWS = 1 << 50  # first counter of the sensors' draws, four for each observation


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


@kernel
def _put(row, i, value, one):  # type: ignore[no-untyped-def]
    row[i] = min(LIMIT, max(-LIMIT, value * (1.0 / one)))


@kernel
def _error(state, sensor, deviation):  # type: ignore[no-untyped-def]
    return deviation * math.sqrt(12.0) * (uniform(state.key, NOISE_DRAWS + 4 * state.steps + sensor) - 0.5)


@kernel
def observe(
    state, row, params, undulation, road, profile, bumps, obstacle, wheel, tyre, stop, payload, lag, cruise,
    preview, noise, textbook,
):  # type: ignore[no-untyped-def]  # fmt: skip
    """Write the observation of a record into `row` (float32, the channels of `channels`)."""
    travel, rate, velocity, acceleration = state.travel, state.travel_rate, state.velocity, state.acceleration
    if noise is not None:
        travel += _error(state, 0, noise.travel)
        rate += _error(state, 1, noise.travel_rate)
        velocity += _error(state, 2, noise.velocity)
        acceleration += _error(state, 3, noise.acceleration)
    _put(row, 0, travel, TRAVEL)
    _put(row, 1, rate, RATE)
    _put(row, 2, velocity, RATE)
    _put(row, 3, acceleration, ACCELERATION)
    _put(row, 4, state.weighted, ACCELERATION)
    row[5] = state.position[0]
    first = 6
    if params.active == 0.0:
        row[6] = state.position[1]
        first = 7
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
    """What an observation batch says, in SI units; one row per environment."""

    travel: np.ndarray  # m, (n,)
    travel_rate: np.ndarray  # m/s, (n,)
    velocity: np.ndarray  # m/s, (n,)
    acceleration: np.ndarray  # m/s^2, (n,)
    weighted: np.ndarray  # m/s^2, (n,)
    position: np.ndarray  # of the actuators, in [-1, 1], (n, action width)
    ahead: np.ndarray  # m, road over the road under the wheel, (n, samples of the preview)


def read(observations: np.ndarray, scene: Scene) -> Reading:
    """The inverse of `observe` for a batch (n, width)."""
    row = np.asarray(observations, np.float64)
    first = 5 + len(action_channels(scene))
    return Reading(
        travel=row[:, 0] * TRAVEL,
        travel_rate=row[:, 1] * RATE,
        velocity=row[:, 2] * RATE,
        acceleration=row[:, 3] * ACCELERATION,
        weighted=row[:, 4] * ACCELERATION,
        position=row[:, 5:first],
        ahead=row[:, first:] * TRAVEL,
    )


def action_channels(scene: Scene) -> tuple[Channel, ...]:
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


def channels(scene: Scene) -> tuple[Channel, ...]:
    """The numbers of an observation; a controller finds them by name."""
    preview = scene.options["preview"]
    ahead = () if preview is None else [preview.horizon * (i + 1) / preview.samples for i in range(preview.samples)]
    sensors = (
        ("travel", "m", TRAVEL, "height of the mass over the wheel, from levelled rest"),
        ("travel rate", "m/s", RATE, "mean over the last interval"),
        ("velocity", "m/s", RATE, "vertical, of the mass"),
        ("acceleration", "m/s^2", ACCELERATION, "vertical, of the mass, mean over the last interval"),
        ("weighted acceleration", "m/s^2", ACCELERATION, "the acceleration through Wk, without sensor error"),
        *((f"road {t:.3g} s ahead", "m", TRAVEL, "height over the road under the wheel") for t in ahead),
    )
    measured = [Channel(name, unit, f"{doc}; 1 is {one:g} {unit}", -LIMIT, LIMIT) for name, unit, one, doc in sensors]
    actuators = [Channel(f"{c.name} actuator", c.unit, f"its position; {c.doc}") for c in action_channels(scene)]
    return (*measured[:5], *actuators, *measured[5:])
