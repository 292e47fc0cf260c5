"""The ball on a bar in its default scene on whole arrays, for NumPy: all rows fly to their next impact at once.

A cycle is a loop over impacts: every row that is still under way is taken to its next impact or to the cycle's end
(`ball_flight.py`), and the law of impact is applied to those that have met the bar. There is as much to do as in the
row with the most impacts, with ever fewer rows.

Left out, against the native batch: a chatter is not summed; a ball that leaves an impact more slowly than `SLOW` while
the bar supports it rests from then on. A resting ball leaves where the supporting force, sampled over the cycle, has
become negative (sampled more closely there); where that lasts for less than a sample the ball stays. The gap is no
difference from the start of a flight, so it has no more digits than the ball's place.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from vr_envs.bench.speed.arrays.ball_flight import Bar, fly
from vr_envs.bench.speed.arrays.namespace import NUMPY, Arrays, State, next_key, normal_pair, uniform
from vr_envs.envs.scene import Scene

SLOW = 1e-3  # m/s
_START = 1 << 62  # counter of the draws
_SAMPLES = (33, 9, 9, 9, 9, 9)  # of the supporting force over a cycle, then between the last two
_ROUNDS = 1000  # impacts in a cycle, at most


def _rebound(normal: Any, tangent: Any, restitution: Any, kept: float) -> tuple[Any, Any]:
    return -restitution * normal, kept * tangent


class BallArrays:
    """`start(keys)` and `step(state, actions)` of the ball in the scene `bell`, in episodes of `limit` steps."""

    jax = False
    note = (
        "The ball in NumPy is a loop over impacts, which is left to NumPy, not written for JAX; it sums no chatter: a "
        f"ball that leaves an impact at less than {1e3 * SLOW:g} mm/s while the bar supports it rests."
    )

    def __init__(self, arrays: Arrays, scene: Scene, limit: int) -> None:
        """For a scene of a ball without spin, with scatter alone, and one action per base cycle.

        Raises:
            ValueError: another scene, or not NumPy.
        """
        p = scene.params
        if arrays is not NUMPY:
            raise ValueError(f"arrays = {arrays.name!r}; the ball's loop over impacts is written for NumPy alone")
        others = [k for k, v in scene.options.items() if v and k != "scatter"]
        if others or not scene.options["scatter"] or p.hold != 1.0 or p.tangential_loss == 0.0:
            raise ValueError(f"scene {scene.label!r}: give the ball's 'bell', or other values of its numbers")
        self.arrays, self.limit, self.params, self.scatter = arrays, limit, p, scene.options["scatter"]
        self.span = np.array([[p.x_span], [p.tilt_span], [p.z_span]])[:, None]
        self.centre = np.zeros((3, 2, 1))
        self.centre[2, 0] = p.z_centre

    def start(self, keys: Any) -> State:
        """Beside the centre, on the vertical period-one orbit of the bar's motion at action 0."""
        p, rows = self.params, keys.size
        needed = math.pi * p.gravity * (1.0 - p.restitution) / (1.0 + p.restitution)
        phase = math.acos(min(1.0, needed / p.z_acceleration)) if p.z_acceleration > 0.0 else 0.0
        since = (0.5 * math.pi - phase) / (2.0 * p.omega)
        launch = 0.25 * p.gravity * p.period
        size = p.start_min + (p.start_max - p.start_min) * uniform(np, keys, _START)
        return {
            "key": keys,
            "steps": np.zeros(rows, np.int32),
            "impacts": np.zeros(rows, np.int64),
            "resting": np.zeros(rows, np.bool_),
            "x": np.where(uniform(np, keys, _START + 1) < 0.5, size, -size),
            "z": np.full(rows, p.z_centre * math.sin(phase) + (launch - 0.5 * p.gravity * since) * since),
            "u": np.zeros(rows),
            "w": np.full(rows, launch - p.gravity * since),
            "place": np.zeros(rows),  # along the bar, of a resting ball
            "motion": np.repeat(self.centre, rows, axis=2),
        }

    def step(self, state: State, actions: Any) -> tuple[State, Any, Any, Any, Any]:
        """One base cycle; finished rows begin anew at once. `actions`: (n, 6)."""
        action = np.clip(actions.astype(np.float64).T, -1.0, 1.0).reshape(3, 2, -1)
        motion = self.centre + self.span * action
        bar = Bar(self.params, state["motion"], motion)
        state = {**state, "motion": motion, "steps": state["steps"] + 1}
        for name in ("impacts", "resting", "x", "z", "u", "w", "place"):
            state[name] = state[name].copy()
        lost = self._cycle(state, bar)
        reward = np.where(lost, 0.0, 1.0 / (1.0 + (state["x"] / self.params.reward_width) ** 2))
        truncated = state["steps"] >= self.limit
        state = self.arrays.where(lost | truncated, state, lambda part: self.start(next_key(np, part["key"])))
        return state, self.observe(state), reward, lost, truncated

    def _cycle(self, state: State, bar: Bar) -> Any:
        """All impacts of a cycle, in place; the rows that have lost the ball."""
        end = self.params.period
        rows = np.arange(state["x"].size)
        time, opening, released = np.zeros(rows.size), np.zeros(rows.size), np.zeros(rows.size, np.bool_)
        lost = np.zeros(rows.size, np.bool_)
        for _ in range(_ROUNDS):
            lying = rows[state["resting"][rows]]
            if lying.size:
                self._rest(state, bar, lying, time, released)
                rows = rows[~state["resting"][rows]]
            if not rows.size:
                return lost
            x, z, u, w = (state[name][rows] for name in ("x", "z", "u", "w"))
            own = bar.of(rows)
            hit, spent = fly(own, time[rows], x, z, u, w, opening[rows], released[rows])
            state["x"][rows] = x + u * spent
            state["z"][rows] = z + (w - 0.5 * self.params.gravity * spent) * spent
            state["w"][rows] = w - self.params.gravity * spent
            time[rows] += spent
            rows = rows[hit]
            self._meet(state, own.of(hit), rows, time, opening, released, lost)
            rows = rows[~lost[rows] & (time[rows] < end)]
        lost[rows] = True
        return lost

    def _meet(self, state: State, bar: Bar, rows: Any, time: Any, opening: Any, released: Any, lost: Any) -> None:
        """The law of impact in some rows, with the scatter of restitution and surface."""
        p = self.params
        (xb, tilt, zb), (xb_1, turn, zb_1), second = bar.at(time[rows])
        cos, sin = np.cos(tilt), np.sin(tilt)
        away = state["x"][rows] - xb
        place, below = away / cos, -away * sin / cos
        state["z"][rows] = zb + below
        lost[rows] = abs(place) > p.half_length
        ru, rw = state["u"][rows] - xb_1 - turn * below, state["w"][rows] - zb_1 + turn * away
        normal, tangent = ru * sin + rw * cos, ru * cos - rw * sin
        first, other = normal_pair(np, state["key"][rows], state["impacts"][rows] + 1)
        alpha = np.clip(p.restitution + self.scatter.restitution * first, 0.0, 1.0)
        kept, angle = 1.0 - p.tangential_loss, self.scatter.normal * other
        c, s = np.cos(angle), np.sin(angle)
        n, t = normal * c + tangent * s, tangent * c - normal * s
        rough_n, rough_t = _rebound(n, t, alpha, kept)
        smooth_n, smooth_t = _rebound(normal, tangent, alpha, kept)
        out = rough_n * c - rough_t * s
        rough = (n < 0.0) & (out > 0.0)
        after = np.where(rough, out, smooth_n), np.where(rough, rough_t * c + rough_n * s, smooth_t)
        strikes = (normal < 0.0) & ~lost[rows]
        d_normal = np.where(strikes, after[0] - normal, 0.0)
        d_tangent = np.where(strikes, after[1] - tangent, 0.0)
        state["u"][rows] += d_normal * sin + d_tangent * cos
        state["w"][rows] += d_normal * cos - d_tangent * sin
        state["impacts"][rows] += ~lost[rows]
        normal, tangent = normal + d_normal, tangent + d_tangent
        opening[rows] = normal / cos
        force = (second[0] * sin + (second[2] + p.gravity) * cos) - 2.0 * tangent * turn - place * second[1]
        slow = normal < SLOW
        state["resting"][rows] = slow & (force > 0.0) & ~lost[rows]
        released[rows] = slow
        state["place"][rows] = place

    def _rest(self, state: State, bar: Bar, rows: Any, time: Any, released: Any) -> None:
        """Keep balls on the bar until it falls away from under them, or to the cycle's end."""
        own, begin, end = bar.of(rows), time[rows], self.params.period
        place = state["place"][rows]

        def force(bar: Bar, place: Any, time: Any) -> Any:
            (_, tilt, _), _, (x_2, tilt_2, z_2) = bar.at(time)
            return x_2 * np.sin(tilt) + (z_2 + self.params.gravity) * np.cos(tilt) - place * tilt_2

        low, high, leaves = begin, np.full(rows.size, end), np.ones(rows.size, np.bool_)
        for samples in _SAMPLES:
            go = np.flatnonzero(leaves)
            times = low[go] + np.linspace(0.0, 1.0, samples)[:, None] * (high[go] - low[go])
            every = np.tile(go, samples)
            free = force(own.of(every), place[every], times.ravel()).reshape(times.shape) <= 0.0
            free[-1] |= samples != _SAMPLES[0]  # rounding: it was found there
            first, column = free.argmax(0), np.arange(go.size)
            leaves[go] = free.any(0)
            low[go] = times[np.maximum(first - 1, 0), column]
            high[go] = np.where(leaves[go], times[first, column], end)
        (xb, tilt, zb), (xb_1, turn, zb_1), _ = own.at(high)
        right, up = place * np.cos(tilt), -place * np.sin(tilt)
        state["x"][rows], state["z"][rows] = xb + right, zb + up
        state["u"][rows], state["w"][rows] = xb_1 + turn * up, zb_1 - turn * right
        time[rows], state["resting"][rows], released[rows] = high, ~leaves, True

    def observe(self, state: State) -> Any:
        """(n, 10), float32."""
        motion = ((state["motion"] - self.centre) / self.span).reshape(6, -1)
        ball = np.stack([state["x"] / self.params.half_length, state["u"] / 0.5, state["z"] / 0.02, state["w"]])
        return np.clip(np.concatenate([ball, motion]), -1.0, 1.0).astype(np.float32).T
