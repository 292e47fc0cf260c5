"""The ride to 40 digits, written out anew from Newton's laws in absolute heights: Taylor series, piece by piece.

A piece ends where the ground's slope, the suspension or a contact changes. Within one the system is linear with an
entire input, so the Taylor coefficients of the heights follow from one another; a contact is a root of the gap's
series, found by bisection.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from mpmath import mp, mpf

from vr_envs.models.constants import G
from vr_envs.models.ride_options import TICK
from vr_envs.models.terrain import WAVES, wave
from vr_envs.models.weighting import MEMORY, weight

DIGITS = 40
SAMPLES = 16  # of a gap in a piece of at most a tick, 0.04 rad of a wheel's hop apart
SAME = mpf(10) ** -25  # s: two instants closer than this are one


class Seen(NamedTuple):
    """What is compared, one number per tick: m, m/s and s; `airborne`: time off the ground so far."""

    travel: list[Any]
    velocity: list[Any]
    deflection: list[Any]
    airborne: list[Any]


def series_root(gap: Sequence[Any], t: Any) -> Any:
    """First time in (0, t) at which the power series `gap` falls below 0; None if it does not.

    It is positive, or zero and rising, at 0. Bisected from samples, between which it has one minimum at most.
    """
    whole = np.array([float(c * t**n) for n, c in enumerate(gap)])[::-1]
    slope = np.polyder(whole)
    places = np.linspace(0.0, 1.0, SAMPLES + 1)
    for left, right in zip(places, places[1:], strict=False):
        below = np.polyval(whole, right) < 0.0
        if not below and np.polyval(slope, left) < 0.0 < np.polyval(slope, right):
            low, high = left, right
            for _ in range(60):
                middle = 0.5 * (low + high)
                low, high = (middle, high) if np.polyval(slope, middle) < 0.0 else (low, middle)
            below, right = np.polyval(whole, low) < 0.0, low
        if below:
            low, high = mpf(left) * t, mpf(right) * t
            while high - low > mpf(10) ** -(DIGITS - 2):
                middle = (low + high) / 2
                low, high = (low, middle) if mp.polyval(gap[::-1], middle) < 0 else (middle, high)
            return high
    return None


class Ride:
    """A vehicle at the distance 0, driven at constant speed; starts where a model's state is."""

    def __init__(self, state: Any, params: Any, options: Mapping[str, Any], knots: np.ndarray | None) -> None:
        """`params` and `options` (name -> instance) of the model; `knots` [m]: heights of the road, (n,)."""
        with mp.workdps(DIGITS):
            self._begin(state, params, options, knots)

    def _begin(self, state: Any, params: Any, options: Mapping[str, Any], knots: np.ndarray | None) -> None:
        self.params, self.tyre, self.stop = params, options.get("tyre"), options.get("stop")
        self.knots, self.spacing = knots, mpf(options["road"].knot_spacing) if knots is not None else mpf(1)
        self.waves = []
        if options.get("undulation") is not None:
            for i in range(WAVES):
                size, number = wave.py_func(i, options["undulation"])
                self.waves.append(
                    (size, mpf(number), mpf(float(state["wave_sin"][i])), mpf(float(state["wave_cos"][i])))
                )
        self.time, self.airborne_time = mpf(0), mpf(0)
        self.knot, self.airborne, self.side = 0, bool(state["airborne"]), int(state["side"])
        self.contacts: list[tuple[str, Any]] = []
        ground = self._ground(1)[0]
        hub = ground + mpf(float(state["deflection"]))
        self.y = [
            hub + mpf(float(state["travel"])),
            mpf(float(state["velocity"])),
            hub,
            mpf(float(state["hub_velocity"])),
        ]

    def drive(self, actions: np.ndarray) -> Seen:
        """Drive one tick with each action (positions of damping and modulus)."""
        seen = Seen([], [], [], [])
        with mp.workdps(DIGITS):
            for action in actions:
                self._tick(*self.suspension([mpf(float(a)) for a in action]))
                ground = self._ground(1)[0]
                hub = ground if self.tyre is None else self.y[2]
                for values, value in zip(
                    seen, (self.y[0] - hub, self.y[1], hub - ground, self.airborne_time), strict=True
                ):
                    values.append(value)
        return seen

    def suspension(self, action: Sequence[Any]) -> tuple[Any, Any]:
        """Damping and stiffness over mass, logarithmic in the positions from -1 to 1."""
        p = self.params
        ends = ((p.damping_low, p.damping_high), (p.modulus_low, p.modulus_high))
        damping, modulus = (
            mp.sqrt(mpf(a) * b) * mp.sqrt(mpf(b) / a) ** x for (a, b), x in zip(ends, action, strict=True)
        )
        return damping, modulus * mpf(p.spring_rate) / p.mass

    def _ground(self, terms: int) -> list[Any]:
        """Taylor coefficients of the height of the ground under the wheel, from now on."""
        speed, height = mpf(self.params.speed), [mpf(0)] * terms
        if self.knots is not None:
            low, high = (mpf(float(h)) for h in self.knots[self.knot : self.knot + 2])
            slope = (high - low) / self.spacing
            height[0] = low + slope * (speed * self.time - self.knot * self.spacing)
            if terms > 1:
                height[1] = slope * speed
        for size, number, sine, cosine in self.waves:
            rate, angle = number * speed, number * speed * self.time
            value = size * (sine * mp.cos(angle) + cosine * mp.sin(angle))
            other = size * (cosine * mp.cos(angle) - sine * mp.sin(angle))
            for n in range(terms):
                height[n] += value
                value, other = other * rate / (n + 1), -value * rate / (n + 1)
        return height

    def _tick(self, gamma: Any, w2: Any) -> None:
        end = self.time + mpf(TICK)
        while end - self.time > SAME:
            t = end - self.time
            if self.knots is not None:
                to_knot = (self.knot + 1) * self.spacing / self.params.speed - self.time
                if to_knot <= SAME:
                    self.knot += 1
                    continue
                t = min(t, to_knot)
            self._piece(gamma, w2, t)

    def _gaps(self, body: list[Any], hub: list[Any], ground: list[Any]) -> dict[str, list[Any]]:
        """Of each contact the series that is positive as long as it stays as it is."""
        found = {}
        if self.tyre is not None:
            free = (mpf(self.params.mass) + self.tyre.unsprung_mass) * mpf(G) / self.tyre.rate
            sign = 1 if self.airborne else -1
            found["tyre"] = [sign * (h - r) for h, r in zip(hub, ground, strict=True)]
            found["tyre"][0] -= sign * free
        if self.stop is not None:
            travel = [b - h for b, h in zip(body, hub, strict=True)]
            for name, sign in (("top", 1), ("bottom", -1)):
                if self.side in (0, sign):
                    inside = sign if self.side == sign else -sign
                    found[name] = [inside * u for u in travel]
                    found[name][0] -= inside * sign * mpf(self.stop.travel)
        return found

    def _piece(self, gamma: Any, w2: Any, t: Any) -> None:
        """Move for the time t, or until the first contact changes."""
        terms = 24
        while True:
            ground = self._ground(terms)
            body, hub = self._series(gamma, w2, ground, terms)
            if max(abs(series[-k]) * t ** (terms - k) for series in (body, hub) for k in (1, 2)) < mpf(10) ** -DIGITS:
                break
            terms += 8
        name = None
        for kind, gap in self._gaps(body, hub, ground).items():
            root = series_root(gap, t)
            if root is not None and root < t:
                name, t = kind, root
        for i, series in ((0, body), (2, hub)):
            self.y[i], self.y[i + 1] = mp.polyval(series[::-1], t, derivative=True)
        self.time += t
        if self.airborne:
            self.airborne_time += t
        if name is not None:
            self.contacts.append((name, self.time))
            if name == "tyre":
                self.airborne = not self.airborne
            else:
                self.side = 0 if self.side else {"top": 1, "bottom": -1}[name]

    def _series(self, gamma: Any, w2: Any, ground: list[Any], terms: int) -> tuple[list[Any], list[Any]]:
        """Taylor coefficients of the heights of body and hub; without a tyre the hub is on the ground."""
        p = self.params
        relative = p.damping == "relative"
        body = self.y[:2]
        hub = ground if self.tyre is None else self.y[2:]
        rubber = reach = mpf(0)
        if self.stop is not None:
            rubber, reach = mpf(self.stop.rate) / p.mass, mpf(self.stop.travel)
        for n in range(terms - 2):
            inner = -w2 * (body[n] - hub[n])
            if self.side:
                inner -= rubber * (body[n] - hub[n] - (self.side * reach if n == 0 else 0))
            rate = (n + 1) * (body[n + 1] - hub[n + 1]) if relative else (n + 1) * body[n + 1]
            if relative:
                inner -= gamma * rate
            body.append((inner if relative else inner - gamma * rate) / ((n + 1) * (n + 2)))
            if self.tyre is not None:
                if self.airborne:
                    push = -(p.mass + mpf(self.tyre.unsprung_mass)) * mpf(G) if n == 0 else mpf(0)
                else:
                    push = -mpf(self.tyre.rate) * (hub[n] - ground[n])
                hub.append((push - p.mass * inner) / self.tyre.unsprung_mass / ((n + 1) * (n + 2)))
        return body, hub


def weighted_rms(velocities: Sequence[Any], root: Callable[[Any], Any]) -> Any:
    """R.m.s. of the weighted mean acceleration of the ticks [m/s^2], from the velocities before them and after [m/s].

    `root` is the square root for the type of number.
    """
    memory, squares = [0.0 * velocities[0]] * MEMORY, 0.0 * velocities[0]
    for before, after in zip(velocities, velocities[1:], strict=False):
        weighted = weight.py_func(memory, (after - before) / TICK)
        squares = squares + weighted * weighted
    return root(squares / (len(velocities) - 1))
