"""The autopilot's lecture scene on whole arrays: an aircraft that follows its commands at once, and changing demands.

What another scene does otherwise (`autopilot_airliner.py`) has methods of its own.

Channels are altitude, airspeed and heading, the first axis of an array.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from vr_envs.bench.speed.arrays.namespace import Arrays, State, next_key, uniform
from vr_envs.envs.scene import Scene

START = 1 << 40  # first counter of the draws at the start
_LEG, _PER_LEG = 1 << 41, 16  # and of those of the legs
BAND = np.array([[15.0], [1.0], [math.radians(0.5)]])
_SPAN = np.log1p(np.array([[15000.0], [300.0], [math.pi]]) / BAND)
_RESTLESS, _COST = 0.5, 0.1
_SAME = 1e-9  # s


def wrap(xp: Any, angle: Any) -> Any:
    """The same direction in [-pi, pi)."""
    return angle - 2.0 * math.pi * xp.floor((angle + math.pi) / (2.0 * math.pi))


class AutopilotArrays:
    """`start(keys)` and `step(state, actions)` of the autopilot in its lecture scene, in episodes of `limit` steps."""

    jax, note = True, None
    scene, present = "lecture", {"track", "demands"}  # and what is present in it

    def __init__(self, arrays: Arrays, scene: Scene, limit: int) -> None:
        """For a scene with the same options, in which no aircraft comes to a standstill.

        Raises:
            ValueError: another scene.
        """
        p, present = scene.params, {k for k, v in scene.options.items() if v and k != "metrics"}
        if present != self.present or 0.5 * p.turn * p.dt > 0.5 or p.refresh != p.dt:
            raise ValueError(
                f"scene {scene.label!r}: give the autopilot's {self.scene!r}, or other values of its numbers"
            )
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
        draws = [uniform(xp, keys, START + i) for i in range(3)]
        altitude = p.altitude_low + (p.altitude_high - p.altitude_low) * draws[0]
        speed = p.speed_low + (self._highs(altitude)[1] - p.speed_low) * draws[1]
        value = xp.stack([altitude, speed, math.pi * (2.0 * draws[2] - 1.0)])
        zero = 0.0 * draws[0]
        state = {
            "key": keys,
            "steps": xp.zeros_like(zero, dtype=xp.int32),
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
        return self._change({**state, **self._place(state)})

    def _place(self, state: State) -> State:
        """What else there is of an aircraft whose values are at the demands."""
        zero = 0.0 * state["next"]
        return {"x": zero + self.options["track"].x, "z": zero + self.options["track"].z}

    def _highs(self, altitude: Any) -> Any:
        """Upper ends of the operating ranges at an altitude."""
        return self.high

    def _reach(self, demand: Any) -> tuple[Any, Any]:
        """How fast the values can fall and rise at the demanded ones."""
        return self.falling, self.rising

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
        falling, rising = self._reach(demand)
        rise, fall, high = demand + share * rising * hold, demand - share * falling * hold, self._highs(demand[0])

        def within(high: Any) -> Any:
            falls = ((draws[2] < 0.5) & (fall >= self.low)) | (rise > high)
            target = xp.where(draws[0] < demands.change, xp.where(falls, xp.maximum(self.low, fall), rise), demand)
            return xp.minimum(target, high)

        target = within(high)
        if high is not self.high:  # the range depends on the altitude: it counts at both ends of the leg
            target = within(xp.minimum(high, self._highs(target[0])))
        rate = xp.where(draws[3] < demands.ramp, (target - demand) / hold, 0.0)
        ends = state["next"] + hold
        target = xp.concatenate([target[:2], wrap(xp, target[2:])])
        changed = {"target": target, "demand_rate": rate, "next": ends, "legs": state["legs"] + 1}
        state = {**state, "demand": target, **changed}
        return {**state, "demand": self._demand(state, state["steps"] * self.params.dt)}

    def _demand(self, state: State, time: Any) -> Any:
        """The demands of the present leg at a time."""
        xp = self.arrays.xp
        rate = state["demand_rate"]
        demand = xp.where(rate != 0.0, state["target"] - rate * (state["next"] - time), state["demand"])
        return xp.concatenate([demand[:2], wrap(xp, demand[2:])])

    def _fly(self, state: State, action: Any) -> State:
        """What changes in an interval at constant rates; the turn's integrals are spherical Bessel functions."""
        xp, dt = self.arrays.xp, self.params.dt
        rate = action * xp.where(action > 0.0, self.rising, self.falling)
        half = 0.5 * dt
        q = rate[2] * half
        s = q * q
        j0 = 1 - s / 6 * (1 - s / 20 * (1 - s / 42 * (1 - s / 72 * (1 - s / 110))))
        j1 = q / 3 * (1 - s / 10 * (1 - s / 28 * (1 - s / 54 * (1 - s / 88 * (1 - s / 130)))))
        chord = dt * (state["value"][1] + rate[1] * half) * j0
        skew = dt * rate[1] * half * j1
        sine, cosine = xp.sin(state["value"][2] + q), xp.cos(state["value"][2] + q)
        value = state["value"] + rate * dt
        return {
            "x": state["x"] + chord * sine + skew * cosine,
            "z": state["z"] + chord * cosine - skew * sine,
            "value": xp.concatenate([value[:2], wrap(xp, value[2:])]),
            "rate": rate,
        }

    def _lost(self, seen: Any, state: State) -> Any:
        """Whether an aircraft has left the envelope."""
        p = self.params
        return (seen[1] >= p.top_speed) | (seen[1] < p.stall_speed) | (seen[0] <= 0.0) | (seen[0] >= p.ceiling)

    def _seen(self, state: State) -> Any:
        """The values that are demanded."""
        return state["value"]

    def _lead(self, away: Any, state: State) -> Any:
        """The errors ahead of the lags, of which there are none."""
        return away

    def step(self, state: State, actions: Any) -> tuple[State, Any, Any, Any, Any]:
        """One control interval; finished rows begin anew at once. `actions`: (n, 3)."""
        xp, p = self.arrays.xp, self.params
        action = xp.clip(actions.astype(xp.float64).T, -1.0, 1.0)
        after = self._fly(state, action)
        steps = state["steps"] + 1
        time = steps * p.dt
        demand = self._demand(state, time)
        seen = self._seen(after)
        size = abs(self._errors(demand, seen))
        movement = abs(action - state["action"]).sum(0) / 3.0
        lost = self._lost(seen, after)
        reward = (BAND / (BAND + size)).sum(0) / 3.0 * (1.0 - xp.minimum(_COST / _RESTLESS * movement, _COST))
        reward = xp.where(lost, 0.0, reward)
        state = {
            **state, **after, "steps": steps, "demand": demand, "action": action, "earlier": state["action"],
        }  # fmt: skip
        state = self.arrays.where((time > state["next"] - _SAME) & ~lost, state, self._change)
        truncated = steps >= self.limit
        state = self.arrays.where(lost | truncated, state, lambda part: self.start(next_key(xp, part["key"])))
        return state, self.observe(state), reward, lost, truncated

    def _errors(self, demand: Any, seen: Any) -> Any:
        xp = self.arrays.xp
        away = demand - seen
        return xp.concatenate([away[:2], wrap(xp, away[2:])])

    def observe(self, state: State) -> Any:
        """(n, 23), float32."""
        xp, p = self.arrays.xp, self.params
        seen = self._seen(state)
        away = self._errors(state["demand"], seen)
        size = abs(away)
        near = away / (BAND + size)
        lead = self._lead(away, state)
        speed = 2.0 * (seen[1] - p.stall_speed) / (p.top_speed - p.stall_speed) - 1.0
        rows = (
            xp.sign(away) * xp.log(1.0 + size / BAND) / _SPAN,
            near,
            near if lead is away else lead / (BAND + abs(lead)),
            state["rate"] / self.scale,
            state["demand_rate"] / self.scale,
            xp.stack([speed, 2.0 * seen[0] / p.ceiling - 1.0]),
            state["action"],
            state["earlier"],
        )
        return xp.clip(xp.concatenate(rows), -1.0, 1.0).astype(xp.float32).T
