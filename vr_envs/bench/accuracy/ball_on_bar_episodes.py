"""The ball's episodes: scenes, actions and starts, what happens in them to 30 digits, and how a run is judged by that.

Time is kept as (base cycle, time in the cycle), so that the last digits of a late impact are not lost.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from functools import cached_property
from typing import Any

import mpmath as mp
import numpy as np

from vr_envs.bench.accuracy.ball_on_bar_reference import Reference
from vr_envs.bench.accuracy.points import Measure
from vr_envs.envs.ball_on_bar import TASK
from vr_envs.envs.scene import Scene, resolve
from vr_envs.models.drive import demanded
from vr_envs.models.record import dtype_of

TIME = Measure(
    "impact time",
    "s",
    "largest distance from an impact of the one list to the nearest of the other, run and reference",
    rounding=1e-16,
    astray=5e-3,
)
PLACE = Measure(
    "position",
    "m",
    "largest distance of the ball from its place in the reference, at the cycles' ends",
    rounding=1e-16,
    astray=2e-3,
)
GROWTH = Measure("growth rate", "1/s", "error of ln(x at the end / x at the start) / time", rounding=1e-15, astray=0.3)
ENERGY = Measure(
    "energy drift",
    "J/kg",
    "largest change of kinetic and potential energy, at the cycles' ends with the ball above the surface",
    rounding=1e-16,
    astray=0.05,
)
MEASURES = (TIME, PLACE, GROWTH, ENERGY)

WAVE = (0.4, 0.0, 0.5, 0.0, 0.0, 0.0)  # Bell's sink: x at 4 m/s^2, tilt at 50 rad/s^2
START = {"z": 0.006, "w": 0.0}


@dataclasses.dataclass(frozen=True)
class Track:
    """What a run says. `impacts`: (n, 3) base cycle, time in it (s), approach velocity (m/s, negative), in order.

    `ends`: (cycles, 4) x, z, u, w at the end of each base cycle, m and m/s.
    """

    impacts: np.ndarray
    ends: np.ndarray


@dataclasses.dataclass(frozen=True)
class Episode:
    """A scene, an action (`actions`, repeated or one a cycle) and a start, with the errors by which runs are judged.

    `slowest`: approach velocity (m/s) below which impacts are not compared: those of a chatter are without number.
    """

    name: str
    text: str
    changes: dict[str, Any]
    actions: np.ndarray
    start: dict[str, float]
    judged: tuple[Measure, ...]
    slowest: float = 0.0

    @cached_property
    def scene(self) -> Scene:
        """With the exact engine."""
        return self.scene_of({})

    def scene_of(self, settings: dict[str, Any]) -> Scene:
        """With the settings of an engine."""
        return resolve(TASK, {"scatter": None, **self.changes, **settings})

    @cached_property
    def params(self) -> np.void:
        """The record."""
        return self.scene.records()[0]

    @cached_property
    def motions(self) -> np.ndarray:
        """(cycles + 1, 6): the bar's motion before the episode, and that to which it goes in each cycle."""
        demands = [demanded(action, self.params) for action in self.actions]
        return np.array([demands[0], *demands])

    @property
    def seconds(self) -> float:
        """Simulated."""
        return len(self.actions) * float(self.params["period"])

    @property
    def place(self) -> tuple[float, float, float, float]:
        """x, z, u, w at the start, m and m/s."""
        x, z, u, w = (self.start.get(name, 0.0) for name in ("x", "z", "u", "w"))
        return x, z, u, w

    def states(self) -> np.ndarray:
        """(1,) record of the start."""
        state = np.zeros(1, dtype_of(TASK.state))
        state["motion"] = self.motions[0]
        for name, value in self.start.items():
            state[name] = value
        return state

    @cached_property
    def reference(self) -> Track:
        """From the independent simulation to more than 30 digits, rounded in the end."""
        reference = Reference(self.params, self.states()[0])
        impacts, ends = [], []
        for cycle, motion in enumerate(self.motions[1:]):
            before = len(reference.impacts)
            reference.cycle(motion.tolist())
            impacts += [(cycle, float(s), float(normal)) for s, _, _, normal in reference.impacts[before:]]
            ends.append([float(v) for v in (reference.x, reference.z, reference.u, reference.w)])
        return Track(np.array(impacts), np.array(ends))

    def judge(self, track: Track) -> dict[str, float]:
        """Errors by name of the measure; infinite where the ball is lost or not a number."""
        if not np.isfinite(track.ends).all():
            return {measure.name: math.inf for measure in self.judged}
        true, period = self.reference, float(self.params["period"])
        errors: dict[str, float] = {}
        if TIME in self.judged:
            errors[TIME.name] = max(
                apart(true.impacts, track.impacts, period, self.slowest),
                apart(track.impacts, true.impacts, period, 1.5 * self.slowest),
            )
        if PLACE in self.judged:
            errors[PLACE.name] = float(np.hypot(*(track.ends - true.ends)[:, :2].T).max())
        if GROWTH in self.judged:
            ratio = float(track.ends[-1, 0] / true.ends[-1, 0])
            errors[GROWTH.name] = abs(math.log(ratio)) / self.seconds if ratio > 0.0 else math.inf
        if ENERGY in self.judged:
            above = track.ends[track.ends[:, 1] > 0.0]
            energies = [energy(row, float(self.params["gravity"])) for row in (self.place, *above)]
            drifts = np.abs(np.subtract(energies[1:], energies[0]))
            errors[ENERGY.name] = float(drifts.max()) if len(drifts) else math.inf
        return errors


def energy(place: Sequence[float], gravity: float) -> float:
    """Kinetic and potential energy of a ball at x, z, u, w, J/kg."""
    _, z, u, w = place
    return gravity * z + 0.5 * (u * u + w * w)


def apart(some: np.ndarray, others: np.ndarray, period: float, slowest: float) -> float:
    """Largest time from an impact of `some`, faster than `slowest`, to the nearest of `others`; both as in `Track`."""
    fast = some[some[:, 2] < -slowest] if slowest else some
    if not len(fast):
        return 0.0
    if not len(others):
        return math.inf
    cycles = fast[:, None, 0] - others[None, :, 0]
    return float(np.abs(cycles * period + (fast[:, None, 1] - others[None, :, 1])).min(axis=1).max())


def period_one_start(
    acceleration: float, restitution: float, gravity: float = 9.81, frequency: float = 30.0
) -> dict[str, float]:
    """Where the ball of the stable period-one orbit is at the top of the bar's motion z = A sin(omega t + pi/2).

    From the closed form (Luck and Mehta 1993): cos(phase of the impact) = pi g (1 - alpha) / ((1 + alpha) Acc), and
    the ball leaves with g T / 2.
    """
    with mp.workdps(40):
        omega = 2 * mp.pi * frequency
        cos = mp.pi * gravity * (1 - mp.mpf(restitution)) / (1 + mp.mpf(restitution)) / acceleration
        flown = (mp.pi / 2 - mp.acos(cos)) / omega
        height = acceleration / omega**2 * mp.sqrt(1 - cos**2)
        leaving = mp.mpf(gravity) / frequency / 2
        return {
            "z": float(height + leaving * flown - gravity * flown**2 / 2),
            "w": float(leaving - gravity * flown),
        }


def varied(cycles: int, seed: int = 3) -> np.ndarray:
    """Another action every cycle, near Bell's sink."""
    return np.array(WAVE) + np.random.default_rng(seed).uniform(-0.2, 0.2, (cycles, 6))


def episodes(cycles: int = 15) -> list[Episode]:
    """All of them, of so many base cycles."""
    still = np.zeros((cycles, 6))
    on_orbit = period_one_start(8.0, 0.75)
    source = np.tile([WAVE[0], 0.0, -WAVE[2], 0.0, 0.0, 0.0], (cycles, 1))
    return [
        Episode(
            "period one",
            "a bar moves up and down at 30 Hz with 8 m/s^2, restitution 0.75: the stable orbit of one impact a period",
            {},
            np.zeros((2 * cycles, 6)),
            on_orbit,
            (TIME, PLACE),
        ),
        Episode(
            "chaotic",
            "the same bar at 20 m/s^2, restitution 0.856: errors grow about e-fold with each impact",
            {"restitution": 0.856, "z_acceleration": 20.0},
            still,
            {"z": 0.02, "w": 0.0},
            (TIME, PLACE),
        ),
        Episode(
            "chatter and rest",
            "the same bar at 15 m/s^2, restitution 0.3: in each period the ball chatters to rest and is released",
            {"restitution": 0.3, "z_acceleration": 15.0},
            still,
            START,
            (TIME, PLACE),
            slowest=0.05,
        ),
        Episode(
            "tilting bar, an action each cycle",
            "x, tilt and z move, to another motion in each cycle: what an agent does",
            {},
            varied(cycles),
            {**on_orbit, "x": 0.003},
            (TIME, PLACE),
        ),
        Episode(
            "source",
            "x and tilt move in the phase that drives the ball outwards (Bell, Fig 4.1)",
            {},
            source,
            {**on_orbit, "x": 0.003},
            (PLACE, GROWTH),
        ),
        Episode(
            "elastic",
            "restitution 1 over a bar that stands still: the energy is conserved",
            {"restitution": 1.0, "z_acceleration": 0.0},
            still,
            {"z": 0.01, "w": 0.0},
            (TIME, ENERGY),
        ),
    ]
