"""The ball on the bar: run time against error of the exact model and of what one would use instead.

Every method gets the same doubles: parameters, the bar's motions, the start. The exact model and the fixed steps run in
compiled loops over an episode, without Python in between; the others in Python's, since that is how they are driven.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np

from vr_envs.bench.accuracy import ball_on_bar_mujoco, ball_on_bar_scipy
from vr_envs.bench.accuracy.account import System
from vr_envs.bench.accuracy.ball_on_bar_chipmunk import direct, rigid_body
from vr_envs.bench.accuracy.ball_on_bar_episodes import MEASURES, Episode, Track, episodes
from vr_envs.bench.accuracy.ball_on_bar_loops import AT_END, CHORD, KEPT, ROOT, exact, fixed_step
from vr_envs.bench.accuracy.loops import times_for
from vr_envs.bench.accuracy.methods import EXACT, RIGID_BODY, SCIPY
from vr_envs.bench.accuracy.points import Method, Run, measured
from vr_envs.models.ball_on_bar import LOGGED

TEXTBOOK = Method("textbook (samples and bisection)", "textbook", "step")
PYMUNK = Method("pymunk", "pymunk", "step", fixed_step=True)
MUJOCO = Method("MuJoCo", "MuJoCo", "step", fixed_step=True)
STEPPED = {
    AT_END: Method("impact at the step's end", "fixed step", "step", fixed_step=True),
    CHORD: Method("step split by linear interpolation", "located step", "step"),
    ROOT: Method("step split at the root", "located step", "step"),
}

TOLERANCES = (1e-6, 1e-12)
SAMPLES = (8, 16, 64, 256)  # per period of z
STEPS = {  # s, the longest first
    AT_END: (1e-3, 1e-4, 1e-5, 1e-6),
    CHORD: (2e-3, 1e-3, 1e-4, 1e-5),
    ROOT: (4e-3, 2e-3, 1e-3, 1e-4),
}
SLOW_STEPS = (4e-4, 2e-4, 1e-4)  # s, of methods at some microseconds a step
NOTE = (
    "The exact kernel, the textbook's samples and the steps run in a compiled loop over the cycles; solve_ivp, MuJoCo "
    "and pymunk are driven from Python. Models are built, and where the bar is at every step is calculated for MuJoCo "
    "and pymunk, before the clock starts. MuJoCo has no restitution: it gets a soft contact, tuned to the restitution "
    f"of the scene, that lasts about {ball_on_bar_mujoco.STEPS:g} steps. solve_ivp integrates a parabola without error "
    "and would step over contacts, so its step is at most a twentieth of a cycle; that, not its tolerance, sets what "
    "it costs. Where a ball chatters, its impacts are without number, and the slow ones are not compared."
)
ROOM = 100_000  # impacts of an episode
TOO_FAST = 0.5  # of an episode's slowest compared impact: what a fixed step need not list


def compiled(episode: Episode, settings: dict[str, object], samples: int = 1) -> tuple[Callable[[], Track], float]:
    """The model's kernel over the episode, exact or with the settings of `textbook`; and simulated seconds.

    `samples`: that it takes of each base cycle.
    """
    params, options = episode.scene_of(settings).records()
    states, actions = episode.states(), np.ascontiguousarray(episode.actions)
    log, impacts, ends = np.empty((KEPT, len(LOGGED))), np.empty((ROOM, 3)), np.empty((len(actions), 4))
    times = times_for(samples * len(actions))

    def work() -> Track:
        count = exact(states, actions, params, options, log, impacts, ends, times)
        return Track(impacts[:count].copy(), ends.copy())

    return work, times * episode.seconds


def stepped(episode: Episode, location: int, steps: int) -> tuple[Callable[[], Track], float]:
    """The compiled fixed step with `steps` a base cycle; and simulated seconds."""
    impacts, ends = np.empty((ROOM, 3)), np.empty((len(episode.actions), 4))
    times = times_for(steps * len(episode.actions))

    def work() -> Track:
        count = fixed_step(
            episode.place, episode.motions, episode.params, steps, location, TOO_FAST * episode.slowest, impacts, ends,
            times,
        )  # fmt: skip
        return Track(impacts[:count].copy(), ends.copy())

    return work, times * episode.seconds


def runs_of(episode: Episode, quick: bool) -> Iterator[Run]:
    """Everything that is tried on one episode."""
    period, name, judge, seconds = float(episode.params["period"]), episode.name, episode.judge, episode.seconds

    def some(values: Sequence[float]) -> Sequence[float]:
        return values[:3:2] if quick else values

    yield Run(EXACT, name, None, *compiled(episode, {}), judge)
    for samples in map(int, some(SAMPLES)):
        work = compiled(episode, {"textbook": {"samples": samples}}, 2 * samples)
        yield Run(TEXTBOOK, name, 0.5 * period / samples, *work, judge)
    for location, method in STEPPED.items():
        for steps in (round(period / step) for step in some(STEPS[location])):
            yield Run(method, name, period / steps, *stepped(episode, location, steps), judge)
    for steps in (round(period / step) for step in some(SLOW_STEPS)):
        h = period / steps
        yield Run(RIGID_BODY, name, h, rigid_body(episode, h), seconds, judge)
        yield Run(PYMUNK, name, h, direct(episode, steps), seconds, judge)
        yield Run(MUJOCO, name, h, ball_on_bar_mujoco.simulated(episode, steps), seconds, judge)
    for solver, method in SCIPY.items():
        for tolerance in some(TOLERANCES):
            work = partial(ball_on_bar_scipy.simulate, episode, solver, tolerance)
            yield Run(method, name, tolerance, work, seconds, judge)


def system(quick: bool, progress: bool) -> System:
    """Carry out all runs."""
    chosen = episodes(5 if quick else 15)
    runs = [run for episode in chosen for run in runs_of(episode, quick)]
    repeats, seconds = (1, 0.005) if quick else (3, 0.01)
    points = measured(runs, repeats, seconds, progress, "ball on a bar")
    return System("ball_on_bar", "Ball on a bar", MEASURES, {e.name: e.text for e in chosen}, points, NOTE)
