"""The ride by scipy's adaptive integrators, which take contacts as events and restart where anything else jumps."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from vr_envs.bench.accuracy.terrain_ride_episodes import SAME, SEEN, Episode
from vr_envs.bench.accuracy.terrain_ride_loops import contacts_of, gap_of, slopes, switched
from vr_envs.models.jit import bound, kernel
from vr_envs.models.ride_options import TICK
from vr_envs.models.terrain import undulation_ahead

FINER = 0.01  # absolute tolerance in m and m/s, over the relative one


@kernel
def ground_at(held, start, undulation, params):
    """Height of the ground; `held`: time, begin of a piece, height of the road there, its rate, and what follows."""
    if undulation is not None:
        return undulation_ahead(start, params.speed * held[0], undulation)
    return held[2] + held[3] * (held[0] - held[1])


@kernel
def slopes_at(y, held, start, undulation, params, tyre, stop):
    """`slopes` at an array y; `held`: what `ground_at` takes, the two contacts, damping and stiffness over mass."""
    ground = ground_at(held, start, undulation, params)
    contacts = held[4], held[5]
    return slopes((y[0], y[1], y[2], y[3]), ground, held[3], contacts, held[6], held[7], params, tyre, stop)


@kernel
def gap_at(y, held, start, undulation, params, tyre, stop):
    """`gap_of` likewise, the margin alone."""
    ground = ground_at(held, start, undulation, params)
    return gap_of((y[0], y[1], y[2], y[3]), ground, (held[4], held[5]), params, tyre, stop)[0]


def integrated(episode: Episode, method: str, tolerance: float) -> Callable[[], np.ndarray]:
    """Work that drives the episode by `solve_ivp` with a relative tolerance and returns what is seen.

    That is `SEEN` at every tick, (ticks, 4), not numbers from where scipy gives up. Right-hand side and event are
    compiled, and have their arguments converted beforehand.
    """
    undulation, _, tyre, stop = episode.parts
    params, pieces = episode.params, list(episode.pieces())
    wanted = [(piece.ticks + 1) * TICK for piece in pieces]
    place, held = np.empty(4), np.empty(8)
    arguments = held, episode.start, undulation, params
    ground_there, slopes_there, gap_there = (
        bound(ground_at, *arguments),
        bound(slopes_at, place, *arguments, tyre, stop),
        bound(gap_at, place, *arguments, tyre, stop),
    )

    def ground(time: float) -> float:
        held[0] = time
        return ground_there()

    def rates(time: float, at: np.ndarray) -> tuple[float, ...]:
        held[0], place[:] = time, at
        return slopes_there()

    def gap(time: float, at: np.ndarray) -> float:
        held[0], place[:] = time, at
        return gap_there()

    gap.terminal, gap.direction = True, -1.0  # type: ignore[attr-defined]
    events: Any = gap if episode.touching else None

    def work() -> np.ndarray:
        rows, off = np.full((len(episode.actions), len(SEEN)), np.nan), 0.0
        y = episode.first(episode.ground(pieces[0], 0.0))
        contacts = contacts_of(y, episode.ground(pieces[0], 0.0), params, tyre, stop)
        for piece, instants in zip(pieces, wanted, strict=True):
            begin = piece.begin
            while piece.end - begin > SAME:
                held[1:] = piece.begin, piece.ground, piece.climb, *contacts, piece.gamma, piece.w2
                seen = [*instants[(instants > begin) & (instants < piece.end - SAME)], piece.end]
                found = solve_ivp(
                    rates, (begin, piece.end), y, method, rtol=tolerance, atol=FINER * tolerance, t_eval=seen,
                    events=events,
                )  # fmt: skip
                if not found.success:
                    return rows
                met = found.status == 1
                end, y = (found.t_events[0][0], found.y_events[0][0]) if met else (piece.end, found.y[:, -1])
                for time, at in zip(found.t, np.transpose(found.y), strict=True):
                    tick = round(time / TICK)
                    if abs(time - tick * TICK) < SAME:
                        rows[tick - 1] = *episode.seen(at, ground(time)), off + contacts[0] * (time - begin)
                off += contacts[0] * (end - begin)
                if met:
                    contacts = switched(y, ground(end), contacts, params, tyre, stop)
                begin = end
        return rows

    return work
