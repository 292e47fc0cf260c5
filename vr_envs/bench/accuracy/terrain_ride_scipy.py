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


def _told(call: Callable[[], Any], place: np.ndarray, held: np.ndarray) -> Any:
    """The function of time and place that a call of nothing is, once it is told these in its arrays."""

    def function(time: float, at: np.ndarray) -> Any:
        held[0], place[:] = time, at
        return call()

    return function


def integrated(episode: Episode, method: str, tolerance: float) -> Callable[[], np.ndarray]:
    """Work that drives the episode by `solve_ivp` with a relative tolerance and returns what is seen.

    That is `SEEN` at every tick, (ticks, 4), not numbers from where scipy gives up. Right-hand side and event are
    compiled, and have their arguments converted beforehand.
    """
    undulation, _, tyre, stop = episode.parts
    params, pieces = episode.params, list(episode.pieces())
    wanted = [(piece.ticks + 1) * TICK for piece in pieces]
    # of the ground at the end of every tick
    heights = [episode.ground(p, time) for p, times in zip(pieces, wanted, strict=True) for time in times.tolist()]
    place, held = np.empty(4), np.empty(8)
    arguments = place, held, episode.start, undulation, params, tyre, stop
    first = episode.first(episode.ground(pieces[0], 0.0))
    touching = contacts_of(first, episode.ground(pieces[0], 0.0), params, tyre, stop)
    rates, events = _told(bound(slopes_at, *arguments), place, held), None
    if episode.touching:
        events = _told(bound(gap_at, *arguments), place, held)
        events.terminal, events.direction = True, -1.0

    def work() -> np.ndarray:
        rows, off = np.full((len(episode.actions), len(SEEN)), np.nan), 0.0
        y, contacts = first, touching
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
                        rows[tick - 1] = *episode.seen(at, heights[tick - 1]), off + contacts[0] * (time - begin)
                off += contacts[0] * (end - begin)
                if met:
                    contacts = switched(y, episode.ground(piece, end), contacts, params, tyre, stop)
                begin = end
        return rows

    return work
