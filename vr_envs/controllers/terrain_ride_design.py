"""The ride as a linear system, and the feedback that is best for it: what the optimal laws of the ride are built on.

States, from levelled rest: x = [travel u, velocity of the mass v] over a wheel that follows the ground, and
x = [u, v, deflection of the tyre d, velocity of the hub h] of a quarter car (`Plant.width` of them). Inputs: the
acceleration f that the actuator gives to the sprung mass, its reaction going to the hub, and the rate r' at which the
road rises. With w2 = k/m and the damping gamma that stands beside the actuator,

    u' = v - h        v' = -w2 u - gamma (v - h) + f        d' = h - r'        h' = -(m/mu) v' - (kt/mu) d

and h = r' where there is no tyre. A road of ISO 8608 makes r' white noise, so the best feedback needs x alone; with the
road ahead in view it needs that too. The cost is the integral of v'^2 + travel u^2 + tyre d^2, in which v' contains f:
states and force have a common term. f is held for an interval, and the cost is that of the motion in between as well.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from scipy.linalg import expm, solve_discrete_are

from vr_envs.envs.scene import Scene
from vr_envs.envs.terrain_ride_observation import Reading, distances_ahead


@dataclasses.dataclass(frozen=True)
class Plant:
    """x' = a x + force f + road r'; acceleration v' = felt x + f + jolt r'."""

    a: np.ndarray  # (width, width)
    force: np.ndarray  # (width,)
    road: np.ndarray  # (width,)
    felt: np.ndarray  # (width,)
    jolt: float
    carried: np.ndarray  # (width,), x where f carries a load of 1 m/s^2: that of the tyre is left

    @property
    def width(self) -> int:
        """Number of states."""
        return len(self.force)


def plant_of(scene: Scene) -> Plant:
    """The linear ride of `scene`; beside a force there is the passive damper, beside a semi-active damper nothing."""
    p, tyre = scene.params, scene.options["tyre"]
    gamma = p.passive_damping if p.active else 0.0
    if tyre is None:
        jolt = gamma * p.relative
        felt = np.array([-p.w2, -gamma])
        return Plant(
            np.array([[0.0, 1.0], felt]), np.array([0.0, 1.0]), np.array([-1.0, jolt]), felt, jolt, np.zeros(2)
        )
    ratio, stiffness = p.mass / tyre.unsprung_mass, tyre.rate / tyre.unsprung_mass
    felt = np.array([-p.w2, -gamma, 0.0, gamma])
    a = np.array([[0.0, 1.0, 0.0, -1.0], felt, [0.0, 0.0, 0.0, 1.0], -ratio * felt - [0.0, 0.0, stiffness, 0.0]])
    force, road = np.array([0.0, 1.0, 0.0, -ratio]), np.array([0.0, 0.0, -1.0, 0.0])
    return Plant(a, force, road, felt, 0.0, np.array([0.0, 0.0, p.mass / tyre.rate, 0.0]))


def weights(plant: Plant, travel: float, tyre: float) -> np.ndarray:
    """Diagonal of the cost of the states: `travel` [1/s^4] of u^2 and `tyre` [1/s^4] of d^2."""
    return np.array([travel, 0.0, tyre, 0.0])[: plant.width]


def optimal_feedback(
    plant: Plant, travel: float, tyre: float, interval: float, samples: int, lag: float | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Gains (K, L) of the best f = -K y - L s on a road of which `samples` intervals are in view.

    y is x, and with a `lag` also the acceleration that the actuator gives at present; s is the rise of the road in
    each coming interval.

    Args:
        plant: the linear ride.
        travel: cost of u^2 [1/s^4].
        tyre: cost of d^2 [1/s^4].
        interval: for which f is held, and the road rises at one rate [s].
        samples: intervals in view, possibly none; the road beyond is white noise.
        lag: time constant of the actuator [s]; None: it has none.

    The gain K is that of the Riccati equation; what is in view adds a term that is linear in y to the cost to go,
    and L gathers that term backwards from the farthest sample, each interval once through the closed loop.
    """
    n = plant.width + (lag is not None)
    # the states, the command f that is held, and the rise of the road, whose rate is held
    a, felt = np.zeros((n + 2, n + 2)), np.concatenate([plant.felt, np.zeros(n + 2 - plant.width)])
    a[: plant.width, : plant.width], a[: plant.width, -1] = plant.a, plant.road / interval
    if lag is not None:
        a[n - 1, n - 1], a[n - 1, n] = -1.0 / lag, 1.0 / lag
    pusher = n if lag is None else n - 1
    a[: plant.width, pusher], felt[pusher], felt[-1] = plant.force, 1.0, plant.jolt / interval
    cost = np.outer(felt, felt)
    cost[: plant.width, : plant.width] += np.diag(weights(plant, travel, tyre))
    step, cost = _sampled(a, cost, interval)
    a, b, road = step[:n, :n], step[:n, n], step[:n, -1]
    q, s, r, q_road, r_road = cost[:n, :n], cost[:n, n], cost[n, n], cost[:n, -1], cost[n, -1]
    p = solve_discrete_are(a, b[:, None], q, np.array([[r]]), s=s[:, None])
    size = r + b @ p @ b
    gain = (b @ p @ a + s) / size
    near = r_road + b @ p @ road
    coming = q_road + a.T @ p @ road - gain * near
    ahead = [near / size]
    for _ in range(samples - 1):
        ahead.append(b @ coming / size)
        coming = (a - np.outer(b, gain)).T @ coming
    return gain, np.array(ahead[:samples])


def transition(plant: Plant, duration: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """x after `duration` [s] as A x + F f + D load + R rise.

    f, and the acceleration `load` of the sprung mass alone, are constant meanwhile; the road rises evenly.
    """
    n = plant.width
    a = np.zeros((n + 3, n + 3))
    load = np.zeros(n)
    load[1] = 1.0
    a[:n, :n], a[:n, n:] = plant.a, np.stack([plant.force, load, plant.road / duration], axis=1)
    step = expm(a * duration)[:n]
    return step[:, :n], step[:, n], step[:, n + 1], step[:, n + 2]


def _sampled(a: np.ndarray, cost: np.ndarray, interval: float) -> tuple[np.ndarray, np.ndarray]:
    """e^(a t), and the integral of e^(a' t) cost e^(a t) over the interval.

    By the exponential of both together (Van Loan 1978) over a part so short that its growing half loses nothing, and
    then by doubling.
    """
    n, doublings = len(a), max(0, math.ceil(math.log2(np.linalg.norm(a, 1) * interval)))
    both = expm(np.block([[-a.T, cost], [np.zeros_like(a), a]]) * (interval / 2.0**doublings))
    step = both[n:, n:]
    spent = step.T @ both[:n, n:]
    for _ in range(doublings):
        spent = spent + step.T @ spent @ step
        step = step @ step
    return step, spent


def states_of(reading: Reading, plant: Plant) -> np.ndarray:
    """States (n, width) of the linear ride as they were observed."""
    columns = (reading.travel, reading.velocity, reading.deflection, reading.hub_velocity)
    return np.stack(columns[: plant.width], axis=1)


def rises_ahead(reading: Reading, scene: Scene, times: np.ndarray) -> np.ndarray:
    """How much the road rises (m) from each of the `times` [s] ahead, which ascend, to the next, (n, times - 1).

    At the present speed. The road is straight between the samples of the preview, and level beyond them.
    """
    heights = np.concatenate([np.zeros((len(reading.ahead), 1)), reading.ahead], axis=1)
    last = heights.shape[1] - 1
    place = np.clip(reading.speed[:, None] * times / distances_ahead(scene)[0], 0.0, last)
    left = np.minimum(place.astype(int), last - 1)
    below, above = (np.take_along_axis(heights, index, axis=1) for index in (left, left + 1))
    return np.diff(below + (place - left) * (above - below), axis=1)
