"""The bouncing ball to more than 30 digits, from the equations of motion alone: shares no formula with the kernels.

Contacts are found by scanning the gap and bracketing, and chatter is followed impact by impact until nothing is left of
it. The scatter's draws are taken as given numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import mpmath as mp
import numpy as np

GRID = 120  # samples of the gap per half cycle: flights here are transversal and many samples long
NOTHING = mp.mpf(10) ** -24  # m/s: what is left of a chatter when the ball has come to rest
DIGITS = 60

Draws = Callable[[int], tuple[Any, Any]]


class Reference:
    """A ball and what has happened to it.

    `impacts`: (time in the cycle, x, z, approach velocity along the normal) of each; `releases`: (cycle, time in it).
    """

    def __init__(
        self, params: np.void, state: np.void, options: Mapping[str, np.void | None] | None = None, digits: int = DIGITS
    ) -> None:
        """The ball of `state`, a record of the model, over a bar with these parameters and options."""
        self.digits = digits
        with mp.workdps(digits):
            self._begin(params, state, options or {})

    def _begin(self, params: np.void, state: np.void, options: Mapping[str, np.void | None]) -> None:
        self.p = {name: mp.mpf(float(params[name])) for name in params.dtype.names or ()}
        self.o = {
            k: None if o is None else {n: mp.mpf(float(o[n])) for n in o.dtype.names or ()} for k, o in options.items()
        }
        self.x, self.z, self.u, self.w = (mp.mpf(float(state[k])) for k in ("x", "z", "u", "w"))
        self.spin = mp.mpf(float(state["spin"]))
        self.old = [mp.mpf(float(v)) for v in state["motion"]]
        self.number = int(state["steps"])
        self.stuck: Any = None  # place on the bar of a ball at rest
        self.impacts: list[tuple[Any, ...]] = []
        self.releases: list[tuple[int, Any]] = []

    def option(self, name: str) -> Any:
        """An option's values, or None."""
        return self.o.get(name)

    def bar(self, new: Sequence[Any], s: Any, order: int = 0) -> list[Any]:
        """(x, tilt, z) of the bar at time s of the cycle, or the first or second derivative of that."""
        w, blend = self.p["omega"], self.p["blend"] * self.p["period"]
        u = min(s / blend, mp.mpf(1))
        weights = [u * u * (3 - 2 * u)]
        if order > 0:
            weights += [6 * u * (1 - u) / blend, 6 * (1 - 2 * u) / blend**2 if u < 1 else mp.mpf(0)]
        # of each phasor the value and the derivatives
        m = [[k * (b - a) for k in weights] for a, b in zip(self.old, new, strict=True)]
        for phasor, a in zip(m, self.old, strict=True):
            phasor[0] += a
        ratios = [1, 1, 2]
        ramp, free = self.option("ramp"), self.option("frequencies")
        if ramp:
            elapsed = [self.number * self.p["period"] + s, mp.mpf(1), mp.mpf(0)]
            for i, name in enumerate(("x_cos", "x_sin", "tilt_cos", "tilt_sin", "z_cos", "z_sin")):
                rate = ramp[name] / (w * (2 if i > 3 else 1)) ** 2
                m[i] = [v + t * rate for v, t in zip(m[i], elapsed, strict=False)]
        if free:
            ratios = [free["x"], free["tilt"], free["z"]]
        # the base cycle is 1 / frequency to the last digit, as in the doubles
        turn, place = 2 * mp.pi * self.number + w * s, []
        turned = {r: mp.cos_sin(r * turn) for r in set(ratios)}
        for r, p, q in zip(ratios, m[::2], m[1::2], strict=True):
            # the derivative of p cos + q sin is (p' + r w q) cos + (q' - r w p) sin
            for _ in range(order):
                p, q = (
                    [after + r * w * other for after, other in zip(p[1:], q, strict=False)],
                    [after - r * w * other for after, other in zip(q[1:], p, strict=False)],
                )
            cos, sin = turned[r]
            place.append(p[0] * cos + q[0] * sin)
        return place

    def curvature(self) -> Any:
        """Of the surface, 1/m."""
        return self.option("curve")["curvature"] if self.option("curve") else mp.mpf(0)

    def gap(self, new: Sequence[Any], s: Any, since: Any) -> Any:
        """Distance of the flying ball from the surface, along the bar's normal."""
        t = s - since
        bx, tilt, bz = self.bar(new, s)
        rx = self.x + self.u * t - bx
        rz = self.z + self.w * t - self.p["gravity"] * t * t / 2 - bz
        cos, sin = mp.cos_sin(tilt)
        along, across = rx * cos - rz * sin, rx * sin + rz * cos
        return across - self.curvature() * along**2 / 2

    def cycle(self, motion: Sequence[float], draws: Draws | None = None) -> None:
        """One base cycle in which the bar goes to `motion`.

        `draws(i)`: restitution and deviation of the normal of impact i, in place of the mean ones.
        """
        with mp.workdps(self.digits):
            self._cycle([mp.mpf(float(v)) for v in motion], draws)

    def _cycle(self, new: list[Any], draws: Draws | None) -> None:
        s, period, left = mp.mpf(0), self.p["period"], None
        grid = period / 2 / GRID
        while True:
            if self.stuck is not None:
                s = self.carried(new, s)
                if self.stuck is not None:
                    break
                left = grid / 10  # it separates with the cube of the time
            step = grid if left is None else min(grid, left)
            a = s if left is None else s + step / 1000
            b = a + step
            while b < period and self.gap(new, b, s) > 0:
                # twice as long each time, so that the bracket of a short flight is about as short
                step = min(grid, 2 * step)
                a, b = b, b + step
            b = min(b, period)
            if self.gap(new, b, s) > 0:
                self.fly(period - s)
                break
            t = mp.findroot(
                lambda t, s=s: self.gap(new, t, s),
                (a, b),
                solver="anderson",
                tol=mp.mpf(10) ** -self.digits,
                verify=False,
            )
            self.fly(t - s)
            s = t
            leaving = self.collide(new, s, draws)
            left = leaving / (30 * self.p["gravity"])
            if leaving < NOTHING:
                bx, tilt, bz = self.bar(new, s)
                self.stuck = (self.x - bx) * mp.cos(tilt) - (self.z - bz) * mp.sin(tilt)
        self.old = new
        self.number += 1

    def fly(self, t: Any) -> None:
        """Free fall for the time t."""
        self.x += self.u * t
        self.z += self.w * t - self.p["gravity"] * t * t / 2
        self.w -= self.p["gravity"] * t

    def collide(self, new: Sequence[Any], s: Any, draws: Draws | None) -> Any:
        """One impact; returns the normal velocity with which the ball leaves."""
        (bx, tilt, bz), (vx, vt, vz) = self.bar(new, s), self.bar(new, s, 1)
        rx, rz = self.x - bx, self.z - bz
        u, w = self.u - (vx + vt * rz), self.w - (vz - vt * rx)
        restitution, deviation = (self.p["restitution"], 0) if draws is None else draws(len(self.impacts))
        place = rx * mp.cos(tilt) - rz * mp.sin(tilt)
        angle = tilt - mp.atan(self.curvature() * place) + deviation
        n = (mp.sin(angle), mp.cos(angle))
        t = (n[1], -n[0])
        normal, tangent = u * n[0] + w * n[1], u * t[0] + w * t[1]
        soft, spin, friction = (self.option(k) for k in ("softening", "spin", "friction"))
        if soft:
            restitution = restitution / (1 + abs(normal) / soft["speed"]) ** soft["exponent"]
        d_n = -(1 + restitution) * normal
        slip, mass = tangent, self.p["tangential_loss"]
        if spin:
            slip, mass = tangent - self.spin + spin["radius"] * vt, spin["inertia_ratio"] / (1 + spin["inertia_ratio"])
        d_t = -mass * slip
        if friction:
            d_t *= 1 + friction["restitution"]
            most = friction["coefficient"] * d_n
            d_t = max(-most, min(most, d_t))
        if spin:
            self.spin -= d_t / spin["inertia_ratio"]
        self.u += d_n * n[0] + d_t * t[0]
        self.w += d_n * n[1] + d_t * t[1]
        self.impacts.append((s, self.x, self.z, normal))
        return normal + d_n

    def force(self, new: Sequence[Any], s: Any) -> Any:
        """Normal force per mass on the ball that sticks, along the normal of a flat bar."""
        tilt = self.bar(new, s)[1]
        ax, at, az = self.bar(new, s, 2)
        return ax * mp.sin(tilt) + (az + self.p["gravity"]) * mp.cos(tilt) - self.stuck * at

    def carried(self, new: Sequence[Any], s: Any) -> Any:
        """Carry a ball that sticks on a flat bar to its release or the end of the cycle; returns the time."""
        period = self.p["period"]
        step, t = period / 2 / GRID, s
        while t < period and self.force(new, min(t + step, period)) > 0:
            t += step
        release = t < period
        t = mp.findroot(lambda t: self.force(new, t), (t, t + step), solver="anderson") if release else period
        (bx, tilt, bz), (vx, vt, vz) = self.bar(new, t), self.bar(new, t, 1)
        rx, rz = self.stuck * mp.cos(tilt), -self.stuck * mp.sin(tilt)
        self.x, self.z, self.u, self.w = bx + rx, bz + rz, vx + vt * rz, vz - vt * rx
        if release:
            self.stuck = None
            self.releases.append((self.number, t))
        return t
