"""The one simulation of the ball on the bar that notebooks and experiments use.

    from vr_envs.experiments.simulation import ball, bar_motion, scan, simulate
    from vr_envs.models.ball_on_bar import Params

    params = Params(frequency=15.0, restitution=0.68)      # x and tilt at 15 Hz, z at 30 Hz
    motion = bar_motion(params, z=10.4)                    # peak accelerations and phases -> six phasors
    trace = simulate(params, motion, ball(motion, z=0.002), cycles=15, sample_rate=500.0)
    trace.impacts["phase"], trace.apexes["z"]               # the columns: see `trace.py`
    pyplot.plot(trace.seconds(trace.samples), trace.samples["z"])

What the bar or the ball has besides is an option (`vr_envs.models.ball_options`), by name:

    simulate(params, motion, start, cycles=200, options={"spin": Spin(), "curve": Curve(curvature=10.0)})

A bifurcation diagram is a scan over motions, each from where the ball was at the one before:

    sizes = numpy.linspace(8.0, 14.0, 300)
    motions = numpy.array([bar_motion(params, z=a) for a in sizes])
    impacts, counts, _ = scan(params, motions, trace.final, skip=400, keep=16, follow=True)
    pyplot.plot(sizes, impacts["phase"], ",")               # rows with counts < 16: the ball came to rest

SI units; frame and signs: `models/bar.py`. Time is kept as (cycle, time in the cycle), never as one growing number.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from vr_envs.experiments.simulation_kernels import IMPACT, ROOM, SAMPLE, lowest_gap, run_intervals, run_scan
from vr_envs.experiments.trace import Trace
from vr_envs.models.ball_on_bar import LOGGED, MAX_EVENTS, STEEPEST, Params, State
from vr_envs.models.ball_options import OPTIONS
from vr_envs.models.record import checked, dtype_of, pack

DEEPEST = -1e-9  # m, gap under a start: rounding of a start on the surface is less


class SimulationError(RuntimeError):
    """A cycle needed more than `MAX_EVENTS` events, a search for a contact did not end, or the bar stands upright."""


def bar_motion(
    params: Params,
    *,
    x: float | np.ndarray = 0.0,
    x_phase: float | np.ndarray = math.pi / 2.0,
    tilt: float | np.ndarray = 0.0,
    tilt_phase: float | np.ndarray = 0.0,
    z: float | np.ndarray = 0.0,
    z_phase: float | np.ndarray = math.pi / 2.0,
) -> np.ndarray:
    """The six phasors of x = A sin(omega t + x_phase), tilt alike, z = A sin(2 omega t + z_phase).

    Arrays of one shape (n,) give n motions.

    Args:
        params: gives omega.
        x: peak acceleration A omega^2, m/s^2.
        x_phase: rad; the default is Bell's (section IV).
        tilt: peak acceleration, rad/s^2.
        tilt_phase: rad; +pi/2 is Bell's sink.
        z: peak acceleration A (2 omega)^2, m/s^2.
        z_phase: rad; the default is Bell's.

    Returns:
        (6,) or (n, 6): x_cos, x_sin, tilt_cos, tilt_sin, z_cos, z_sin in m, rad, m.
    """
    w = params.omega
    parts = [(x / w**2, x_phase), (tilt / w**2, tilt_phase), (z / (2.0 * w) ** 2, z_phase)]
    columns = [part for size, phase in parts for part in (size * np.sin(phase), size * np.cos(phase))]
    motion = np.stack(np.broadcast_arrays(*columns), axis=-1)
    if not np.isfinite(motion).all():
        raise ValueError(
            f"x, tilt, z and their phases are {x, x_phase, tilt, tilt_phase, z, z_phase}; give finite ones"
        )
    return motion


def ball(
    motion: np.ndarray,
    *,
    x: float = 0.0,
    z: float = 0.0,
    u: float = 0.0,
    w: float = 0.0,
    spin: float = 0.0,
    key: int = 0,
) -> np.void:
    """A ball in flight at the start of a base cycle, over a bar that is already in `motion`.

    Args:
        motion: (6,) phasors of the bar, see `bar_motion`.
        x, z: place, m, from the bar's mean position.
        u, w: velocity of x and z, m/s.
        spin: radius times spin about +y, m/s.
        key: of the scatter: any integer in [0, 2^64).

    Returns:
        A record of `State`; a record of another run (`Trace.final`) serves as well.
    """
    numbers = {"x": x, "z": z, "u": u, "w": w, "spin": spin}
    for name, value in numbers.items():
        if not math.isfinite(value):
            raise ValueError(f"{name} = {value!r} is not allowed; give a finite number")
    if not isinstance(key, int | np.integer) or not 0 <= key < 2**64:
        raise ValueError(f"key = {key!r} is not allowed; give an integer in [0, 2^64)")
    return pack(State(key=key, motion=_motions(motion, None), **numbers))  # type: ignore[arg-type]


def simulate(
    params: Params,
    motion: np.ndarray,
    start: np.void | np.ndarray,
    cycles: int,
    options: Mapping[str, Any] | None = None,
    sample_rate: float = 0.0,
) -> Trace:
    """Run the ball over `cycles` base cycles.

    Args:
        params: see `vr_envs.models.ball_on_bar.Params`.
        motion: (6,) phasors of the bar, or one row for each control interval of `params.hold` base cycles: (cycles, 6),
            or (2 cycles, 6) if it is 0.5. Where the motion differs from that of the interval before, or of `start`, the
            bar blends into it as `params.blend` says.
        start: a record of `State`, see `ball`, or an array of one; not changed.
        cycles: how many; a lost ball ends the run earlier.
        options: name -> record of the class that `vr_envs.models.ball_options.OPTIONS` gives for it.
        sample_rate: Hz; places of ball and bar at multiples of its period. 0: none.

    Raises:
        ValueError: an argument of the wrong type, shape, size or range; the message names it and what is allowed.
        SimulationError: see there.
    """
    record, records = _records(params, options)
    if not isinstance(cycles, int | np.integer) or cycles < 1:
        raise ValueError(f"cycles = {cycles!r} is not allowed; give a whole number of at least 1")
    if not (math.isfinite(sample_rate) and sample_rate >= 0.0):
        raise ValueError(f"sample_rate = {sample_rate!r} is not allowed; give 0 (none) or a frequency in Hz")
    intervals = round(int(cycles) / params.hold)
    motions = np.broadcast_to(_motions(motion, intervals), (intervals, 6))
    state = _states(start, 1, record, records)
    ratio = params.frequency / sample_rate if sample_rate else 0.0
    log = np.empty((ROOM, len(LOGGED)))
    impacts, samples, done = [], [], 0
    while done < intervals and not state["lost"][0]:
        coming = min(intervals - done, 4096)
        hits = np.empty(ROOM + 16 * coming, IMPACT)
        seen = np.empty(math.ceil(coming / ratio) + 2 if sample_rate else 0, SAMPLE)
        n, n_hits, n_seen = run_intervals(state, motions[done : done + coming], record, records, log, hits, seen, ratio)
        impacts.append(hits[:n_hits].copy())
        samples.append(seen[:n_seen].copy())
        done += n
        _raise_fault(state)
    return Trace(params, np.concatenate(impacts), np.concatenate(samples), state[0].copy())


def scan(
    params: Params,
    motions: np.ndarray,
    starts: np.void | np.ndarray,
    skip: int,
    keep: int,
    options: Mapping[str, Any] | None = None,
    follow: bool = False,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Many runs in one compiled loop: what the ball does after `skip` cycles, for each motion.

    Args:
        params: see `simulate`.
        motions: (n, 6), one constant motion per run; (6,) if only the starts differ.
        starts: one record of `State` for all runs, or (n,) one for each, as from `starts = np.repeat(ball(motion), n)`
            and then `starts["z"] = ...`; not changed.
        skip: control intervals that each run takes before its impacts are kept.
        keep: impacts to keep per run; a run ends after `PATIENCE * keep` intervals more at the latest
            (`simulation_kernels.py`).
        options: see `simulate`.
        follow: each run starts from the end of the one before (a quasi-static sweep); the first from `starts`.

    Returns:
        impacts (n, keep) with the columns of `Trace.impacts`, counts (n,) how many of each row are filled (the others
        are zero: the ball came to rest for good, or was lost), final states (n,).

    Raises:
        ValueError: as in `simulate`.
        SimulationError: see there.
    """
    record, records = _records(params, options)
    for name, value, low in (("skip", skip, 0), ("keep", keep, 1)):
        if not isinstance(value, int | np.integer) or value < low:
            raise ValueError(f"{name} = {value!r} is not allowed; give a whole number of at least {low}")
    rows = np.atleast_2d(_motions(motions, None))
    n = max(len(rows), np.size(starts))
    motions = np.ascontiguousarray(np.broadcast_to(rows, (n, 6))) if len(rows) == 1 else rows
    states = _states(starts, n, record, records)
    if len(motions) != n:
        raise ValueError(f"{len(motions)} motions and {n} starts; give one of either, or as many")
    kept, counts = np.zeros((n, keep), IMPACT), np.zeros(n, np.int64)
    log = np.empty((ROOM, len(LOGGED)))
    run_scan(states, motions, record, records, log, int(skip), kept, counts, bool(follow))
    _raise_fault(states)
    return kept, counts, states


def _records(params: Params, options: Mapping[str, Any] | None) -> tuple[np.void, tuple[np.void | None, ...]]:
    """What kernels take: the checked record of the parameters, and those of the options in kernel order."""
    if not isinstance(params, Params):
        raise ValueError(f"params = {params!r} is not allowed; give a vr_envs.models.ball_on_bar.Params")
    given = dict(options or {})
    for name, option in given.items():
        if name not in OPTIONS:
            raise ValueError(f"there is no option {name!r}; choose among {', '.join(OPTIONS)}")
        if option is not None and not isinstance(option, OPTIONS[name]):
            raise ValueError(
                f"option {name!r} = {option!r}; give a vr_envs.models.ball_options.{OPTIONS[name].__name__}"
            )
        if option is not None:
            checked(OPTIONS[name], dataclasses.asdict(option), f"{name}.")
    checked(Params, dataclasses.asdict(params), "params.")
    if params.hold not in (0.5, 1.0):
        raise ValueError(
            f"params.hold = {params.hold:g} is not allowed here; give 1 or 0.5, and a motion for each interval"
        )
    if params.blend > params.hold:
        raise ValueError(
            f"params.blend = {params.blend:g} is longer than params.hold = {params.hold:g}; give at most that"
        )
    records = (given.get(name) for name in OPTIONS)
    return pack(params), tuple(None if option is None else pack(option) for option in records)


def _motions(motion: Any, cycles: int | None) -> np.ndarray:
    """`motion` as a checked float array (6,) or (cycles or any, 6)."""
    array = np.ascontiguousarray(motion, float)
    if array.shape != (6,) and (array.ndim != 2 or array.shape[1] != 6 or cycles not in (None, len(array))):
        rows = "n" if cycles is None else cycles
        raise ValueError(f"motion has shape {array.shape}; give six phasors (6,) or ({rows}, 6), see bar_motion")
    if not np.isfinite(array).all():
        raise ValueError("motion has entries that are not finite")
    return array


def _states(starts: Any, n: int, params: np.void, options: tuple[np.void | None, ...]) -> np.ndarray:
    """(n,) own copies of the start records, none of them inside the bar."""
    if getattr(starts, "dtype", None) != dtype_of(State) or np.size(starts) not in (1, n):
        raise ValueError(
            f"start = {starts!r}; give a record made by ball() or the final state of a run, or {n} of them"
        )
    states = np.array(np.broadcast_to(np.ravel(starts), n))
    gap = lowest_gap(states, params, options)
    if not gap >= DEEPEST:
        raise ValueError(f"start: a ball lies {-gap:.3g} m under the bar's surface; give it a higher z, see ball()")
    return states


def _raise_fault(states: np.ndarray) -> None:
    if states["fault"].any():
        raise SimulationError(
            f"{np.count_nonzero(states['fault'])} of {len(states)} runs: a cycle needed more than {MAX_EVENTS} "
            "events, a search did not end, or the tilt exceeds "
            f"{STEEPEST:g} rad; a restitution further from 1 or a smaller motion makes shorter work"
        )
