"""The aircraft to 40 digits, written out anew from its description: Taylor series of every quantity, piece by piece.

Between the instants at which a rate reaches its lag's limit or leaves it, which are known in closed form, all
quantities are entire functions of time, and their Taylor coefficients follow from one another. A piece is at most a
control interval long, so some thirty terms leave less than the working precision.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from mpmath import mp, mpf

from vr_envs.models.autopilot_limits import SLOWEST
from vr_envs.models.constants import G

DIGITS = 40
SEEN = ("altitude", "speed", "heading", "x", "z")


def product(a: Sequence[Any], b: Sequence[Any], n: int) -> Any:
    """Coefficient n of the product of two power series."""
    return mp.fdot(a[: n + 1], b[n::-1])


class Flight:
    """An aircraft in a scene without gusts; `y` holds the three rates, then what is in `SEEN`."""

    def __init__(self, params: Any, options: Mapping[str, Any], start: Mapping[str, float]) -> None:
        """`params` and `options` (name -> instance) of the model; `start`: initial values of `SEEN`, 0 if left out.

        Raises:
            ValueError: limits are not renewed once per control interval, or there is turbulence.
        """
        if params.refresh != params.dt or options.get("turbulence") is not None:
            raise ValueError("the reference is for scenes without turbulence whose refresh is the control interval")
        self.params, self.options = params, {name: o for name, o in options.items() if o is not None}
        self.y = [mpf(0)] * 3 + [mpf(start.get(name, 0.0)) for name in SEEN]

    def fly(self, actions: np.ndarray) -> list[list[Any]]:
        """`SEEN` after every control interval, (intervals, 5); the heading is not wrapped."""
        with mp.workdps(DIGITS):
            return [self._interval([mpf(float(a)) for a in action]) for action in actions]

    def _limits(self) -> tuple[Any, Any]:
        """Largest climb and turn rate here and now."""
        p, envelope = self.params, self.options.get("envelope")
        altitude, speed = self.y[3], self.y[4]
        if envelope is None:
            return mpf(p.climb), mpf(p.turn)
        lapse = (mpf(p.climb) - envelope.cruise_climb) / envelope.cruise_altitude
        return mpf(p.climb) - lapse * altitude, min(mpf(p.turn), mpf(G) * mp.tan(mpf(envelope.bank)) / speed)

    def _interval(self, action: list[Any]) -> list[Any]:
        p = self.params
        climb, turn = self._limits()
        rise = action[0] * (climb if action[0] > 0 else p.descent)
        gain = action[1] * (p.acceleration if action[1] > 0 else p.deceleration)
        if "energy" in self.options:
            share = mpf(G) / max(self.y[4], mpf(SLOWEST))
            gain = min(gain, share * (climb - rise))
            gain = max(gain, min(mpf(p.acceleration), share * (-self.options["energy"].idle_sink - rise)))
        goals, left = (rise, gain, action[2] * turn), mpf(p.dt)
        lags = self.options.get("lags")
        if lags is None:
            self.y[:3] = goals
            self._piece(goals, None, left)
        else:
            slews = (mpf(lags.vertical_slew), mpf(lags.jerk), turn / lags.roll_in)
            constants = (mpf(lags.vertical), mpf(lags.along), mpf(lags.turn))
            until = [abs(g - r) / s - c for g, r, s, c in zip(goals, self.y, slews, constants, strict=False)]
            corners = sorted({min(t, left) for t in until if t > 0} | {left})
            for begin, end in zip([mpf(0), *corners], corners, strict=False):
                # the limit of a rate acts until its own corner
                ramps = [mp.sign(g - r) * s if begin < t else None
                         for g, r, s, t in zip(goals, self.y, slews, until, strict=False)]  # fmt: skip
                self._piece(goals, (ramps, constants), end - begin)
        return self.y[3:]

    def _piece(self, goals: Sequence[Any], lags: Any, t: Any) -> None:
        """Move over a time in which no rate reaches or leaves its limit."""
        wind, shear = self.options.get("wind"), self.options.get("shear")
        gradient, origin = (mpf(0), mpf(0)) if shear is None else (mpf(shear.gradient), mpf(shear.origin))
        drift = [mpf(0), mpf(0)]
        if wind is not None:
            drift = [-mpf(wind.speed) * f(mpf(wind.origin)) for f in (mp.sin, mp.cos)]
        rates = [[r] for r in self.y[:3]]
        altitude, speed, heading, x, z = ([value] for value in self.y[3:])
        sine, cosine = [mp.sin(heading[0])], [mp.cos(heading[0])]
        towards = mp.cos(origin), mp.sin(origin)
        power, n = mpf(1), 0
        while True:
            into_wind = [towards[0] * c + towards[1] * s for c, s in zip(cosine, sine, strict=True)]
            altitude.append(rates[0][n] / (n + 1))
            speed.append((rates[1][n] + gradient * product(rates[0], into_wind, n)) / (n + 1))
            heading.append(rates[2][n] / (n + 1))
            x.append((product(speed, sine, n) - gradient * altitude[n] * towards[1]) / (n + 1))
            z.append((product(speed, cosine, n) - gradient * altitude[n] * towards[0]) / (n + 1))
            if n == 0:
                x[1], z[1] = x[1] + drift[0], z[1] + drift[1]
            after = product(rates[2], cosine, n) / (n + 1), -product(rates[2], sine, n) / (n + 1)
            sine.append(after[0])
            cosine.append(after[1])
            for i, rate in enumerate(rates):
                change = mpf(0)
                if lags is not None:
                    ramps, constants = lags
                    pull = (goals[i] if n == 0 else mpf(0)) - rate[n]
                    change = pull / constants[i] if ramps[i] is None else ramps[i] if n == 0 else mpf(0)
                rate.append(change / (n + 1))
            n, power = n + 1, power * t
            terms = [abs(series[n]) * power for series in (*rates, altitude, speed, heading, x, z, sine, cosine)]
            if n > 8 and max(terms) < mpf(10) ** -DIGITS:
                break
        self.y = [mp.polyval(series[::-1], t) for series in (*rates, altitude, speed, heading, x, z)]
