"""The ride's episodes: scenes, actions and starts, where something jumps in them, and how a run is judged."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from mpmath import mp, mpf

from vr_envs.bench.accuracy.points import Measure
from vr_envs.bench.accuracy.terrain_ride_reference import DIGITS, Ride, weighted_rms
from vr_envs.envs.scene import Scene, resolve
from vr_envs.envs.terrain_ride import TASK
from vr_envs.models.record import dtype_of
from vr_envs.models.ride_options import TICK
from vr_envs.models.road import draw_road, start_road
from vr_envs.models.terrain import start_undulation, undulation_ahead
from vr_envs.models.terrain_ride import State, actuate, rest, suspension

SAME = 1e-9  # s: two instants closer than this are one
KEY = 5  # of the terrain
PARTS = ("undulation", "road", "tyre", "stop")  # options that these episodes have
SEEN = ("travel", "velocity", "deflection", "airborne_time")  # what a run gives, one column each, as far as it can

TRAVEL = Measure("travel", "m", "of the spring, and with a tyre its deflection: largest over the ticks", 5e-16)
VELOCITY = Measure("velocity", "m/s", "of the mass: largest over the ticks", 1e-14)
WEIGHTED = Measure("weighted acceleration", "m/s^2", "r.m.s. over the episode in the band of Wk (ISO 2631-1)", 1e-13)
OFF = Measure("time off the ground", "s", "largest over the ticks: what lift-offs and landings are wrong by", 5e-15)
ENERGY = Measure("relative energy drift", "", "largest over the ticks", 2e-14)
MEASURES = (TRAVEL, VELOCITY, WEIGHTED, OFF, ENERGY)


class Scenario(NamedTuple):
    """What happens, in which scene, judged by what, how many actions, each for how many ticks, and the mass' lift."""

    told: str
    scene: dict[str, Any]
    measures: tuple[Measure, ...]
    actions: int = 4
    hold: int = 50
    lifted: float = 0.0


_PLAIN: dict[str, Any] = {"base": "lecture", "metrics": None}
_ROAD: dict[str, Any] = {**_PLAIN, "undulation": None, "damping": "relative"}
SCENARIOS: dict[str, Scenario] = {
    "lecture": Scenario(
        "the lecture's wheel over three sines for 2 s, new damping and modulus every 0.5 s; smooth in between, so that "
        "a rule of order 4 keeps its order",
        _PLAIN,
        (TRAVEL, VELOCITY, WEIGHTED),
    ),
    "ringing": Scenario(
        "the same on level ground for 4 s with the least damping, released 5 cm above rest; smooth too",
        {**_PLAIN, "undulation": {"amplitude": 0.0}, "damping_low": 1e-3},
        (ENERGY,),
        actions=1,
        hold=400,
        lifted=0.05,
    ),
    "road with stops": Scenario(
        "a wheel that follows a road of class F for 2 s, with rubber stops that the mass meets and leaves: the force "
        "bends within a step",
        {**_ROAD, "road": {"iso_class": "F", "spread": 0.0}, "stop": {"travel": 0.05}},
        (TRAVEL, VELOCITY, WEIGHTED),
    ),
    "quarter car": Scenario(
        "a wheel with mass and tyre on a road of class E for 2 s; it leaves the ground and lands within a step",
        {**_ROAD, "road": {"iso_class": "E", "spread": 0.0}, "tyre": True},
        (TRAVEL, VELOCITY, WEIGHTED, OFF),
    ),
}


class Piece(NamedTuple):
    """From `begin` to `end` [s] nothing jumps but contacts.

    `gamma` [1/s] and `w2` [1/s^2] are held; a road is at the height `ground` [m] first, and climbs by `climb` [m/s].
    """

    begin: float
    end: float
    gamma: float
    w2: float
    ground: float
    climb: float

    @property
    def ticks(self) -> np.ndarray:
        """Numbers of the ticks that begin in it, from 0."""
        return np.arange(math.ceil((self.begin - SAME) / TICK), math.ceil((self.end - SAME) / TICK))


@dataclasses.dataclass(frozen=True)
class Episode:
    """A scene with its records, the first state, the actions (ticks, 2), and the heights of the road's knots [m]."""

    scene: Scene
    params: np.void
    records: dict[str, np.void | None]
    start: np.void
    actions: np.ndarray
    knots: np.ndarray | None

    @property
    def seconds(self) -> float:
        """Its length."""
        return len(self.actions) * TICK

    @property
    def parts(self) -> tuple[np.void | None, ...]:
        """The records of `PARTS`."""
        return tuple(self.records[name] for name in PARTS)

    @property
    def touching(self) -> bool:
        """Whether there are contacts that come and go."""
        return self.records["tyre"] is not None or self.records["stop"] is not None

    def pieces(self) -> Iterator[Piece]:
        """The parts in which nothing jumps but contacts, in order."""
        state, apart = self.start.copy(), math.inf
        changed = np.flatnonzero((np.diff(self.actions, axis=0) != 0.0).any(axis=1)) + 1
        corners = [0.0, *(changed * TICK), self.seconds]
        if self.knots is not None:
            apart = self.scene.options["road"].knot_spacing / self.scene.params.speed
            corners += list(np.arange(0.0, self.seconds, apart))
        corners.sort()
        corners = [c for c, after in zip(corners, [*corners[1:], math.inf], strict=True) if after - c > SAME]
        for begin, end in zip(corners, corners[1:], strict=False):
            actuate(state, self.actions[int((begin + SAME) / TICK)], None, None)
            gamma, w2, _ = suspension(state, self.params)
            ground = climb = 0.0
            if self.knots is not None:
                knot = int((begin + SAME) / apart)
                climb = float(self.knots[knot + 1] - self.knots[knot]) / apart
                ground = float(self.knots[knot]) + climb * (begin - knot * apart)
            yield Piece(begin, end, gamma, w2, ground, climb)

    def ground(self, piece: Piece, time: float) -> float:
        """Height [m] of the ground under the wheel at a time in a piece."""
        if self.knots is None:
            return undulation_ahead(self.start, self.scene.params.speed * time, self.records["undulation"])
        return piece.ground + piece.climb * (time - piece.begin)

    def first(self, ground: float) -> np.ndarray:
        """Height and velocity of the mass and of the hub at the start, on the ground there."""
        start = {name: float(self.start[name]) for name in ("travel", "velocity", "deflection", "hub_velocity")}
        hub = ground + start["deflection"]
        return np.array([hub + start["travel"], start["velocity"], hub, start["hub_velocity"]])

    def seen(self, y: np.ndarray, ground: float) -> tuple[float, float, float]:
        """Travel, velocity and deflection, of heights and velocities in the order of `first`."""
        hub = ground if self.records["tyre"] is None else y[2]
        return y[0] - hub, y[1], hub - ground


def episode_of(scenario: Scenario) -> Episode:
    """The episode from rest, or from where the mass has been lifted to."""
    scene = resolve(TASK, scenario.scene)
    params, options = scene.records()
    records, state, knots = dict(zip(scene.options, options, strict=True)), np.zeros(1, dtype_of(State))[0], None
    # the first of a single action is the least damping at the modulus in the middle
    positions = np.array([[-1.0, 0.0], *np.random.default_rng(3).uniform(-0.5, 0.5, (scenario.actions, 2))])
    actions = np.repeat(positions[:1] if scenario.actions == 1 else positions[1:], scenario.hold, axis=0)
    state["key"] = KEY
    if records["undulation"] is not None:
        start_undulation(state)
    if records["road"] is not None:
        spacing = scene.options["road"].knot_spacing
        knots = np.zeros(math.ceil(len(actions) * TICK * scene.params.speed / spacing) + 2)
        draw_road(state.copy(), knots, records["road"], None, None, None, None)
        start_road(state, records["road"], None, None, None, None)
    rest(state, params, records["tyre"])
    state["travel"] += scenario.lifted
    return Episode(scene, params, records, state, actions, knots)


def energy(travel: Any, velocity: Any, w2: Any) -> Any:
    """Energy of mass and spring over the mass [J/kg]."""
    return (velocity * velocity + w2 * travel * travel) / 2


class Judge:
    """Errors of what was seen of an episode, (ticks, 4 or fewer columns of `SEEN`), against the reference."""

    def __init__(self, scenario: Scenario, episode: Episode) -> None:
        """Computes the reference."""
        self.measures = scenario.measures
        ride = Ride(episode.start, episode.scene.params, episode.scene.options, episode.knots)
        self.true = ride.drive(episode.actions)
        with mp.workdps(DIGITS):
            self.w2 = [ride.suspension([mpf(float(a)) for a in action])[1] for action in episode.actions]
            self.weighted = weighted_rms([mpf(0), *self.true.velocity], mp.sqrt)

    def __call__(self, seen: np.ndarray) -> Mapping[str, float]:
        """As `Run.judge` gives them."""
        if not np.isfinite(seen).all():
            return {m.name: math.inf for m in self.measures if m is not OFF or seen.shape[1] == len(SEEN)}
        found: dict[Measure, Any] = {}
        with mp.workdps(DIGITS):
            columns = [[mpf(float(x)) for x in column] for column in seen.T]
            apart = [
                max(abs(a - b) for a, b in zip(column, true, strict=True))
                for column, true in zip(columns, self.true, strict=False)
            ]
            found[TRAVEL], found[VELOCITY] = max(apart[0], apart[2]), apart[1]
            if len(apart) == len(SEEN):
                found[OFF] = apart[3]
            if WEIGHTED in self.measures:
                found[WEIGHTED] = abs(weighted_rms([mpf(0), *columns[1]], mp.sqrt) - self.weighted)
            if ENERGY in self.measures:
                energies, true = (
                    [energy(*x) for x in zip(travel, velocity, self.w2, strict=True)]
                    for travel, velocity in (columns[:2], self.true[:2])
                )
                found[ENERGY] = max(abs(a / b - 1) for a, b in zip(energies, true, strict=True))
        return {m.name: float(found[m]) for m in self.measures if m in found}
