"""The aircraft: run time against error."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np
from mpmath import mp, mpf

from vr_envs.bench.accuracy.account import System
from vr_envs.bench.accuracy.autopilot_opponents import advance_in_steps, integrate
from vr_envs.bench.accuracy.autopilot_reference import DIGITS, SEEN, Flight
from vr_envs.bench.accuracy.episodes import driven, episode_loop
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
EXACT = Method("exact", "exact")
TEXTBOOK = Method("textbook engine", "textbook", "step", fixed_step=True)
EULER = Method("semi-implicit Euler", "fixed step", "step", fixed_step=True)
RK4 = Method("RK4", "fixed step", "step", fixed_step=True)
LOCATED = Method("RK4 from corner to corner", "located step", "step")
SCIPY = {name: Method(f"scipy {name}", "scipy", "tolerance") for name in ("RK45", "DOP853", "LSODA")}

SWEEPS = {EULER: (1, 10.0, 5), RK4: (4, 4.0, 8), LOCATED: (4, 2.0, 7)}  # order, ratio of steps, how many from 1 s on
STEPS = 20_000  # that one call of a compiled loop makes at least, so that the call itself costs nothing


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
    worst = dict.fromkeys((ALTITUDE.name, HEADING.name, TRACK.name), mpf(0))
    with mp.workdps(DIGITS):
        for row, true in zip(seen, reference, strict=True):
            off = dict(zip(SEEN, (mpf(float(a)) - b for a, b in zip(row, true, strict=True)), strict=True))
            found = abs(off["altitude"]), abs(2 * mp.sin(off["heading"] / 2)), mp.hypot(off["x"], off["z"])
            for name, error in zip(worst, found, strict=True):
                worst[name] = max(worst[name], error)
    return {m.name: float(worst[m.name]) for m in wanted}


def flown(method: str, tolerance: float, params: np.void, options: tuple[Any, ...]) -> np.ndarray:
    """What scipy makes of the episode, as `driven` gives it."""
    state, seen = start(), []
    for action in programme():
        integrate(state, action, params, options, method, tolerance)
        seen.append([state[name] for name in SEEN])
    return np.array(seen)


def runs_of(episode: str, quick: bool) -> Iterator[Run]:
    """All methods on one episode."""
    options, actions, first = EPISODES[episode][1], programme(), start()
    params = Params()
    judge = partial(judged, Flight(params, options, START).fly(actions), ERRORS[episode])
    span, packed = params.dt * len(actions), {name: pack(option) for name, option in options.items()}
    record, parts = pack(params), tuple(packed.get(name) for name in PARTS)

    def compiled(method: Method, value: float | None, loop: Any, arguments: tuple[Any, ...], share: float) -> Run:
        times = max(1, round(STEPS * share))
        work = partial(driven, loop, first, actions, len(SEEN), times, arguments)
        return Run(method, episode, value, work, span * times, judge)

    exact = episode_loop(advance, look)
    yield compiled(EXACT, None, exact, (record, *(packed.get(name) for name in OPTIONS)), 1.0 / len(actions))
    if episode == "lecture":
        for step in (1.0, 1e-1, 1e-2, 1e-3):
            engine = {**packed, "textbook": pack(Textbook(step=step))}
            yield compiled(TEXTBOOK, step, exact, (record, *(engine.get(name) for name in OPTIONS)), step / span)
    stepped = episode_loop(advance_in_steps, look)
    for method, (order, factor, count) in SWEEPS.items():
        if method is LOCATED and "lags" not in options:
            continue  # nothing has a corner
        for step in (factor**-k for k in range(count)):
            yield compiled(method, step, stepped, (record, *parts, order, step, method is LOCATED), step / span)
    for name, method in SCIPY.items():
        for tolerance in (1e-5, 1e-9) if quick else (1e-4, 1e-7, 1e-10, 1e-13):
            yield Run(method, episode, tolerance, partial(flown, name, tolerance, record, parts), span, judge)


def system(quick: bool, progress: bool) -> System:
    """Carry out all runs."""
    runs = [run for episode in EPISODES for run in runs_of(episode, quick)]
    points = measured(runs, 3, 0.005 if quick else 0.04, progress, "autopilot")
    told = {name: text for name, (text, _) in EPISODES.items()}
    return System("autopilot", "Aircraft", (ALTITUDE, HEADING, TRACK), told, points)
