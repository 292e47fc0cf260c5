"""The ride: run time against error."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from vr_envs.bench.accuracy.account import System
from vr_envs.bench.accuracy.loops import driven, episode_loop, times_for
from vr_envs.bench.accuracy.methods import EULER, EXACT, MUJOCO, RIGID_BODY, RK4, SCIPY, TEXTBOOK
from vr_envs.bench.accuracy.points import Method, Run, measured
from vr_envs.bench.accuracy.terrain_ride_episodes import MEASURES, SCENARIOS, SEEN, Episode, Judge, Scenario, episode_of
from vr_envs.bench.accuracy.terrain_ride_loops import advance_in_steps
from vr_envs.bench.accuracy.terrain_ride_mujoco import simulated
from vr_envs.bench.accuracy.terrain_ride_scipy import integrated
from vr_envs.envs.scene import resolve
from vr_envs.envs.terrain_ride import TASK, advance
from vr_envs.envs.world import simulator_of
from vr_envs.models.jit import kernel
from vr_envs.models.record import pack
from vr_envs.models.ride_options import TICK, Textbook

LOCATED = Method("RK4 from contact to contact", "located step", "step")
# order of the rule, and steps per tick
SWEEPS = {
    EULER: (1, (1, 10, 100, 1000, 10_000)),
    RK4: (4, (1, 2, 4, 8, 16, 100, 1000)),
    LOCATED: (4, (1, 2, 4, 8, 16, 32, 64)),
}
SMOOTH = (1, 2, 4, 8, 16)  # steps per tick of the Runge-Kutta rule where there is no contact; then rounding takes over
NOTE = (
    "The exact kernel and the fixed steps run in a compiled loop over the ticks of 10 ms; they draw the road and "
    "weight the acceleration by the same kernels, so that their costs differ by what moves the vehicle. All methods "
    "restart where the ground's slope or the suspension jumps. solve_ivp and the Runge-Kutta rule from contact to "
    "contact look for contacts within a step; other steps do not, and lose their order there. MuJoCo is driven "
    "directly, with tendons for springs, stops and tyre; it knows the ground as a body that goes on at an even rate "
    "within a step, which on a road it does, and over sines it does not: there its Runge-Kutta rule is of order 2. "
    "pymunk driven directly is what rigid_body is. Models are built, and the ground that MuJoCo is told is calculated, "
    "before the clock starts."
)


@kernel
def look(state, row):
    """Write what is compared, in the order of `SEEN`."""
    row[0], row[1], row[2], row[3] = state.travel, state.velocity, state.deflection, state.airborne_time


def chipmunk(scenario: Scenario, episode: Episode, step: float) -> Callable[[], np.ndarray]:
    """Work that drives an episode with the engine `rigid_body` and returns what is seen, (ticks, 4)."""
    simulator = simulator_of(TASK.name, resolve(TASK, {**scenario.scene, "rigid_body": {"step": step}}))

    def work() -> np.ndarray:
        state, rows = episode.start.copy(), []
        for action in episode.actions:
            simulator.advance(state, action)
            rows.append([float(state[name]) for name in SEEN])
        return np.array(rows)

    return work


def runs_of(name: str, quick: bool) -> Iterator[Run]:
    """All methods on one episode."""
    scenario = SCENARIOS[name]
    episode = episode_of(scenario)
    judge, ticks, params = Judge(scenario, episode), len(episode.actions), episode.params

    def run(method: Method, value: float, work: Any) -> Run:
        return Run(method, name, value, work, episode.seconds, judge)

    def compiled(method: Method, each: int, loop: Any, arguments: tuple[Any, ...]) -> Run:
        """`each`: steps per tick."""
        times = times_for(each * ticks)
        work = partial(driven, loop, episode.start, episode.actions, len(SEEN), times, arguments)
        return Run(method, name, TICK / each if method.setting else None, work, episode.seconds * times, judge)

    exact, stepped = episode_loop(advance, look), episode_loop(advance_in_steps, look)
    yield compiled(EXACT, 1, exact, (params, *episode.records.values()))
    if episode.scene.params.damping == "absolute":
        for each in (1, 10, 100, 1000):
            records = {**episode.records, "textbook": pack(Textbook(step=TICK / each))}
            yield compiled(TEXTBOOK, each, exact, (params, *records.values()))
    for method, (order, sweep) in SWEEPS.items():
        if method is RK4 and not episode.touching:
            sweep = SMOOTH
        if method is not LOCATED or episode.touching:
            for each in sweep:
                arguments = (params, *episode.parts, order, TICK / each, method is LOCATED)
                yield compiled(method, each, stepped, arguments)
    for kind, method in SCIPY.items():
        for tolerance in (1e-6,) if quick else (1e-5, 1e-9, 1e-12):
            yield run(method, tolerance, integrated(episode, kind, tolerance))
    for kind, method in MUJOCO.items():
        for each in (1, 10) if quick else (1, 4, 16, 64):
            yield run(method, TICK / each, simulated(episode, kind, TICK / each))
    for step in (1e-3,) if quick else (1e-3, 5e-4, 2.5e-4):
        yield run(RIGID_BODY, step, chipmunk(scenario, episode, step))


def system(quick: bool, progress: bool) -> System:
    """Carry out all runs."""
    runs = [run for name in SCENARIOS for run in runs_of(name, quick)]
    points = measured(runs, 1 if quick else 3, 0.005 if quick else 0.01, progress, "terrain ride")
    told = {name: scenario.told for name, scenario in SCENARIOS.items()}
    return System("terrain_ride", "Ride", MEASURES, told, points, NOTE, TICK)
