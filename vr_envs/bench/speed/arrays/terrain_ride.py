"""The ride's lecture scene on whole arrays: a mass on a damped spring over three sines, in closed form.

With the damper acting on the mass's own velocity, zeta'' + gamma zeta' + w2 zeta = w2 r(t) over the height r of the
sines under the wheel: a steady answer to the sines, and a free motion about it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from vr_envs.bench.speed.arrays.namespace import Arrays, State, next_key, uniform
from vr_envs.envs.scene import Scene

_GOLDEN = 0.5 * (1.0 + math.sqrt(5.0))
_WAVES = np.arange(3)[:, None]
_PHASES = 1 << 41  # first counter of their draws
# Wk of ISO 2631-1 at 100 Hz in three sections: denominators and numerators in 1/z
_HIGH = (-1.964392, 0.965014)
_STEP = (-1.749913, 0.789468, -1.828973, 0.849081)
_TURN = (-0.906529, 0.268114, -0.396527, 0.580787)


class RideArrays:
    """`start(keys)` and `step(state, actions)` of the ride in its lecture scene, in episodes of `limit` steps."""

    jax, note = True, None

    def __init__(self, arrays: Arrays, scene: Scene, limit: int) -> None:
        """For a scene of sines alone, without the extremes of damping where the spring no longer swings.

        Raises:
            ValueError: another scene.
        """
        p, others = scene.params, [k for k, v in scene.options.items() if v and k not in ("undulation", "metrics")]
        if others or not scene.options["undulation"] or p.relative or p.active or p.dt != 0.01:
            raise ValueError(f"scene {scene.label!r}: give the ride's 'lecture', or other values of its numbers")
        if p.damping_high**2 >= 4.0 * p.modulus_low * p.w2:
            raise ValueError(f"damping_high = {p.damping_high:g} 1/s is not allowed; the spring must swing")
        self.arrays, self.limit, self.params = arrays, limit, p
        ratio = _GOLDEN**_WAVES
        number = 2.0 * math.pi * ratio / scene.options["undulation"].wavelength
        self.amplitude = scene.options["undulation"].amplitude / ratio
        self.frequency = number * p.speed
        self.cos, self.sin = np.cos(self.frequency * p.dt), np.sin(self.frequency * p.dt)

    def start(self, keys: Any) -> State:
        """At rest on the sines, whose phases the keys draw."""
        xp = self.arrays.xp
        phase = 2.0 * math.pi * xp.stack([uniform(xp, keys, _PHASES + i) for i in range(3)])
        zero = 0.0 * phase[0]
        names = ("travel", "velocity", "rate", "acceleration", "weighted")
        return {
            "key": keys,
            "steps": xp.zeros_like(zero, dtype=xp.int32),
            "cos": xp.cos(phase),
            "sin": xp.sin(phase),
            "filter": xp.stack([zero] * 6),
            "position": xp.stack([zero] * 2),
            **{name: zero + 0.0 for name in names},
        }

    def _steady(self, cos: Any, sin: Any, gamma: Any, w2: Any) -> tuple[Any, Any]:
        """Travel and velocity of the steady ride over the sines."""
        drag, spring = gamma * self.frequency, w2 - self.frequency**2
        size = spring * spring + drag * drag
        real, imaginary = w2 * spring / size, -drag * w2 / size
        height = self.amplitude * ((real - 1.0) * sin + imaginary * cos)
        speed = self.amplitude * self.frequency * (real * cos - imaginary * sin)
        return height.sum(0), speed.sum(0)

    def _weigh(self, memory: Any, acceleration: Any) -> tuple[Any, Any]:
        a, m = acceleration, memory
        high = a + m[0]
        step = high + m[2]
        turn = step + m[4]
        after = (
            m[1] - 2.0 * a - _HIGH[0] * high,
            a - _HIGH[1] * high,
            m[3] + _STEP[2] * high - _STEP[0] * step,
            _STEP[3] * high - _STEP[1] * step,
            m[5] + _TURN[2] * step - _TURN[0] * turn,
            -_TURN[1] * turn,
        )
        return self.arrays.xp.stack(after), _TURN[3] * turn

    def step(self, state: State, actions: Any) -> tuple[State, Any, Any, Any, Any]:
        """One control interval; finished rows begin anew at once. `actions`: (n, 2)."""
        xp, p = self.arrays.xp, self.params
        action = xp.clip(actions.astype(xp.float64).T, -1.0, 1.0)
        gamma = xp.exp(p.damping_centre + p.damping_half * action[0])
        w2 = p.w2 * xp.exp(p.modulus_centre + p.modulus_half * action[1])
        cos = state["cos"] * self.cos - state["sin"] * self.sin
        sin = state["sin"] * self.cos + state["cos"] * self.sin
        (travel, velocity), (travel_end, velocity_end) = (
            self._steady(c, s, gamma, w2) for c, s in ((state["cos"], state["sin"]), (cos, sin))
        )
        x, v = state["travel"] - travel, state["velocity"] - velocity
        swing = xp.sqrt(w2 - 0.25 * gamma * gamma)
        decay = xp.exp(-0.5 * gamma * p.dt)
        c, s = decay * xp.cos(swing * p.dt), decay * xp.sin(swing * p.dt) / swing
        travel = c * x + s * (v + 0.5 * gamma * x) + travel_end
        velocity = c * v - s * (w2 * x + 0.5 * gamma * v) + velocity_end
        acceleration = (velocity - state["velocity"]) / p.dt
        memory, weighted = self._weigh(state["filter"], acceleration)
        state = {
            "key": state["key"],
            "steps": state["steps"] + 1,
            "cos": cos,
            "sin": sin,
            "filter": memory,
            "position": action,
            "travel": travel,
            "velocity": velocity,
            "rate": (travel - state["travel"]) / p.dt,
            "acceleration": acceleration,
            "weighted": weighted,
        }
        reward = 1.0 / (1.0 + (weighted / p.comfort) ** 2 + (travel / p.rattle) ** 2)
        truncated = state["steps"] >= self.limit
        state = self.arrays.where(truncated, state, lambda part: self.start(next_key(xp, part["key"])))
        return state, self.observe(state), reward, xp.zeros_like(truncated), truncated

    def observe(self, state: State) -> Any:
        """(n, 7), float32."""
        xp = self.arrays.xp
        sensors = xp.stack(
            [
                state["travel"] / 0.05, state["rate"] / 0.5, state["velocity"] / 0.5, state["acceleration"] / 2.0,
                state["weighted"] / 2.0, *state["position"],
            ],
            axis=1,
        )  # fmt: skip
        return xp.clip(sensors, -5.0, 5.0).astype(xp.float32)
