"""The autopilot's airliner scene on whole arrays.

On top of the lecture's aircraft: limits that depend on altitude and speed, a power that climbing and accelerating
share, rates that lag, equivalent airspeeds in the standard atmosphere (ISO 2533), and Dryden turbulence
(MIL-F-8785C) along and vertical to the path, discretised exactly.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from vr_envs.bench.speed.arrays.autopilot import START, AutopilotArrays, wrap
from vr_envs.bench.speed.arrays.namespace import Arrays, State, normal_pair
from vr_envs.envs.scene import Scene
from vr_envs.models.atmosphere import GAS_CONSTANT, HEAT_RATIO, LAPSE, SEA_LEVEL_TEMPERATURE, TROPOPAUSE
from vr_envs.models.constants import G
from vr_envs.models.turbulence import FOOT, HIGH, LOW, LOWEST, SCALE_LENGTH

_SHARE_POWER = 0.5 * (G / (LAPSE * GAS_CONSTANT) - 1.0)  # of the temperature, in sqrt(rho / rho0)
_SHARE_DECAY = 0.5 * G / (GAS_CONSTANT * (SEA_LEVEL_TEMPERATURE - LAPSE * TROPOPAUSE))  # 1/m, above the tropopause
_SQRT3 = math.sqrt(3.0)
_SHORTEST = 0.1  # of an interval, in units of the gusts' time: below, the covariance loses digits


def _temperature(xp: Any, altitude: Any) -> Any:
    return SEA_LEVEL_TEMPERATURE - LAPSE * xp.minimum(altitude, TROPOPAUSE)


def _share(xp: Any, altitude: Any) -> Any:
    """Equivalent over true airspeed."""
    ratio = xp.log(_temperature(xp, altitude) * (1.0 / SEA_LEVEL_TEMPERATURE))
    return xp.exp(_SHARE_POWER * ratio - _SHARE_DECAY * xp.maximum(0.0, altitude - TROPOPAUSE))


def _sound(xp: Any, altitude: Any) -> Any:
    return xp.sqrt(HEAT_RATIO * GAS_CONSTANT * _temperature(xp, altitude))


class AirlinerArrays(AutopilotArrays):
    """`start(keys)` and `step(state, actions)` of the autopilot in its airliner scene, in episodes of `limit` steps."""

    scene = "airliner"
    present = {"envelope", "energy", "lags", "atmosphere", "turbulence", "demands"}

    def __init__(self, arrays: Arrays, scene: Scene, limit: int) -> None:
        """As the lecture's; gusts must not be much slower than a control interval.

        Raises:
            ValueError: another scene.
        """
        super().__init__(arrays, scene, limit)
        p, lags = self.params, self.options["lags"]
        if p.stall_speed * p.dt < _SHORTEST * SCALE_LENGTH:
            raise ValueError(f"stall_speed = {p.stall_speed:g} m/s, dt = {p.dt:g} s: the product must be at least 54 m")
        self.lag = np.array([[lags.vertical], [lags.along], [lags.turn]])

    def _highs(self, altitude: Any) -> Any:
        xp, p = self.arrays.xp, self.params
        fastest = self.options["atmosphere"].mach_high * _sound(xp, altitude) * _share(xp, altitude)
        zero = 0.0 * altitude
        return xp.stack([zero + p.altitude_high, xp.minimum(p.speed_high, fastest), zero + math.inf])

    def _limits(self, altitude: Any, speed: Any) -> tuple[Any, Any]:
        """Largest climb and turn rates."""
        xp, p, envelope = self.arrays.xp, self.params, self.options["envelope"]
        lapse = (p.climb - envelope.cruise_climb) / envelope.cruise_altitude
        return xp.maximum(0.0, p.climb - lapse * altitude), xp.minimum(p.turn, envelope.lateral / speed)

    def _reach(self, demand: Any) -> tuple[Any, Any]:
        xp, p = self.arrays.xp, self.params
        share = _share(xp, demand[0])
        climb, turn = self._limits(demand[0], demand[1] / share)
        falling = xp.stack([0.0 * climb + p.descent, p.deceleration * share, turn])
        return falling, xp.stack([climb, p.acceleration * share, turn])

    def _place(self, state: State) -> State:
        """True airspeed of the demanded one; the gusts from their stationary distribution."""
        xp, value = self.arrays.xp, state["value"]
        share = _share(xp, value[0])
        first, _ = normal_pair(xp, state["key"], START // 2 + 2)
        second, third = normal_pair(xp, state["key"], START // 2 + 3)
        return {
            "value": xp.stack([value[0], value[1] / share, value[2]]),
            "share": share,
            "headwind": first,
            "gust": self._scales(value[0])["sigma"] * first,
            "updraught": math.sqrt(0.5) * second,
            "updraught_lag": math.sqrt(0.125) * (second + third),
        }

    def _scales(self, altitude: Any) -> State:
        """Scale lengths and standard deviations of the gusts along and vertical to the path."""
        xp, gusts = self.arrays.xp, self.options["turbulence"]
        low = 0.1 * gusts.wind_20ft
        part = (xp.minimum(altitude, HIGH) - LOW) / (HIGH - LOW)
        along, sigma = LOW + part * (SCALE_LENGTH - LOW), low + part * (gusts.sigma - low)
        both = {
            "altitude": altitude, "along": along, "vertical": along + 0.0, "sigma": sigma, "sigma_vertical": sigma + 0.0
        }  # fmt: skip

        def near_ground(part: State) -> State:
            height = xp.maximum(part["altitude"], LOWEST)
            root = (0.177 + 0.000823 / FOOT * height) ** 0.4
            return {
                "altitude": part["altitude"],
                "along": height / root**3,
                "vertical": height,
                "sigma": low / root,
                "sigma_vertical": 0.0 * height + low,
            }

        return self.arrays.where(altitude < LOW, both, near_ground)

    def _fly(self, state: State, action: Any) -> State:
        """What changes in an interval: lagging rates, each with a limit of its change, then the gusts."""
        xp, p, lags, dt = self.arrays.xp, self.params, self.options["lags"], self.params.dt
        altitude, speed = state["value"][0], state["value"][1]
        climb, turn = self._limits(altitude, speed)
        rise = action[0] * xp.where(action[0] > 0.0, climb, p.descent)
        gain = action[1] * xp.where(action[1] > 0.0, p.acceleration, p.deceleration)
        weight = G / speed
        gain = xp.minimum(gain, weight * (climb - rise))
        gain = xp.maximum(gain, xp.minimum(p.acceleration, weight * (-self.options["energy"].idle_sink - rise)))
        command = xp.stack([rise, gain, action[2] * turn])
        zero = 0.0 * turn
        slew = xp.stack([zero + lags.vertical_slew, zero + lags.jerk, turn / lags.roll_in])
        gap = command - state["rate"]
        ramp = xp.minimum(dt, xp.maximum(0.0, abs(gap) / slew - self.lag))
        change = xp.copysign(slew * ramp, gap)
        gap = gap - change
        closed = gap - gap * xp.exp((ramp - dt) / self.lag)
        value = state["value"] + command * dt - ramp * (gap + 0.5 * change) - self.lag * closed
        gusts, lift, push = self._blow(state)
        altitude = value[0] + lift
        return {
            **gusts,
            "value": xp.stack([altitude, xp.maximum(0.0, value[1] + push), wrap(xp, value[2])]),
            "rate": state["rate"] + change + closed,
            "share": _share(xp, altitude),
        }

    def _blow(self, state: State) -> tuple[State, Any, Any]:
        """The gusts after an interval, and what they add to altitude and airspeed.

        The vertical one is p1' = noise - p1, p2' = p1 - p2 in units of its time; noise in p1, p2 and the integral of p2
        is jointly normal, with kernels exp(-r), r exp(-r) and 1 - (1 + r) exp(-r).
        """
        xp, dt = self.arrays.xp, self.params.dt
        scales = self._scales(state["value"][0])
        path = dt * state["value"][1]
        n1, n2 = normal_pair(xp, state["key"], 4 * state["steps"])
        n3, n4 = normal_pair(xp, state["key"], 4 * state["steps"] + 1)
        kept = xp.exp(-path / scales["along"])
        headwind = kept * state["headwind"] + xp.sqrt(1.0 - kept * kept) * n1
        gust = scales["sigma"] * headwind
        q = path / scales["vertical"]
        e = xp.exp(-q)
        e2, k3 = e * e, 1.0 - (1.0 + q) * e
        g11, g12 = 0.5 * (1.0 - e2), 0.25 * (1.0 - (1.0 + 2.0 * q) * e2)
        g22, g23 = 0.25 * (1.0 - (1.0 + 2.0 * q * (1.0 + q)) * e2), 0.5 * k3 * k3
        g13, g33 = 1.0 - e - g11 - g12, q - 4.0 + 2.0 * (2.0 + q) * e + g11 + 2.0 * g12 + g22
        l11 = xp.sqrt(g11)
        l21, l31 = g12 / l11, g13 / l11
        l22 = xp.sqrt(g22 - l21 * l21)
        l32 = (g23 - l31 * l21) / l22
        l33 = xp.sqrt(g33 - l31 * l31 - l32 * l32)
        first, second = state["updraught"], state["updraught_lag"]
        into_2, into_3 = l21 * n2 + l22 * n3, l31 * n2 + l32 * n3 + l33 * n4
        mean = first * (k3 / q + _SQRT3 * e) + (second * (1.0 - _SQRT3) * (1.0 - e) + _SQRT3 * into_2 + into_3) / q
        after = {
            "headwind": headwind,
            "gust": gust,
            "updraught": e * first + l11 * n2,
            "updraught_lag": e * (second + q * first) + into_2,
        }
        return after, scales["sigma_vertical"] * dt * mean, gust - state["gust"]

    def _lost(self, seen: Any, state: State) -> Any:
        xp, value = self.arrays.xp, state["value"]
        fast = value[1] >= self.options["atmosphere"].top_mach * _sound(xp, value[0])
        return super()._lost(seen, state) | fast

    def _seen(self, state: State) -> Any:
        value = state["value"]
        return self.arrays.xp.stack([value[0], value[1] * state["share"], value[2]])

    def _lead(self, away: Any, state: State) -> Any:
        """The errors ahead of the lags; thinner air takes from the equivalent airspeed of a climbing aircraft."""
        xp, (altitude, speed, _), rate = self.arrays.xp, state["value"], state["rate"]
        decay = xp.where(
            altitude > TROPOPAUSE, _SHARE_DECAY, _SHARE_POWER * LAPSE / _temperature(xp, altitude)
        )  # of the share, per height
        along = (rate[1] - decay * rate[0] * speed) * state["share"]
        return away - self.lag * (xp.stack([rate[0], along, rate[2]]) - state["demand_rate"])
