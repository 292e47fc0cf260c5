"""The ball by SciPy's `solve_ivp`: an adaptive integrator of the flight, whose event is the ball on the surface.

It has to be kept from stepping over a contact (it looks at the event function at the ends of its steps only, and a step
over a parabola may be as long as it likes) and from calling the beginning of a flight its end: a step is at most
`LONGEST` of a base cycle, and at most `SHARE` of the shortest flight that the impact may lead to. An impact that the
ball leaves slower than `REST` puts it on the bar, which is meant for bars that move up and down only. LSODA's dense
output does not end where its step does, so its event may have no root there: then the run went astray.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root_scalar

from vr_envs.bench.accuracy.ball_on_bar_episodes import Episode, Track
from vr_envs.bench.accuracy.ball_on_bar_loops import collided, gap

LONGEST = 1.0 / 20.0  # base cycles
SHARE = 0.25
REST = 1e-6  # m/s


def simulate(episode: Episode, method: str, tolerance: float) -> Track:
    """The episode with `solve_ivp`'s `method` and this relative and absolute tolerance."""
    p = episode.params
    omega, gravity, period = float(p["omega"]), float(p["gravity"]), float(p["period"])
    restitution, loss, blend = float(p["restitution"]), float(p["tangential_loss"]), float(p["blend"]) * period
    state = np.array(episode.place)
    rows = [tuple(row) for row in episode.motions.tolist()]
    highest = max(math.hypot(*row[4:]) for row in rows)
    downwards = gravity + 4.0 * omega**2 * highest  # m/s^2, towards the bar at most
    impacts, ends, resting, leaving = [], [], False, math.inf

    def fall(_: float, y: np.ndarray) -> list[float]:
        return [y[2], y[3], 0.0, -gravity]

    for k in range(len(rows) - 1):
        old, new = rows[k], rows[k + 1]

        def touch(s: float, y: np.ndarray, old: tuple[float, ...] = old, new: tuple[float, ...] = new) -> float:
            return gap(old, new, s, omega, blend, y[0], y[1])

        touch.terminal, touch.direction = True, -1.0  # type: ignore[attr-defined]
        s = 0.0
        while s < period:
            if resting:
                s = min(period, _release(new, s, period, omega, gravity))
                state[1], state[3] = _carried(new, s, omega)
                resting, leaving = s == period, math.inf
                continue
            longest = min(LONGEST * period, SHARE * 2.0 * leaving / downwards)
            try:
                found = solve_ivp(
                    fall, (s, period), state, method, events=touch, rtol=tolerance, atol=tolerance, max_step=longest
                )
            except ValueError:  # of the search for the event's root
                return Track(np.empty((0, 3)), np.full((1, 4), math.nan))
            s, state = float(found.t[-1]), found.y[:, -1]
            if found.status != 1:
                break
            *moved, normal, rests = collided(old, new, s, omega, blend, *state, restitution, loss, REST)
            state, resting, leaving = np.array(moved), rests, -restitution * normal
            impacts.append((k, s, normal))
        ends.append(state.copy())
    return Track(np.array(impacts).reshape(-1, 3), np.array(ends))


def _carried(motion: tuple[float, ...], s: float, omega: float) -> tuple[float, float]:
    """Height and velocity of a bar that only moves up and down."""
    c, n, w = math.cos(2.0 * omega * s), math.sin(2.0 * omega * s), 2.0 * omega
    return motion[4] * c + motion[5] * n, w * (motion[5] * c - motion[4] * n)


def _release(motion: tuple[float, ...], s: float, period: float, omega: float, gravity: float) -> float:
    """Time from s on at which the bar falls away as fast as a free ball; infinite if it does not in this cycle."""

    def push(t: float) -> float:
        return gravity - 4.0 * omega**2 * _carried(motion, t, omega)[0]

    steps = np.append(np.arange(s, period, LONGEST * period), period).tolist()
    for early, late in zip(steps[:-1], steps[1:], strict=True):
        if push(early) > 0.0 >= push(late):
            return float(root_scalar(push, bracket=(early, late), method="brentq", xtol=1e-16).root)
    return math.inf
