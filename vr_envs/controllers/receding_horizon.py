"""Linear-quadratic feedback planned anew in every cycle, along the motion that the exact model predicts."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import numpy as np

from vr_envs.controllers.bar_design import Design
from vr_envs.controllers.bell_sink import BellSink
from vr_envs.controllers.linear_quadratic import riccati
from vr_envs.envs.scene import Scene
from vr_envs.models.ball_on_bar import interval
from vr_envs.models.jit import kernel

CYCLES = 8  # planned ahead
THROWS = 3  # cycles with z at a corner of its range with which a plan begins that is to get the ball off the bar
SWEEPS = 3  # linearise, solve, follow
LENGTHS = np.array([1.0, 0.5, 0.2, 0.05])  # parts of a planned change that are tried, until one is better
CHATTER = 6  # impacts in an interval beyond which the ball is coming to rest
TANGLED = 10.0  # cost of such an interval: more than a ball at the end of the bar
DIFFERENCE = 1e-4  # step of the derivatives, in units of observations and actions


@kernel
def _follow(ball, s, action, reached, units, spans, centre, params, options):
    """The state `reached` one control interval after `s`; returns the cost of a ball that is lost or comes to rest."""
    b, k = ball[0], units.shape[0]
    b.steps, b.impacts, b.resting, b.lost, b.fault = 0, 0, False, False, False
    b.x, b.u, b.z, b.w = s[0] * units[0], s[1] * units[1], s[2] * units[2], s[3] * units[3]
    b.spin = 0.0
    if k > 4:
        b.spin = s[4] * units[4]
    for i in range(6):
        b.motion[i] = centre[i] + spans[i] * s[k + i]
    new = (
        centre[0] + spans[0] * action[0], centre[1] + spans[1] * action[1], centre[2] + spans[2] * action[2],
        centre[3] + spans[3] * action[3], centre[4] + spans[4] * action[4], centre[5] + spans[5] * action[5],
    )  # fmt: skip
    interval(b, new, params, *options)
    reached[0], reached[1], reached[2], reached[3] = b.x / units[0], b.u / units[1], b.z / units[2], b.w / units[3]
    if k > 4:
        reached[4] = b.spin / units[4]
    reached[k:] = action
    if b.lost or b.fault:
        return math.inf
    return TANGLED if b.resting or b.impacts > CHATTER else 0.0


@kernel
def _cost(states, actions, task):
    """Sum of -ln(reward) and effort over the plan, and the linear-quadratic cost-to-go at its end."""
    target, base, effort, place, p = task
    total = 0.0
    for k in range(len(actions)):
        offset = place * states[k + 1, 0]
        total += math.log1p(offset * offset)
        for i in range(6):
            total += effort * (actions[k, i] - base[i]) ** 2
    end = states[-1] - target
    return total + end @ (p @ end)


@kernel
def _derivatives(states, actions, by_state, by_action, ball, system):
    """Forward differences of each step of the plan."""
    width = states.shape[1]
    moved = np.empty(width)
    for k in range(len(actions)):
        for j in range(width + 6):
            s, a = states[k].copy(), actions[k].copy()
            if j < width:
                s[j] += DIFFERENCE
            else:
                a[j - width] += DIFFERENCE
            _follow(ball, s, a, moved, *system)
            for i in range(width):
                slope = (moved[i] - states[k + 1, i]) / DIFFERENCE
                if j < width:
                    by_state[k, i, j] = slope
                else:
                    by_action[k, i, j - width] = slope


@kernel
def _backward(states, actions, by_state, by_action, change, gain, task):
    """Riccati's recursion along the plan: change (N, 6) and gain (N, 6, width) of the actions.

    -ln(reward) enters with its slope and the curvature of the quadratic that touches it from above. An action at the
    edge of the box that is pushed outwards stays there.
    """
    target, base, effort, place, p = task
    slope, curvature = p @ (states[-1] - target), p.copy()
    for k in range(len(actions) - 1, -1, -1):
        offset = place * states[k + 1, 0]
        weight = place / (1.0 + offset * offset)
        slope[0] += weight * offset
        curvature[0, 0] += weight * place
        f, g = by_state[k], by_action[k]
        vf, vg = curvature @ f, curvature @ g
        q_a, q_aa, q_as = g.T @ slope, g.T @ vg, g.T @ vf
        for i in range(6):
            q_a[i] += effort * (actions[k, i] - base[i])
            q_aa[i, i] += effort
        solve, right = q_aa.copy(), np.empty((6, 1 + q_as.shape[1]))
        right[:, 0], right[:, 1:] = q_a, q_as
        for i in range(6):
            if (actions[k, i] >= 1.0 and q_a[i] < 0.0) or (actions[k, i] <= -1.0 and q_a[i] > 0.0):
                solve[i, :], solve[:, i], right[i, :] = 0.0, 0.0, 0.0
                solve[i, i] = 1.0
        found = -np.linalg.solve(solve, right)
        change[k], gain[k] = found[:, 0], found[:, 1:]
        d, m = change[k], gain[k]
        slope = f.T @ slope + m.T @ q_a + q_as.T @ d + m.T @ (q_aa @ d)
        curvature = f.T @ vf + m.T @ q_as + q_as.T @ m + m.T @ (q_aa @ m)
        curvature = 0.5 * (curvature + curvature.T)


@kernel
def _clip(action):
    for i in range(6):
        action[i] = min(1.0, max(-1.0, action[i]))


@kernel
def _plan(start, feedback, task, ball, system):
    """The first action of the best plan found from the state `start`."""
    target, base, _, _, _ = task
    width = len(start)
    states, actions = np.empty((CYCLES + 1, width)), np.empty((CYCLES, 6))
    best_states, best_actions = states.copy(), actions.copy()
    states[0], best_states[0] = start, start
    best, tangled = math.inf, math.inf
    # begin with the base motion or linear feedback; if both bring the ball to rest, with this after some throws
    for kind in range(-1, 4**THROWS):
        if kind > 0 and tangled == 0.0:
            break
        extra = 0.0
        for k in range(CYCLES):
            actions[k] = base
            if kind >= 0:
                actions[k] -= feedback @ (states[k] - target)
            if kind > 0 and k < THROWS:
                corner = kind >> 2 * k
                actions[k, 4], actions[k, 5] = 1.0 - (corner & 2), 1.0 - 2.0 * (corner & 1)
            _clip(actions[k])
            extra += _follow(ball, states[k], actions[k], states[k + 1], *system)
        cost = extra + _cost(states, actions, task)
        if kind < 0 or extra < tangled or extra == tangled and cost < best:
            best, best_states[:], best_actions[:], tangled = cost, states, actions, extra
    if tangled > 0.0:
        return best_actions[0]
    by_state, by_action = np.empty((CYCLES, width, width)), np.empty((CYCLES, width, 6))
    change, gain = np.empty((CYCLES, 6)), np.empty((CYCLES, 6, width))
    for _ in range(SWEEPS):
        _derivatives(best_states, best_actions, by_state, by_action, ball, system)
        _backward(best_states, best_actions, by_state, by_action, change, gain, task)
        better = False
        for length in LENGTHS:
            extra = 0.0
            for k in range(CYCLES):
                actions[k] = best_actions[k] + length * change[k] + gain[k] @ (states[k] - best_states[k])
                _clip(actions[k])
                extra += _follow(ball, states[k], actions[k], states[k + 1], *system)
            cost = extra + _cost(states, actions, task)
            if cost < best:
                best, best_states[:], best_actions[:], better = cost, states, actions, True
                break
        if not better:
            break
    return best_actions[0]


@kernel
def _plans(starts, actions, feedback, task, ball, system):
    for i in range(len(starts)):
        actions[i] = _plan(starts[i], feedback, task, ball, system)


class RecedingHorizon:
    """Linear-quadratic control along the predicted motion of the next cycles (iterative LQR), planned at every action.

    From the state seen, the exact model without scatter is followed over eight cycles; Riccati's recursion along that
    motion improves the actions, three times, within the box. The cost is -ln(reward) and an effort; what comes after
    the plan counts by the cost-to-go of the linear-quadratic law about Bell's sink motion, with half the range of x and
    tilt. Where that law does not exist, as with actions every half cycle, this one is the sink motion.
    """

    TUNABLE: ClassVar[dict[str, tuple[float, float, float]]] = {}
    EFFORT = 0.03
    SHARE = 0.5  # of the range of x and tilt

    def __init__(self, scene: Scene) -> None:
        """Compiles its kernel for the scene, at the first action."""
        p = scene.params
        self.design = design = Design(scene)
        half = {"x_acceleration": self.SHARE * p.x_acceleration, "tilt_acceleration": self.SHARE * p.tilt_acceleration}
        self.action = BellSink(scene, z_acceleration=p.z_acceleration, **half).action.astype(float)
        self._task: tuple[Any, ...] | None = None
        place = np.zeros(len(design.units) + 6)
        place[0] = p.half_length / p.reward_width
        try:
            orbit = design.orbit(self.action)
            a, b = design.matrices(orbit.map)
            cost_to_go, self._feedback = riccati(a, b, np.outer(place, place), self.EFFORT * np.eye(6))
        except (ValueError, np.linalg.LinAlgError):
            return
        target = np.concatenate([orbit.ball / design.units, self.action])
        self._task = target, self.action, self.EFFORT, float(place[0]), np.ascontiguousarray(cost_to_go)
        params = design.map.params.copy()
        params["hold"] = p.hold
        self._ball = np.zeros(1, design.map.record)
        self._system = design.units, design.spans, design.centre, params, design.map.options

    def reset(self, n: int) -> None:
        """Nothing to forget."""

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        """Actions (n, 6) for observations (n, width)."""
        actions = np.tile(self.action, (len(observations), 1))
        if self._task is not None:
            starts = self.design.state(observations)
            _plans(starts, actions, np.ascontiguousarray(self._feedback), self._task, self._ball, self._system)
        return actions.astype(np.float32)
