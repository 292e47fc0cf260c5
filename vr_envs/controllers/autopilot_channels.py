"""What the laws of the autopilot have in common: the three channels as lags with limits, now and in their own units.

A channel's error obeys  error' = demand rate - rate,  rate' = clamp((command - rate) / T, -slew, slew)  with the lag T
of the scene (rate = command where it has none). All airspeeds are true ones here: an equivalent airspeed v s, with s
the root of the density ratio, changes by s v' - D v_y in a climb, so its error is divided by s, and its demand's rate
is what the true acceleration has to be, (rate + D v_y) / s.

Late instruments: the law knows which commands it has given since, and carries the channels on to the present.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vr_envs.envs.autopilot_observation import BAND, Reading, actions_for, limits, read
from vr_envs.envs.scene import Scene
from vr_envs.models.atmosphere import airspeed_rate
from vr_envs.models.autopilot_limits import SLOWEST, within_power
from vr_envs.models.constants import G
from vr_envs.models.jit import kernel
from vr_envs.models.lag import clamped_lag

Gains = dict[str, tuple[float, float, float]]
"""Of a law: name -> (low, high, default)."""
NAMES = ("altitude", "speed", "heading")
BANDS = np.array(BAND)


def gains_of(tunable: Gains, given: dict[str, float]) -> dict[str, float]:
    """The gains given, and defaults for the others."""
    return {name: given.get(name, default) for name, (_, _, default) in tunable.items()}


def triple(gain: dict[str, float], name: str) -> np.ndarray:
    """The gain `name` of altitude, airspeed and heading."""
    return np.array([gain[f"{channel}_{name}"] for channel in NAMES])


class Flight(NamedTuple):
    """The channels at the present instant; all (n, 3) in m, m/s, rad and their rates, but `true_speed` (n,)."""

    error: np.ndarray
    rate: np.ndarray
    demand_rate: np.ndarray
    command: np.ndarray
    """The last one given."""
    falling: np.ndarray
    rising: np.ndarray
    """Limits of the commands, both positive."""
    slew: np.ndarray
    true_speed: np.ndarray

    def clipped(self, command: np.ndarray) -> np.ndarray:
        """A command within the limits."""
        return np.clip(command, -self.falling, self.rising)


@kernel
def _airspeed_terms(altitudes, speeds, atmosphere, share, thinning):  # type: ignore[no-untyped-def]
    """Measured over true airspeed; true acceleration that holds the measured airspeed, per m/s of climb rate."""
    for i in range(altitudes.shape[0]):
        share[i] = airspeed_rate(altitudes[i], speeds[i], 0.0, 1.0, atmosphere)
        thinning[i] = -airspeed_rate(altitudes[i], speeds[i], 1.0, 0.0, atmosphere) / share[i]


@kernel
def _carry_on(error, rate, commands, lag, slew, thinning, dt):  # type: ignore[no-untyped-def]
    """Move the channels of every row through the intervals in which the commands (k, n, 3) were given."""
    for i in range(error.shape[0]):
        for k in range(commands.shape[0]):
            for channel in range(3):
                command, gain = commands[k, i, channel], commands[k, i, channel] * dt
                if lag[channel] > 0.0:
                    rate[i, channel], gain = clamped_lag(rate[i, channel], command, lag[channel], slew[i, channel], dt)
                else:
                    rate[i, channel] = command
                error[i, channel] -= gain
                if channel == 0:
                    error[i, 1] += thinning[i] * gain


@kernel
def _give_way(commands, climbs, speeds, params, energy):  # type: ignore[no-untyped-def]
    """Make of the accelerations commanded (n, 3) what the shared power leaves of them."""
    for i in range(commands.shape[0]):
        weight_per_speed = G / max(speeds[i], SLOWEST)
        commands[i, 1] = within_power(commands[i, 0], commands[i, 1], weight_per_speed, climbs[i], params, energy)


class Channels:
    """Turns observations into `Flight`, and commands into actions."""

    def __init__(self, scene: Scene) -> None:
        """`lag` (3) [s] is 0 where the scene has no lags."""
        lags, sensing = scene.options["lags"], scene.options["sensing"]
        self._params, options = scene.records()
        self.scene, self.dt = scene, scene.params.dt
        self.lag = np.zeros(3) if lags is None else np.array([lags.vertical, lags.along, lags.turn])
        self.delay = 0 if sensing is None else sensing.delay
        self._atmosphere, self._energy = (options[list(scene.options).index(k)] for k in ("atmosphere", "energy"))
        self.reset(0)

    def reset(self, n: int) -> None:
        """Nothing has been commanded."""
        self._commands = np.zeros((0, n, 3))

    def slews(self, rising: np.ndarray) -> np.ndarray:
        """Largest rates of change (n, 3) of the rates."""
        lags = self.scene.options["lags"]
        if lags is None:
            return np.full_like(rising, np.inf)
        slew = np.empty_like(rising)
        slew[:, 0], slew[:, 1], slew[:, 2] = lags.vertical_slew, lags.jerk, rising[:, 2] / lags.roll_in
        return slew

    def flight(self, observations: np.ndarray) -> Flight:
        """The channels now, for observations (n, 23)."""
        reading: Reading = read(observations, self.scene)
        falling, rising = limits(reading, self.scene)
        slew = self.slews(rising)
        share, thinning = np.empty_like(reading.speed), np.empty_like(reading.speed)
        _airspeed_terms(reading.altitude, reading.speed, self._atmosphere, share, thinning)
        error, rate, demand_rate = reading.error.copy(), reading.rate.copy(), reading.demand_rate.copy()
        error[:, 1] /= share
        if len(self._commands):
            _carry_on(error, rate, self._commands, self.lag, slew, thinning, self.dt)
        demand_rate[:, 1] = demand_rate[:, 1] / share + thinning * rate[:, 0]
        command = reading.action * np.where(reading.action > 0.0, rising, falling)
        return Flight(error, rate, demand_rate, command, falling, rising, slew, reading.true_speed)

    def actions(self, commands: np.ndarray, flight: Flight) -> np.ndarray:
        """Actions (n, 3) that command rates (n, 3); they are remembered as far as the instruments are late."""
        if self.delay:
            given = flight.clipped(commands)
            if self._energy is not None:
                climb = np.ascontiguousarray(flight.rising[:, 0])
                _give_way(given, climb, flight.true_speed, self._params, self._energy)
            self._commands = np.concatenate([self._commands, given[None]])[-self.delay :]
        return actions_for(commands, flight.falling, flight.rising)


def power_limits(flight: Flight, scene: Scene) -> tuple[float, np.ndarray]:
    """Lowest and highest (n,) sum of climb rate and v a / g [m/s] that the shared power leaves."""
    energy = scene.options["energy"]
    return (-np.inf, np.full(len(flight.rate), np.inf)) if energy is None else (-energy.idle_sink, flight.rising[:, 0])


def climb_per_acceleration(flight: Flight) -> np.ndarray:
    """Climb rate (n,) [m/s] that takes as much power as an acceleration of 1 m/s^2: v / g."""
    return np.maximum(flight.true_speed, SLOWEST) / G


def lead(error: np.ndarray, flight: Flight, time: np.ndarray) -> np.ndarray:
    """The error (n, 3) that is left when the rates have come to those of the demands, with a lag of `time` (3) [s]."""
    return error - time * (flight.rate - flight.demand_rate)


def capture(error: np.ndarray, gain: np.ndarray, deceleration: np.ndarray) -> np.ndarray:
    """Rate at which to close an error (n, 3) so that it can be stopped at zero with the given deceleration.

    Proportional with `gain` (3) [1/s] up to where the square root |rate| = sqrt(2 A (|e| - A / (2 k^2))) of constant
    deceleration A has the same value and slope, at |e| = A / k^2.
    """
    size = np.abs(error)
    with np.errstate(invalid="ignore"):
        root = np.sqrt(np.maximum(2.0 * deceleration * size - (deceleration / gain) ** 2, 0.0))
    return np.copysign(np.where(size * gain * gain <= deceleration, gain * size, root), error)
