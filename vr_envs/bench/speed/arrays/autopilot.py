"""The autopilot's lecture scene on whole arrays: an aircraft that follows its commands at once, and changing demands.

Channels are altitude, airspeed and heading, the first axis of an array.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from vr_envs.bench.speed.arrays.namespace import Arrays, State, next_key, uniform
from vr_envs.envs.scene import Scene

_START, _LEG, _PER_LEG = 1 << 40, 1 << 41, 16  # counters of the draws
_BAND = np.array([[15.0], [1.0], [math.radians(0.5)]])
_SPAN = np.log1p(np.array([[15000.0], [300.0], [math.pi]]) / _BAND)
_RESTLESS, _COST = 0.5, 0.1
_SAME = 1e-9  # s


def _wrap(xp: Any, angle: Any) -> Any:
    return angle - 2.0 * math.pi * xp.floor((angle + math.pi) / (2.0 * math.pi))


class AutopilotArrays:
    """`start(keys)` and `step(state, actions)` of the autopilot in its lecture scene, in episodes of `limit` steps."""

    def __init__(self, arrays: Arrays, scene: Scene, limit: int) -> None:
        """For a scene with ground track and random demands alone, in which no aircraft comes to a standstill.

        Raises:
            ValueError: another scene.
        """
        p, known = scene.params, ("track", "demands", "metrics")
        others = [k for k, v in scene.options.items() if v and k not in known]
        if others or not (scene.options["track"] and scene.options["demands"]) or 0.5 * p.turn * p.dt > 0.5:
            raise ValueError(f"scene {scene.label!r}: give the autopilot's 'lecture', or other values of its numbers")
        if p.stall_speed <= p.deceleration * p.dt:
            raise ValueError(f"stall_speed = {p.stall_speed:g} m/s is not allowed; nothing may come to a standstill")
        self.arrays, self.limit, self.params, self.options = arrays, limit, p, scene.options
        self.falling = np.array([[p.descent], [p.deceleration], [p.turn]])
        self.rising = np.array([[p.climb], [p.acceleration], [p.turn]])
        self.low = np.array([[p.altitude_low], [p.speed_low], [-math.inf]])
        self.high = np.array([[p.altitude_high], [p.speed_high], [math.inf]])
        self.scale = np.maximum(self.falling, self.rising)

    def start(self, keys: Any) -> State:
        """Level flight anywhere in the operating range, at the demands; the first leg begins."""
        xp, p = self.arrays.xp, self.params
        draws = [uniform(xp, keys, _START + i) for i in range(3)]
        value = xp.stack(
            [
                p.altitude_low + (p.altitude_high - p.altitude_low) * draws[0],
                p.speed_low + (p.speed_high - p.speed_low) * draws[1],
                math.pi * (2.0 * draws[2] - 1.0),
            ]
        )
        zero = 0.0 * draws[0]
        state = {
            "key": keys,
            "steps": xp.zeros_like(zero, dtype=xp.int32),
            "x": zero + self.options["track"].x,
            "z": zero + self.options["track"].z,
            "value": value,
            "rate": 0.0 * value,
            "demand": value,
            "demand_rate": 0.0 * value,
            "target": value + 0.0,
            "legs": xp.zeros_like(zero, dtype=xp.int32),
            "next": zero + 0.0,
            "action": 0.0 * value,
            "earlier": 0.0 * value,
        }
        return self._change(state)

    def _change(self, state: State) -> State:
        """Begin the next leg."""
        xp, demands = self.arrays.xp, self.options["demands"]
        base = state["legs"].astype(xp.int64) * _PER_LEG + _LEG
        draws = xp.stack(
            [
                xp.stack([uniform(xp, state["key"], base + (1 + 4 * channel + k)) for channel in range(3)])
                for k in range(4)
            ]
        )
        hold = demands.hold_low + (demands.hold_high - demands.hold_low) * uniform(xp, state["key"], base)
        demand = state["target"]
        share = demands.share_low + (demands.share_high - demands.share_low) * draws[1]
        rise, fall = demand + share * self.rising * hold, demand - share * self.falling * hold
        falls = ((draws[2] < 0.5) & (fall >= self.low)) | (rise > self.high)
        target = xp.where(draws[0] < demands.change, xp.where(falls, xp.maximum(self.low, fall), rise), demand)
        target = xp.minimum(target, self.high)
        rate = xp.where(draws[3] < demands.ramp, (target - demand) / hold, 0.0)
        ends = state["next"] + hold
        target = xp.concatenate([target[:2], _wrap(xp, target[2:])])
        changed = {"target": target, "demand_rate": rate, "next": ends, "legs": state["legs"] + 1}
        state = {**state, "demand": target, **changed}
        return {**state, "demand": self._demand(state, state["steps"] * self.params.dt)}

    def _demand(self, state: State, time: Any) -> Any:
        """The demands of the present leg at a time."""
        xp = self.arrays.xp
        rate = state["demand_rate"]
        demand = xp.where(rate != 0.0, state["target"] - rate * (state["next"] - time), state["demand"])
        return xp.concatenate([demand[:2], _wrap(xp, demand[2:])])

    def _fly(self, state: State, rate: Any) -> tuple[Any, Any, Any]:
        """Place and values after an interval at constant rates; the turn's integrals are spherical Bessel functions."""
        xp, dt = self.arrays.xp, self.params.dt
        half = 0.5 * dt
        q = rate[2] * half
        s = q * q
        j0 = 1 - s / 6 * (1 - s / 20 * (1 - s / 42 * (1 - s / 72 * (1 - s / 110))))
        j1 = q / 3 * (1 - s / 10 * (1 - s / 28 * (1 - s / 54 * (1 - s / 88 * (1 - s / 130)))))
        chord = dt * (state["value"][1] + rate[1] * half) * j0
        skew = dt * rate[1] * half * j1
        sine, cosine = xp.sin(state["value"][2] + q), xp.cos(state["value"][2] + q)
        value = state["value"] + rate * dt
        value = xp.concatenate([value[:2], _wrap(xp, value[2:])])
        return state["x"] + chord * sine + skew * cosine, state["z"] + chord * cosine - skew * sine, value

    def step(self, state: State, actions: Any) -> tuple[State, Any, Any, Any, Any]:
        """One control interval; finished rows begin anew at once. `actions`: (n, 3)."""
        xp, p = self.arrays.xp, self.params
        action = xp.clip(actions.astype(xp.float64).T, -1.0, 1.0)
        rate = action * xp.where(action > 0.0, self.rising, self.falling)
        x, z, value = self._fly(state, rate)
        steps = state["steps"] + 1
        time = steps * p.dt
        demand = self._demand(state, time)
        size = abs(self._errors(demand, value))
        movement = abs(action - state["action"]).sum(0) / 3.0
        lost = (value[1] >= p.top_speed) | (value[1] < p.stall_speed) | (value[0] <= 0.0) | (value[0] >= p.ceiling)
        reward = (_BAND / (_BAND + size)).sum(0) / 3.0 * (1.0 - xp.minimum(_COST / _RESTLESS * movement, _COST))
        reward = xp.where(lost, 0.0, reward)
        state = {
            **state, "steps": steps, "x": x, "z": z, "value": value, "rate": rate, "demand": demand,
            "action": action, "earlier": state["action"],
        }  # fmt: skip
        state = self.arrays.where((time > state["next"] - _SAME) & ~lost, state, self._change)
        truncated = steps >= self.limit
        state = self.arrays.where(lost | truncated, state, lambda part: self.start(next_key(xp, part["key"])))
        return state, self.observe(state), reward, lost, truncated

    def _errors(self, demand: Any, value: Any) -> Any:
        xp = self.arrays.xp
        away = demand - value
        return xp.concatenate([away[:2], _wrap(xp, away[2:])])

    def observe(self, state: State) -> Any:
        """(n, 23), float32."""
        xp, p = self.arrays.xp, self.params
        away = self._errors(state["demand"], state["value"])
        size = abs(away)
        near = away / (_BAND + size)
        speed = 2.0 * (state["value"][1] - p.stall_speed) / (p.top_speed - p.stall_speed) - 1.0
        rows = (
            xp.sign(away) * xp.log(1.0 + size / _BAND) / _SPAN,
            near,
            near,  # the lead error: nothing lags
            state["rate"] / self.scale,
            state["demand_rate"] / self.scale,
            xp.stack([speed, 2.0 * state["value"][0] / p.ceiling - 1.0]),
            state["action"],
            state["earlier"],
        )
        return xp.clip(xp.concatenate(rows), -1.0, 1.0).astype(xp.float32).T
