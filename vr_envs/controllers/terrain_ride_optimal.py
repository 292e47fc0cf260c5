"""Laws from a Riccati equation: the best linear force on the mass, as nearly as the suspension can give it.

The cost is the task's own in small: acceleration over `comfort`, travel over `rattle`, both squared, with a factor on
the travel to tune, since the reward does not see the acceleration itself but what a person feels of it; and the tyre's
deflection. An unknown load is estimated and taken into account (`LoadObserver`).
"""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from vr_envs.controllers.terrain_ride_design import (
    optimal_feedback,
    plant_of,
    rises_ahead,
    states_of,
    transition,
)
from vr_envs.controllers.terrain_ride_law import (
    LEAST,
    MODULUS,
    SLOW,
    Ranges,
    RideLaw,
    away_from_zero,
    damping_actions,
    force_actions,
    serves_damper,
    settings,
)
from vr_envs.envs.scene import Scene
from vr_envs.envs.terrain_ride_observation import Reading

# travel [m] below which a change of the modulus does not matter
SHORT = 1e-3


class LoadObserver:
    """Estimates the constant acceleration that an unknown load gives: what spring and damper leave unexplained.

    A first-order filter of the difference, within what the scene's loads can be; a stop in contact is not in the model,
    so nothing is learned from it.
    """

    def __init__(self, scene: Scene, rate: float) -> None:
        """`rate` of the filter [1/s]."""
        payload, stop = scene.options["payload"], scene.options["stop"]
        self.size = 0.0 if payload is None else payload.size
        self.reach = math.inf if stop is None else stop.travel
        self.share = -math.expm1(-rate * scene.params.dt)
        self.reset(0)

    def reset(self, n: int) -> None:
        """No load is known."""
        self.load = np.zeros(n)

    def update(self, reading: Reading, modelled: np.ndarray) -> np.ndarray:
        """The load [m/s^2] after one more observation, of which the model explains the acceleration `modelled`."""
        known = np.where(np.abs(reading.travel) < self.reach, self.share, 0.0)
        found = self.load + known * (reading.acceleration - modelled - self.load)
        self.load = np.clip(found, -self.size, self.size)
        return self.load


class OptimalRide(RideLaw):
    """Optimal feedback of the linear ride, from the road in view if the class looks ahead.

    A force gives what is wanted, and carries the load. A damper gives the part of it that opposes the travel's rate,
    and then the modulus of the spring what is missing, both within their ranges. The actuators arrive late: they are
    set for the motion expected after `lead`.
    """

    LOOKS_AHEAD: ClassVar[bool] = False

    def __init__(self, scene: Scene, **gains: float) -> None:
        """See `TUNABLE` of the laws."""
        super().__init__(scene, **gains)
        p, lag, preview = scene.params, scene.options["lag"], scene.options["preview"]
        self.plant = plant_of(scene)
        samples = max(1, round(preview.horizon / p.dt)) if self.LOOKS_AHEAD else 0
        delay = lag.time_constant if lag is not None and p.active else None
        travel = self.gains["travel"] * (p.comfort / p.rattle) ** 2
        self.gain, self.ahead = optimal_feedback(self.plant, travel, self.gains["tyre"], p.dt, samples, delay)
        self.times = p.dt * np.arange(samples + 1)
        self.motion = transition(self.plant, self.gains.get("lead", float(p.dt)))
        self.observer = LoadObserver(scene, self.gains["load"])

    def reset(self, n: int) -> None:
        """Forget the load."""
        self.observer.reset(n)

    def wanted(self, states: np.ndarray, reading: Reading, later: float) -> np.ndarray:
        """The best f [m/s^2] in the states (n, width) that are met `later` [s]."""
        f = -states @ self.gain
        if self.LOOKS_AHEAD:
            f -= rises_ahead(reading, self.scene, later + self.times) @ self.ahead
        return f

    def suspension(self, reading: Reading) -> np.ndarray:
        """The force, or damping and modulus."""
        return self._push(reading) if self.scene.params.active else self._damp(reading)

    def _push(self, reading: Reading) -> np.ndarray:
        p = self.scene.params
        rate = reading.travel_rate if p.relative else reading.velocity
        given = p.push * reading.position[:, 0]
        load = self.observer.update(reading, given - p.w2 * reading.travel - p.passive_damping * rate)
        states = states_of(reading, self.plant) - np.outer(load, self.plant.carried)
        if len(self.gain) > self.plant.width:
            states = np.column_stack([states, given + load])
        return force_actions(self.wanted(states, reading, 0.0) - load, self.scene)

    def _damp(self, reading: Reading) -> np.ndarray:
        p, nominal, lead = self.scene.params, self.gains["modulus"], self.gains["lead"]
        damping, modulus = settings(reading.position, self.scene)
        given = -damping * reading.travel_rate - p.w2 * modulus * reading.travel
        load = self.observer.update(reading, given)
        states, rate = self._expected(reading, given, load)
        travel, states = states[:, 0], states - np.outer(load, self.plant.carried)
        # what damper and spring are to give together
        needed = self.wanted(states, reading, lead) - p.w2 * travel - load
        damping = -(needed + p.w2 * nominal * travel) / away_from_zero(rate, SLOW)
        damping = np.clip(damping, self.gains["least"], p.damping_high)
        modulus = -(needed + damping * rate) / (p.w2 * away_from_zero(travel, SHORT))
        modulus = np.clip(modulus, p.modulus_low, p.modulus_high)
        return damping_actions(damping, modulus, self.scene)

    def _expected(self, reading: Reading, given: np.ndarray, load: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """States and rate of the travel after `lead`, damper and spring giving the mass the acceleration `given`."""
        lead, now = self.gains["lead"], states_of(reading, self.plant)
        free, force, loaded, road = self.motion
        follows = self.scene.options["tyre"] is None
        if self.LOOKS_AHEAD:
            rises = rises_ahead(reading, self.scene, np.array([0.0, lead, lead + self.scene.params.dt]))
            rise, ground = rises[:, 0], rises[:, 1] / self.scene.params.dt
        else:
            # white noise has no future; a wheel that follows the ground feels what is slow in it
            ground = self.gains["persistence"] * (reading.velocity - reading.travel_rate) * follows
            rise = ground * lead
        beside = given - now @ self.plant.felt
        states = now @ free.T + np.outer(beside, force) + np.outer(load, loaded) + np.outer(rise, road)
        return states, states[:, 1] - (ground if follows else states[:, 3])


WEIGHTS: Ranges = {"travel": (0.1, 10.0, 1.0), "tyre": (1.0, 1e6, 1e4), "load": (0.1, 30.0, 3.0)}
CLIPPED: Ranges = {**WEIGHTS, "least": LEAST, "modulus": MODULUS, "lead": (0.002, 0.05, 0.015)}


class ClippedOptimal(OptimalRide):
    """Clipped-optimal: the best force on a road that nobody sees coming, clipped to what damper and spring can do.

    Gains: `travel`, factor on the cost of the travel; `tyre` [1/s^4], cost of the tyre's deflection; `load` [1/s],
    rate of the estimate; `least`, least damping [1/s]; `modulus` while the damper is enough; `lead` [s];
    `persistence`: part of the rate at which the ground rises that is expected to last, under a wheel that follows it.
    """

    TUNABLE: ClassVar[Ranges] = {**CLIPPED, "persistence": (0.0, 1.0, 0.5)}

    @staticmethod
    def serves(scene: Scene) -> bool:
        """Only a damper between mass and wheel is clipped."""
        return serves_damper(scene)


class LinearQuadratic(OptimalRide):
    """The best force on a road that nobody sees coming, the actuator's lag included. Gains as `ClippedOptimal`."""

    TUNABLE: ClassVar[Ranges] = WEIGHTS

    @staticmethod
    def serves(scene: Scene) -> bool:
        """Only where the action is a force."""
        return bool(scene.params.active)


class Preview(OptimalRide):
    """The best force on the road in view, clipped to what damper and spring can do. Gains as `ClippedOptimal`.

    Where the action is a force, the last three gains have no effect.
    """

    TUNABLE: ClassVar[Ranges] = CLIPPED
    LOOKS_AHEAD: ClassVar[bool] = True

    @staticmethod
    def serves(scene: Scene) -> bool:
        """Only where the road ahead is seen, by a force or a damper between mass and wheel."""
        return scene.options["preview"] is not None and (bool(scene.params.active) or serves_damper(scene))
