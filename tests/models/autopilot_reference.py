"""The aircraft written out anew from its description, integrated by DOP853, restarted at every corner."""

import math

import numpy as np
from scipy.integrate import solve_ivp

G = 9.80665
NAMES = ("vertical_speed", "acceleration", "turn_rate", "altitude", "speed", "heading", "x", "z")
TAU, SLEW = (2.5, 3.5, 1.8), (1.5, 0.15)  # of the default lags
BANK, IDLE = math.radians(25.0), 8.0
WIND, WIND_ORIGIN, GRADIENT, SHEAR_ORIGIN = 12.0, 2.0, 0.02, 0.7


class Flight:
    """An aircraft with the default parameters, and the parts that are named switched on.

    Parts: envelope, energy, lags, wind, shear. `y` has the order of NAMES; limits are renewed every second.
    """

    def __init__(self, parts: str, **values: float) -> None:
        self.parts = set(parts.split())
        self.y = np.array([values.get(name, 0.0) for name in NAMES])
        self.time, self.sheared, self.stops = 0.0, False, 0

    def fly(self, action: np.ndarray, duration: float) -> None:
        """Hold an action; `duration` in s is a whole number, so that the limits are renewed at the ends of seconds."""
        for _ in range(round(duration)):
            climb, turn = 13.0, math.radians(3.0)
            if "envelope" in self.parts:
                climb = 13.0 - 7.0 * self.y[3] / 11000.0
                if self.y[4] > 0.0:
                    turn = min(turn, G * math.tan(BANK) / self.y[4])
            self.sheared = "shear" in self.parts and self.y[4] > 0.0
            rise = action[0] * (climb if action[0] > 0.0 else 10.0)
            gain = action[1] * 0.6
            if "energy" in self.parts:
                share = G / max(self.y[4], 0.01)
                gain = min(gain, share * (climb - rise))
                gain = max(gain, min(0.6, share * (-IDLE - rise)))
            self._second((rise, gain, action[2] * turn), (*SLEW, turn / 4.0))

    def _slopes(self, goal: tuple[float, ...], slew: tuple[float, ...], y: np.ndarray) -> np.ndarray:
        rates, bends = y[:3], np.zeros(3)
        if "lags" in self.parts:
            bends = np.array([min(slew[i], max(-slew[i], (goal[i] - y[i]) / TAU[i])) for i in range(3)])
        east, north = math.sin(y[5]), math.cos(y[5])
        gain = rates[1]
        over = y[4] * np.array([east, north])
        if "wind" in self.parts:
            over -= WIND * np.array([math.sin(WIND_ORIGIN), math.cos(WIND_ORIGIN)])
        if "shear" in self.parts:
            over -= GRADIENT * y[3] * np.array([math.sin(SHEAR_ORIGIN), math.cos(SHEAR_ORIGIN)])
        if self.sheared:
            gain += GRADIENT * rates[0] * math.cos(y[5] - SHEAR_ORIGIN)
        return np.array([*bends, rates[0], gain, rates[2], *over])

    def _integrate(self, goal: tuple[float, ...], slew: tuple[float, ...], duration: float) -> tuple[np.ndarray, float]:
        """The state after `duration`, or after the time at which the airspeed reaches 0, and the time."""

        def stop(_: float, y: np.ndarray) -> float:
            return y[4]

        stop.terminal, stop.direction = True, -1.0

        def run(time: float, events: object = None) -> object:
            return solve_ivp(
                lambda _, y: self._slopes(goal, slew, y), (0.0, time), self.y, "DOP853", rtol=1e-13, atol=1e-13,
                events=events,
            )  # fmt: skip

        leg = run(duration, stop if self.y[4] > 0.0 else None)
        end, time = leg.y[:, -1], leg.t[-1]
        if leg.status == 1:
            for _ in range(3):  # Newton, from where the interpolation puts the root
                time -= end[4] / self._slopes(goal, slew, end)[4]
                end = run(time).y[:, -1] if time > 0.0 else self.y
        return end, time

    def _second(self, goal: tuple[float, float, float], slew: tuple[float, ...]) -> None:
        left = 1.0
        while left > 1e-14:
            if "lags" not in self.parts:
                self.y[:3] = goal
            if self.y[4] <= 0.0 and self.y[1] <= 0.0:
                self.sheared = False
                self.y[4] = self.y[1] = 0.0
                goal = (goal[0], max(0.0, goal[1]), goal[2])
                if "lags" not in self.parts:
                    self.y[1] = goal[1]
            corners = [left]
            if "lags" in self.parts:
                corners += [(abs(goal[i] - self.y[i]) - slew[i] * TAU[i]) / slew[i] for i in range(3)]
            piece = min(c for c in corners if c > 1e-14)
            self.y, time = self._integrate(goal, slew, piece)
            if time < piece:
                self.y[4] = self.y[1] = 0.0
                self.sheared = False
                self.stops += 1
            left -= time
