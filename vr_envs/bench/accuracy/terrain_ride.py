"""The ride: run time against error."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from mpmath import mp, mpf

from vr_envs.bench.accuracy.account import System
from vr_envs.bench.accuracy.episodes import driven, episode_loop
from vr_envs.bench.accuracy.points import Measure, Method, Run, measured
from vr_envs.bench.accuracy.terrain_ride_opponents import advance_in_steps
from vr_envs.bench.accuracy.terrain_ride_outside import Episode, integrated, simulated
from vr_envs.bench.accuracy.terrain_ride_reference import DIGITS, Ride, weighted_rms
from vr_envs.envs.scene import resolve
from vr_envs.envs.terrain_ride import TASK
from vr_envs.envs.world import simulator_of
from vr_envs.models.jit import kernel
from vr_envs.models.record import dtype_of, pack
from vr_envs.models.ride_options import TICK, Textbook
from vr_envs.models.road import draw_road, start_road
from vr_envs.models.terrain import start_undulation
from vr_envs.models.terrain_ride import State, advance, rest

KERNEL_OPTIONS = (
    "undulation", "road", "profile", "bumps", "obstacle", "wheel", "tyre", "stop", "lag", "cruise", "textbook",
)  # fmt: skip
PARTS = ("undulation", "road", "tyre", "stop")  # that the opponents know
KEY = 5  # of the terrain
ROAD: dict[str, Any] = {"base": "lecture", "undulation": None, "damping": "relative"}


class Scenario(NamedTuple):
    """What happens, in which scene, how many actions, each for how many ticks, and how far the mass is lifted first."""

    told: str
    scene: dict[str, Any]
    actions: int
    hold: int
    lifted: float = 0.0


SCENARIOS: dict[str, Scenario] = {
    "lecture": Scenario(
        "the lecture's wheel over three sines for 2 s, new damping and modulus every 0.5 s; smooth in between",
        {"base": "lecture"},
        4,
        50,
    ),
    "ringing": Scenario(
        "the same on level ground with the least damping, lifted by 5 cm, for 10 s: 12 periods",
        {"base": "lecture", "undulation": {"amplitude": 0.0}, "damping_low": 1e-3},
        1,
        1000,
        0.05,
    ),
    "road with stops": Scenario(
        "a wheel that follows a road of class F for 2 s, with rubber stops that the mass meets and leaves",
        {**ROAD, "road": {"iso_class": "F", "spread": 0.0}, "stop": {"travel": 0.05}},
        4,
        50,
    ),
    "quarter car": Scenario(
        "a wheel with mass and tyre on a road of class E for 2 s; it leaves the ground and lands",
        {**ROAD, "road": {"iso_class": "E", "spread": 0.0}, "tyre": True},
        4,
        50,
    ),
}
TRAVEL = Measure("travel", "m", "of the spring, and with a tyre its deflection: largest over the ticks", 5e-16)
VELOCITY = Measure("velocity", "m/s", "of the mass: largest over the ticks", 1e-14)
WEIGHTED = Measure("weighted acceleration", "m/s^2", "r.m.s. over the episode in the band of Wk (ISO 2631-1)", 1e-13)
OFF = Measure("time off the ground", "s", "largest over the ticks: what lift-offs and landings are wrong by", 5e-15)
ENERGY = Measure("energy", "1", "drift, relative: largest over the ticks", 1e-14)
ERRORS = {
    "lecture": (TRAVEL, VELOCITY, WEIGHTED),
    "ringing": (ENERGY,),
    "road with stops": (TRAVEL, VELOCITY, WEIGHTED),
    "quarter car": (TRAVEL, VELOCITY, WEIGHTED, OFF),
}
EXACT = Method("exact", "exact")
TEXTBOOK = Method("textbook engine", "textbook", "step", fixed_step=True)
RIGID_BODY = Method("rigid_body engine", "rigid body", "step", fixed_step=True)
EULER = Method("semi-implicit Euler", "fixed step", "step", fixed_step=True)
RK4 = Method("RK4", "fixed step", "step", fixed_step=True)
LOCATED = Method("RK4 from contact to contact", "located step", "step")
SCIPY = {name: Method(f"scipy {name}", "scipy", "tolerance") for name in ("RK45", "DOP853", "LSODA")}
MUJOCO = {name: Method(f"MuJoCo {name}", "MuJoCo", "step", fixed_step=True) for name in ("Euler", "RK4")}
# order of the rule, steps per tick, of the compiled loops
SWEEPS = {
    EULER: (1, (1, 10, 100, 1000, 10_000)),
    RK4: (4, (1, 2, 4, 8, 16, 100, 1000)),
    LOCATED: (4, (1, 2, 4, 8, 16, 32)),
}
SMOOTH = (1, 2, 4, 8, 16)  # steps per tick of the Runge-Kutta rule where there is no contact; then rounding takes over
STEPS = 20_000  # that one call of a compiled loop makes at least, so that the call itself costs nothing


@kernel
def look(state, row):
    """Write what is compared."""
    row[0], row[1], row[2], row[3] = state.travel, state.velocity, state.deflection, state.airborne_time


def actions_of(scenario: Scenario) -> np.ndarray:
    """Positions of damping and modulus, one per tick, (ticks, 2)."""
    if scenario.actions == 1:
        return np.tile([-1.0, 0.0], (scenario.hold, 1))
    return np.repeat(np.random.default_rng(3).uniform(-0.5, 0.5, (scenario.actions, 2)), scenario.hold, axis=0)


def prepared(scenario: Scenario) -> tuple[Any, dict[str, Any], Episode]:
    """The scene, the records of its options, and the episode from its start."""
    scene = resolve(TASK, scenario.scene)
    params, records = scene.records()
    packed, actions = dict(zip(scene.options, records, strict=True)), actions_of(scenario)
    state = np.zeros(1, dtype_of(State))[0]
    state["key"], knots = KEY, None
    if packed["undulation"] is not None:
        start_undulation(state)
    if packed["road"] is not None:
        ahead = len(actions) * TICK * scene.params.speed / scene.options["road"].knot_spacing
        knots = np.zeros(math.ceil(ahead) + 2)
        draw_road(state.copy(), knots, packed["road"], None, None, None, None)
        start_road(state, packed["road"], None, None, None, None)
    rest(state, params, packed["tyre"])
    state["travel"] += scenario.lifted
    return scene, packed, Episode(params, *(packed[name] for name in PARTS), state, actions, knots)


class Judge:
    """Errors of what was seen of an episode, (ticks, 3 or 4), against the reference."""

    def __init__(self, name: str, scene: Any, episode: Episode) -> None:
        """Computes the reference."""
        self.wanted = ERRORS[name]
        ride = Ride(episode.start, scene.params, scene.options, episode.knots)
        with mp.workdps(DIGITS):
            self.w2 = [ride.suspension([mpf(float(a)) for a in action])[1] for action in episode.actions]
        self.seen = ride.drive(episode.actions)
        with mp.workdps(DIGITS):
            self.weighted = weighted_rms([mpf(0), *self.seen.velocity], mp.sqrt)
            self.energies = [self._energy(*x) for x in zip(self.seen.travel, self.seen.velocity, self.w2, strict=True)]

    @staticmethod
    def _energy(travel: Any, velocity: Any, w2: Any) -> Any:
        return (velocity * velocity + w2 * travel * travel) / 2

    def __call__(self, seen: np.ndarray) -> Mapping[str, float]:
        """As `Run.judge` gives them."""
        with mp.workdps(DIGITS):
            columns = [[mpf(float(x)) for x in column] for column in seen.T]
            apart = [
                float(max(abs(a - b) for a, b in zip(column, true, strict=True)))
                for column, true in zip(columns, self.seen, strict=False)
            ]
            energies = [self._energy(*x) for x in zip(*columns[:2], self.w2, strict=True)]
            drift = max(abs(a / b - 1) for a, b in zip(energies, self.energies, strict=True))
            weighted = weighted_rms([mpf(0), *columns[1]], mp.sqrt)
            found = {
                TRAVEL: max(apart[0], apart[2]),
                VELOCITY: apart[1],
                WEIGHTED: float(abs(weighted - self.weighted)),
                ENERGY: float(drift),
            }
        if len(apart) > 3:
            found[OFF] = apart[3]
        return {m.name: found[m] if math.isfinite(found[m]) else math.inf for m in self.wanted if m in found}


def chipmunk(scenario: Scenario, episode: Episode, step: float) -> np.ndarray:
    """What the engine `rigid_body` makes of an episode, (ticks, 4)."""
    scene = resolve(TASK, {**scenario.scene, "rigid_body": {"step": step}})
    simulator, state, rows = simulator_of(TASK.name, scene), episode.start.copy(), []
    for action in episode.actions:
        simulator.advance(state, action)
        rows.append([float(state[name]) for name in ("travel", "velocity", "deflection", "airborne_time")])
    return np.array(rows)


def runs_of(name: str, quick: bool) -> Iterator[Run]:
    """All methods on one episode."""
    scenario = SCENARIOS[name]
    scene, packed, episode = prepared(scenario)
    judge, ticks = Judge(name, scene, episode), len(episode.actions)
    span, params, parts = ticks * TICK, episode.params, tuple(packed[k] for k in PARTS)
    touching = scene.options["tyre"] is not None or scene.options["stop"] is not None

    def compiled(method: Method, each: int, loop: Any, arguments: tuple[Any, ...]) -> Run:
        """`each`: steps per tick."""
        times = max(1, round(STEPS / (each * ticks)))
        work = partial(driven, loop, episode.start, episode.actions, 4, times, arguments)
        return Run(method, name, TICK / each if method.setting else None, work, span * times, judge)

    exact, stepped = episode_loop(advance, look), episode_loop(advance_in_steps, look)
    yield compiled(EXACT, 1, exact, (params, *(packed.get(k) for k in KERNEL_OPTIONS)))
    if scene.params.damping == "absolute":
        for each in (1, 10, 100, 1000):
            engine = {**packed, "textbook": pack(Textbook(step=TICK / each))}
            yield compiled(TEXTBOOK, each, exact, (params, *(engine.get(k) for k in KERNEL_OPTIONS)))
    for method, (order, sweep) in SWEEPS.items():
        if method is LOCATED and not touching:
            continue
        for each in SMOOTH if method is RK4 and not touching else sweep[: 4 if quick else None]:
            yield compiled(method, each, stepped, (params, *parts, order, TICK / each, method is LOCATED))
    for kind, method in SCIPY.items():
        for tolerance in (1e-6,) if quick else (1e-5, 1e-12) if touching else (1e-4, 1e-8, 1e-12):
            yield Run(method, name, tolerance, partial(integrated, episode, kind, tolerance), span, judge)
    for kind, method in MUJOCO.items():
        for each in (1, 10) if quick else (1, 4, 16, 64):
            yield Run(method, name, TICK / each, partial(simulated, episode, kind, TICK / each), span, judge)
    for step in (1e-3,) if quick else (1e-3, 3e-4, 1e-4):
        yield Run(RIGID_BODY, name, step, partial(chipmunk, scenario, episode, step), span, judge)


def system(quick: bool, progress: bool) -> System:
    """Carry out all runs."""
    runs = [run for name in SCENARIOS for run in runs_of(name, quick)]
    measures = (TRAVEL, VELOCITY, WEIGHTED, OFF, ENERGY)
    points = measured(runs, 1 if quick else 3, 0.005 if quick else 0.03, progress, "terrain ride")
    return System("terrain_ride", "Ride", measures, {name: s.told for name, s in SCENARIOS.items()}, points)
