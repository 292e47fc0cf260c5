"""The one simulation of the ball on the bar that notebooks and experiments use.

    from vr_envs.experiments.simulation import ball, bar_motion, simulate
    from vr_envs.models.ball_on_bar import Params

    params = Params(frequency=15.0, restitution=0.68)      # x and tilt at 15 Hz, z at 30 Hz
    motion = bar_motion(params, z=10.4)                    # peak accelerations and phases -> six phasors
    trace = simulate(params, motion, ball(motion, z=0.002), cycles=15, sample_rate=500.0)
    trace.impacts["phase"], trace.apexes["z"], trace.samples["z"]

SI units; frame and signs: `models/bar.py`. Time is kept as (cycle, time in the cycle), never as one growing number.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from vr_envs.models.ball_on_bar import LOGGED, MAX_EVENTS, OPTIONS, Params, State, cycle, piece_at
from vr_envs.models.bar import frame_at
from vr_envs.models.jit import kernel
from vr_envs.models.record import checked, dtype_of, pack

# columns of the model's log of impacts
_TIME, _X, _Z, _NORMAL_IN, _TANGENT_IN, _NORMAL_OUT, _TANGENT_OUT = (
    LOGGED.index(name) for name in ("time", "x", "z", "normal_in", "tangent_in", "normal_out", "tangent_out")
)

PATIENCE = 8  # cycles per impact that a scan waits for

IMPACT = np.dtype(
    [
        ("cycle", "i8"),  # base cycle, counted from the start of the first run
        ("time", "f8"),  # s, in the cycle
        ("phase", "f8"),  # rad in [0, 2 pi): the bar's z is A sin(phase)
        ("x", "f8"),  # m, ball
        ("z", "f8"),
        ("u_out", "f8"),  # m/s, velocity of the ball's centre after the impact
        ("w_out", "f8"),
        ("normal_in", "f8"),  # m/s, relative to the bar's material, along its normal and tangent: approach, departure
        ("tangent_in", "f8"),
        ("normal_out", "f8"),
        ("tangent_out", "f8"),
    ]
)
"""One impact."""

SAMPLE = np.dtype(
    [
        ("cycle", "i8"),
        ("time", "f8"),  # s, in the cycle
        ("x", "f8"),  # m, ball
        ("z", "f8"),
        ("bar_x", "f8"),  # m
        ("bar_tilt", "f8"),  # rad
        ("bar_z", "f8"),  # m
    ]
)
"""Where ball and bar are at one instant."""

APEX = np.dtype([("cycle", "i8"), ("time", "f8"), ("x", "f8"), ("z", "f8")])
"""Highest point of a flight between two impacts."""


class SimulationError(RuntimeError):
    """A cycle needed more than `MAX_EVENTS` events, or a search for a contact did not end."""


@kernel
def _turned(z, rate, w):
    """Phase in [0, 2 pi) of A sin(phase), from its value and rate."""
    phase = math.atan2(w * z, rate)
    return phase if phase >= 0.0 else phase + 2.0 * math.pi


@kernel
def _store(impact, row, steps, old, new, params):
    """One row of the model's log as an `IMPACT`; the bar went from the motion `old` to `new` in that cycle."""
    frame = frame_at(piece_at(old, new, row[_TIME], params), row[_TIME])
    reach = row[_X] - frame.x[0]
    normal, tangent = row[_NORMAL_OUT], row[_TANGENT_OUT]
    impact.cycle, impact.time = steps, row[_TIME]
    impact.phase = _turned(frame.z[0], frame.z[1], 2.0 * params.omega)
    impact.x, impact.z = row[_X], row[_Z]
    # the bar's material moves with the centre's velocity + tilt rate y x r
    impact.u_out = frame.x[1] + frame.tilt[1] * (row[_Z] - frame.z[0]) + normal * frame.sin + tangent * frame.cos
    impact.w_out = frame.z[1] - frame.tilt[1] * reach + normal * frame.cos - tangent * frame.sin
    impact.normal_in, impact.tangent_in = row[_NORMAL_IN], row[_TANGENT_IN]
    impact.normal_out, impact.tangent_out = normal, tangent


@kernel
def _phasors(motion):
    return motion[0], motion[1], motion[2], motion[3], motion[4], motion[5]


@kernel
def _sample(state, spare, new, params, options, first, ratio, samples, filled):
    """Ball and bar at the sampling instants of the coming cycle; returns the next instant's number and row.

    `ratio` is cycles per sample; the cycle is run again up to each instant.
    """
    old = _phasors(state[0].motion)
    while first * ratio < state[0].steps + 1:
        s = max(0.0, first * ratio - state[0].steps) * params.period
        spare[0] = state[0]
        cycle(spare[0], new, params, *options, None, s)
        frame = frame_at(piece_at(old, new, s, params), s)
        row = samples[filled]
        row.cycle, row.time, row.x, row.z = state[0].steps, s, spare[0].x, spare[0].z
        row.bar_x, row.bar_tilt, row.bar_z = frame.x[0], frame.tilt[0], frame.z[0]
        first += 1
        filled += 1
    return first, filled


@kernel
def _run(state, motions, params, options, log, impacts, samples, ratio):
    """Run one cycle per row of `motions` while there is room for its impacts: (cycles, impacts, samples) done."""
    hits, seen, number = 0, 0, 0
    spare = state.copy()
    if ratio > 0.0:
        number = int(math.ceil(state[0].steps / ratio - 1e-9))
    for k in range(motions.shape[0]):
        if state[0].lost or state[0].fault or hits + MAX_EVENTS > impacts.shape[0]:
            return k, hits, seen
        old, new = _phasors(state[0].motion), _phasors(motions[k])
        if ratio > 0.0:
            number, seen = _sample(state, spare, new, params, options, number, ratio, samples, seen)
        before = state[0].impacts
        cycle(state[0], new, params, *options, log)
        for i in range(before, state[0].impacts):
            _store(impacts[hits], log[i % log.shape[0]], state[0].steps, old, new, params)
            hits += 1
        state[0].steps += 1
    return motions.shape[0], hits, seen


@kernel
def _scan(states, motions, params, options, log, skip, kept, counts, follow):
    """For each motion: `skip` cycles, then cycles until a row of `kept` is full, or the ball must be at rest."""
    for j in range(motions.shape[0]):
        if follow and j > 0:
            states[j] = states[j - 1]
        state, new = states[j], _phasors(motions[j])
        for _ in range(skip):
            cycle(state, new, params, *options, log)
            state.steps += 1
        for _ in range(PATIENCE * kept.shape[1]):
            old = _phasors(state.motion)
            before = state.impacts
            cycle(state, new, params, *options, log)
            for i in range(before, state.impacts):
                if counts[j] < kept.shape[1]:
                    _store(kept[j, counts[j]], log[i % log.shape[0]], state.steps, old, new, params)
                    counts[j] += 1
            state.steps += 1
            if counts[j] == kept.shape[1] or state.lost or state.fault:
                break


def flight_times(impacts: np.ndarray, params: Params) -> np.ndarray:
    """Times (s) from each impact to the next along the last axis, rests included; one shorter than `impacts`."""
    return np.diff(impacts["cycle"]) * params.period + np.diff(impacts["time"])


def free_flights(impacts: np.ndarray, params: Params) -> np.ndarray:
    """Whether the flight that impact i began ends at impact i + 1, along the last axis; else the ball rested."""
    first, second = impacts[..., :-1], impacts[..., 1:]
    t = flight_times(impacts, params)
    reached = first["z"] + (first["w_out"] - 0.5 * params.gravity * t) * t
    return np.abs(reached - second["z"]) <= 1e-9 * (np.abs(first["w_out"] * t) + np.abs(first["z"]))


@dataclasses.dataclass(frozen=True)
class Trace:
    """What happened in a run: `impacts` (dtype `IMPACT`), `samples` (`SAMPLE`), `final` state to go on from.

    `lost`: the ball left the bar, and the run ended there.
    """

    params: Params
    impacts: np.ndarray
    samples: np.ndarray
    final: np.void

    @property
    def lost(self) -> bool:
        """Whether the ball left the bar."""
        return bool(self.final["lost"])

    def seconds(self, rows: np.ndarray) -> np.ndarray:
        """Time (s) since the start of the first run of impacts, samples or apexes."""
        return rows["cycle"] * self.params.period + rows["time"]

    @property
    def free(self) -> np.ndarray:
        """(impacts - 1,) bool, see `free_flights`."""
        return free_flights(self.impacts, self.params)

    @property
    def flight_times(self) -> np.ndarray:
        """(impacts - 1,) s, see `flight_times`."""
        return flight_times(self.impacts, self.params)

    @property
    def apexes(self) -> np.ndarray:
        """Highest points (dtype `APEX`) of those flights between two impacts that have one: rows in order."""
        rise = self.impacts["w_out"][:-1] / self.params.gravity
        has = self.free & (rise > 0.0) & (rise < self.flight_times)
        start, rise = self.impacts[:-1][has], rise[has]
        rows = np.zeros(len(start), APEX)
        turns, rows["time"] = np.divmod(start["time"] + rise, self.params.period)
        rows["cycle"] = start["cycle"] + turns.astype(int)
        rows["x"] = start["x"] + start["u_out"] * rise
        rows["z"] = start["z"] + 0.5 * self.params.gravity * rise**2
        return rows


def bar_motion(
    params: Params,
    *,
    x: float = 0.0,
    x_phase: float = math.pi / 2.0,
    tilt: float = 0.0,
    tilt_phase: float = 0.0,
    z: float = 0.0,
    z_phase: float = math.pi / 2.0,
) -> np.ndarray:
    """The six phasors of x = A sin(omega t + x_phase), tilt alike, z = A sin(2 omega t + z_phase).

    Args:
        params: gives omega.
        x: peak acceleration A omega^2, m/s^2.
        x_phase: rad; the default is Bell's (section IV).
        tilt: peak acceleration, rad/s^2.
        tilt_phase: rad; +pi/2 is Bell's sink.
        z: peak acceleration A (2 omega)^2, m/s^2.
        z_phase: rad; the default is Bell's.

    Returns:
        (6,) x_cos, x_sin, tilt_cos, tilt_sin, z_cos, z_sin in m, rad, m.
    """
    w = params.omega
    parts = [(x / w**2, x_phase), (tilt / w**2, tilt_phase), (z / (2.0 * w) ** 2, z_phase)]
    motion = np.array([part for size, phase in parts for part in (size * math.sin(phase), size * math.cos(phase))])
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
    if not 0 <= key < 2**64:
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
        motion: (6,) phasors of the bar, or (cycles, 6) one row per cycle. Where the motion differs from that of the
            cycle before, or of `start`, the bar blends into it as `params.blend` says.
        start: a record of `State`, see `ball`, or an array of one; not changed.
        cycles: how many; a lost ball ends the run earlier.
        options: name -> record of the class that `vr_envs.models.ball_on_bar.OPTIONS` gives for it.
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
    motions = np.broadcast_to(_motions(motion, int(cycles)), (cycles, 6))
    state = _states(start, 1)
    ratio = params.frequency / sample_rate if sample_rate else 0.0
    log = np.empty((MAX_EVENTS, len(LOGGED)))
    impacts, samples, done = [], [], 0
    while done < cycles and not state["lost"][0]:
        coming = min(int(cycles) - done, 4096)
        hits = np.empty(MAX_EVENTS + 16 * coming, IMPACT)
        seen = np.empty(math.ceil(coming / ratio) + 2 if sample_rate else 0, SAMPLE)
        n, n_hits, n_seen = _run(state, motions[done : done + coming], record, records, log, hits, seen, ratio)
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
        skip: cycles that each run takes before its impacts are kept.
        keep: impacts to keep per run; a run ends after `PATIENCE * keep` cycles more at the latest.
        options: see `simulate`.
        follow: each run starts from the end of the one before (a quasi-static sweep); the first from `starts`.

    Returns:
        impacts (n, keep) of dtype `IMPACT`, counts (n,) how many of each row are filled, final states (n,).

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
    states = _states(starts, n)
    if len(motions) != n:
        raise ValueError(f"{len(motions)} motions and {n} starts; give one of either, or as many")
    kept, counts = np.zeros((n, keep), IMPACT), np.zeros(n, np.int64)
    log = np.empty((MAX_EVENTS, len(LOGGED)))
    _scan(states, motions, record, records, log, int(skip), kept, counts, bool(follow))
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
                f"option {name!r} = {option!r}; give a vr_envs.models.ball_on_bar.{OPTIONS[name].__name__}"
            )
        if option is not None:
            checked(OPTIONS[name], dataclasses.asdict(option), f"{name}.")
    checked(Params, dataclasses.asdict(params), "params.")
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


def _states(starts: Any, n: int) -> np.ndarray:
    """(n,) own copies of the start records."""
    if getattr(starts, "dtype", None) != dtype_of(State) or np.size(starts) not in (1, n):
        raise ValueError(
            f"start = {starts!r}; give a record made by ball() or the final state of a run, or {n} of them"
        )
    return np.array(np.broadcast_to(np.ravel(starts), n))


def _raise_fault(states: np.ndarray) -> None:
    if states["fault"].any():
        raise SimulationError(
            f"{np.count_nonzero(states['fault'])} of {len(states)} runs: a cycle needed more than {MAX_EVENTS} "
            "events, or a search did not end; a restitution nearer to 1 or a larger blend makes shorter work"
        )
