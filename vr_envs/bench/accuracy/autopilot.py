"""The aircraft: run time against error."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np
from mpmath import mp, mpf

from vr_envs.bench.accuracy.account import System
from vr_envs.bench.accuracy.autopilot_loops import advance_in_steps
from vr_envs.bench.accuracy.autopilot_reference import DIGITS, SEEN, Flight
from vr_envs.bench.accuracy.autopilot_scipy import integrated
from vr_envs.bench.accuracy.loops import driven, episode_loop, times_for
from vr_envs.bench.accuracy.methods import EULER, EXACT, RK4, SCIPY, TEXTBOOK
from vr_envs.bench.accuracy.points import Measure, Method, Run, measured
from vr_envs.models.autopilot import Params, State, advance
from vr_envs.models.autopilot_options import OPTIONS, Energy, Envelope, Lags, Shear, Textbook, Track, Wind
from vr_envs.models.jit import kernel
from vr_envs.models.record import dtype_of, pack

HOLD, BLOCKS = 4, 6  # s, for which an action is held, and how many there are
START = {"altitude": 3000.0, "speed": 150.0, "heading": 0.5}
PARTS = ("envelope", "energy", "lags", "wind", "shear")  # that the opponents know
EPISODES: dict[str, tuple[str, dict[str, Any]]] = {
    "lecture": (
        "the lecture's aircraft for 24 s, a new command every 4 s; altitude, airspeed and heading have constant rates, "
        "which every method but the lecture's own turn meets to rounding, so that the track alone is compared",
        {"track": Track()},
    ),
    "airliner": (
        "the same with rates that lag and are limited, an envelope, shared power, wind and shear, without gusts",
        {
            "envelope": Envelope(),
            "energy": Energy(),
            "lags": Lags(),
            "wind": Wind(),
            "shear": Shear(),
            "track": Track(),
        },
    ),
}
ALTITUDE = Measure("altitude", "m", "largest over the control instants", 2e-12)
HEADING = Measure("heading", "rad", "likewise, as a turn", 5e-16)
TRACK = Measure("track", "m", "largest distance over the ground at a control instant", 1e-11)
ERRORS = {"lecture": (TRACK,), "airliner": (ALTITUDE, HEADING, TRACK)}
LOCATED = Method("RK4 from corner to corner", "located step", "step")
# order of the rule, and steps [s]
SWEEPS = {
    EULER: (1, (1.0, 1e-1, 1e-2, 1e-3, 1e-4)),
    RK4: (4, tuple(4.0**-k for k in range(8))),
    LOCATED: (4, tuple(2.0**-k for k in range(7))),
}
SMOOTH = tuple(2.0**-k for k in range(5))  # of the Runge-Kutta rule where nothing lags; then rounding takes over
NOTE = (
    "A point under rate commands has no bodies, joints or contacts, so MuJoCo and pymunk have nothing to say about it. "
    "The exact kernel and the fixed steps run in a compiled loop over the control intervals, and all methods restart "
    "at these. solve_ivp and the Runge-Kutta rule from corner to corner are told when the limit of a rate's change "
    "ceases to act; other steps are not, and lose their order there."
)


@kernel
def look(state, row):
    """Write what is compared."""
    row[0], row[1], row[2], row[3], row[4] = state.altitude, state.speed, state.heading, state.x, state.z


def programme() -> np.ndarray:
    """Actions, one per control interval, (intervals, 3)."""
    return np.repeat(np.random.default_rng(1).uniform(-1.0, 1.0, (BLOCKS, 3)), HOLD, axis=0)


def start() -> np.void:
    """The record in which every episode starts."""
    state = np.zeros(1, dtype_of(State))[0]
    for name, value in START.items():
        state[name] = value
    return state


def judged(reference: list[list[Any]], wanted: tuple[Measure, ...], seen: np.ndarray) -> Mapping[str, float]:
    """Errors of what was `seen`, (intervals, 5), as `Run.judge` gives them."""
    if not np.isfinite(seen).all():
        return {m.name: math.inf for m in wanted}
    with mp.workdps(DIGITS):
        altitude, _, heading, x, z = (
            [mpf(float(a)) - b for a, b in zip(column, true, strict=True)]
            for column, true in zip(seen.T, zip(*reference, strict=True), strict=True)
        )
        found = {
            ALTITUDE: max(map(abs, altitude)),
            HEADING: max(abs(2 * mp.sin(turn / 2)) for turn in heading),
            TRACK: max(mp.hypot(*off) for off in zip(x, z, strict=True)),
        }
    return {m.name: float(found[m]) for m in wanted}


def runs_of(episode: str, quick: bool) -> Iterator[Run]:
    """All methods on one episode."""
    options, actions, first = EPISODES[episode][1], programme(), start()
    params = Params()
    judge = partial(judged, Flight(params, options, START).fly(actions), ERRORS[episode])
    span, packed = params.dt * len(actions), {name: pack(option) for name, option in options.items()}
    record, parts = pack(params), tuple(packed.get(name) for name in PARTS)

    def compiled(method: Method, value: float | None, loop: Any, arguments: tuple[Any, ...], each: int = 1) -> Run:
        """`each`: steps per control interval."""
        times = times_for(each * len(actions))
        work = partial(driven, loop, first, actions, len(SEEN), times, arguments)
        return Run(method, episode, value, work, span * times, judge)

    exact = episode_loop(advance, look)
    yield compiled(EXACT, None, exact, (record, *(packed.get(name) for name in OPTIONS)))
    if episode == "lecture":
        for step in (1.0, 1e-1, 1e-2, 1e-3):
            engine = {**packed, "textbook": pack(Textbook(step=step))}
            arguments = record, *(engine.get(name) for name in OPTIONS)
            yield compiled(TEXTBOOK, step, exact, arguments, round(params.dt / step))
    stepped = episode_loop(advance_in_steps, look)
    for method, (order, sweep) in SWEEPS.items():
        if "lags" not in options:
            if method is LOCATED:
                continue  # nothing has a corner
            sweep = SMOOTH if method is RK4 else sweep
        for step in sweep:
            arguments = record, *parts, order, step, method is LOCATED
            yield compiled(method, step, stepped, arguments, round(params.dt / step))
    for name, method in SCIPY.items():
        for tolerance in (1e-5, 1e-9) if quick else (1e-4, 1e-7, 1e-10, 1e-13):
            work = integrated(first, actions, record, parts, name, tolerance)
            yield Run(method, episode, tolerance, work, span, judge)


def system(quick: bool, progress: bool) -> System:
    """Carry out all runs."""
    runs = [run for episode in EPISODES for run in runs_of(episode, quick)]
    points = measured(runs, 1 if quick else 3, 0.005 if quick else 0.01, progress, "autopilot")
    told = {name: text for name, (text, _) in EPISODES.items()}
    return System("autopilot", "Aircraft", (ALTITUDE, HEADING, TRACK), told, points, NOTE, Params().dt)
