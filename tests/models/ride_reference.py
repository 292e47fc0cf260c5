"""An independent ride: Newton's laws in absolute heights by DOP853 at 1e-13, restarted at every knot and contact."""

import numpy as np
from scipy.integrate import solve_ivp

from vr_envs.models.constants import G
from vr_envs.models.ride_options import TICK
from vr_envs.models.terrain import wave

DEPTH = 1e-14  # m: a contact that comes and goes and is no deeper moves nothing to 1e-13
SHORTEST = 1e-7  # s: nor does one that lasts no longer
POSITION, SPEED, BODY, BODY_RATE, HUB, HUB_RATE = range(6)


class Reference:
    """A vehicle at `position` 0 of a road of heights `knots` [m], as dataclasses; starts where a model's state is."""

    def __init__(self, state, params, knots=None, spacing=1.0, undulation=None, tyre=None, stop=None, cruise=None):
        self.p, self.tyre, self.stop, self.cruise = params, tyre, stop, cruise
        self.knots, self.spacing, self.knot = knots, spacing, 0
        self.waves = []
        if undulation is not None:
            phases = np.arctan2(state["wave_sin"], state["wave_cos"])
            self.waves = [(*wave.py_func(i, undulation), phase) for i, phase in enumerate(phases)]
        self.payload = float(state["payload"])
        self.airborne, self.side, self.forward = bool(state["airborne"]), float(state["side"]), 0.0
        self.liftoffs, self.touches, self.airborne_time = 0, 0, 0.0
        ground = self.ground(0.0)[0]
        hub = ground + (float(state["deflection"]) if tyre is not None else 0.0)
        self.y = np.array([0.0, params.speed, hub + state["travel"], state["velocity"], hub, state["hub_velocity"]])

    def ground(self, x):
        """Height and slope of the ground at the distance x, on the present segment of the road."""
        height, slope = 0.0, 0.0
        if self.knots is not None:
            left, right = self.knots[self.knot], self.knots[self.knot + 1]
            slope = (right - left) / self.spacing
            height = left + slope * (x - self.knot * self.spacing)
        for a, k, p in self.waves:
            height += a * np.sin(k * x + p)
            slope += a * k * np.cos(k * x + p)
        return height, slope

    def parts(self, y):
        """Travel and its rate, deflection and its rate, and the accelerations of mass and hub."""
        height, slope = self.ground(y[POSITION])
        gamma, w2, force = self.suspension
        climb = slope * y[SPEED]
        hub, hub_rate = (height, climb) if self.tyre is None else (y[HUB], y[HUB_RATE])
        travel = y[BODY] - hub
        inner = force - w2 * travel
        if self.side != 0.0:
            inner -= self.stop.rate / self.p.mass * (travel - self.side * self.stop.travel)
        if self.p.damping == "absolute":
            body = inner - gamma * y[BODY_RATE] + self.payload
        else:
            inner -= gamma * (y[BODY_RATE] - hub_rate)
            body = inner + self.payload
        lift = 0.0
        if self.tyre is not None:
            mass = self.tyre.unsprung_mass
            ground = -(self.p.mass + mass) * G if self.airborne else -self.tyre.rate * (hub - height)
            lift = (ground - self.p.mass * inner) / mass
        return travel, y[BODY_RATE] - hub_rate, hub - height, hub_rate - climb, body, lift

    def equation(self, _, y):
        *_, body, hub = self.parts(y)
        return np.array([y[SPEED], self.forward, y[BODY_RATE], body, y[HUB_RATE], hub])

    def gaps(self):
        """Of every contact: its name, side, and the gap that closes, as (which of `parts`, its value there)."""
        found = []
        if self.tyre is not None:
            limit = (self.p.mass + self.tyre.unsprung_mass) * G / self.tyre.rate
            found.append(("tyre", 1.0 if self.airborne else -1.0, 2, limit))
        if self.stop is not None and self.side == 0.0:
            found += [("top", -1.0, 0, self.stop.travel), ("bottom", 1.0, 0, -self.stop.travel)]
        elif self.stop is not None:
            found.append(("leave", self.side, 0, self.side * self.stop.travel))
        return found

    def events(self):
        """What ends a piece, by name, and functions that fall through zero there; then where gaps are smallest."""
        found = []
        if self.knots is not None:
            end = (self.knot + 1) * self.spacing
            found.append(("knot", lambda t, y: end - y[POSITION]))
        if self.forward != 0.0:
            found.append(("arrival", lambda t, y: np.sign(self.forward) * (self.target - y[SPEED])))
        for name, sign, part, limit in self.gaps():

            def gap(t, y, sign=sign, part=part, limit=limit):
                # a contact that has just changed is no event
                size = sign * (self.parts(y)[part] - limit)
                return size if t > SHORTEST else max(size, DEPTH)

            found.append((name, gap))
        for _, function in found:
            function.terminal, function.direction = True, -1.0
        closest = [lambda t, y, s=sign, p=part: s * self.parts(y)[p + 1] for _, sign, part, _ in self.gaps()]
        for function in closest:
            function.direction = 1.0
        return found, closest

    def piece(self, t):
        """Integrate until t or the first event; an event that passes within one step of the integrator counts."""
        ends, closest = self.events()
        functions = [e for _, e in ends] + closest
        while True:
            found = solve_ivp(self.equation, (0.0, t), self.y, "DOP853", rtol=1e-13, atol=1e-15, events=functions)
            missed = []
            for k, (_, gap) in enumerate(ends):
                if k >= len(ends) - len(closest):
                    at = len(closest) + k
                    times, states = [*found.t_events[at], found.t[-1]], [*found.y_events[at], found.y[:, -1]]
                    missed += [s for s, y in zip(times, states, strict=True) if gap(s, y) < -DEPTH]
            if not missed or min(missed) == t:
                return found, next((n for (n, _), times in zip(ends, found.t_events, strict=False) if len(times)), None)
            t = min(missed)

    def advance(self, t, suspension, target=None):
        """Ride for the time t with (gamma, w2, force) held and the speed on its way to `target`."""
        self.suspension, self.target = suspension, target
        self.forward = 0.0
        if target is not None and target != self.y[SPEED]:
            self.forward = np.copysign(self.cruise.acceleration, target - self.y[SPEED])
        while t > 0.0:
            found, event = self.piece(t)
            self.y = found.y[:, -1]
            self.airborne_time += found.t[-1] * self.airborne
            t -= found.t[-1]
            if event is not None:
                self.switch(event)

    def switch(self, kind):
        if kind == "knot":
            self.knot += 1
            self.y[POSITION] = self.knot * self.spacing
        elif kind == "arrival":
            self.y[SPEED], self.forward = self.target, 0.0
        elif kind == "tyre":
            self.airborne = not self.airborne
            self.liftoffs += self.airborne
        elif kind == "leave":
            self.side = 0.0
        else:
            self.side = 1.0 if kind == "top" else -1.0
            self.touches += 1

    @property
    def seen(self):
        """Travel, velocity, deflection, hub velocity, speed and distance, as the model's state has them."""
        travel, _, deflection, _, _, _ = self.parts(self.y)
        hub = self.y[HUB_RATE] if self.tyre is not None else 0.0
        return np.array([travel, self.y[BODY_RATE], deflection, hub, self.y[SPEED], self.y[POSITION]])


FIELDS = ("travel", "velocity", "deflection", "hub_velocity", "speed", "distance")


def seen(state):
    """What `Reference.seen` is compared with."""
    return np.array([float(state[name]) for name in FIELDS])


def drive_ticks(reference, suspensions, targets):
    """One row of `Reference.seen` per tick."""
    rows = []
    for suspension, target in zip(suspensions, targets, strict=True):
        reference.advance(TICK, suspension, target)
        rows.append(reference.seen)
    return np.array(rows)
