"""The ride by scipy's adaptive integrators, which take contacts as events and restart where anything else jumps."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from vr_envs.bench.accuracy.terrain_ride_episodes import SAME, SEEN, Episode, Piece
from vr_envs.bench.accuracy.terrain_ride_loops import contacts_of, gap_of, slopes, switched
from vr_envs.models.ride_options import TICK

FINER = 0.01  # absolute tolerance in m and m/s, over the relative one


def integrated(episode: Episode, method: str, tolerance: float) -> np.ndarray:
    """By `solve_ivp` with a relative tolerance: `SEEN` at every tick, (ticks, 4). The right-hand side is compiled."""
    _, _, tyre, stop = episode.parts
    rows, off = np.zeros((len(episode.actions), len(SEEN))), 0.0
    pieces = list(episode.pieces())
    ground = episode.ground(pieces[0], 0.0)
    y = episode.first(ground)
    contacts = contacts_of(y, ground, episode.params, tyre, stop)
    for piece in pieces:
        begin, wanted = piece.begin, (piece.ticks + 1) * TICK
        while piece.end - begin > SAME:
            found = _part(episode, piece, begin, y, contacts, method, tolerance, wanted[wanted < piece.end - SAME])
            met = found.status == 1
            end, y = (found.t_events[0][0], found.y_events[0][0]) if met else (piece.end, found.y[:, -1])
            for time, at in zip(found.t, np.transpose(found.y), strict=True):
                tick = round(time / TICK)
                if abs(time - tick * TICK) < SAME:
                    place = episode.seen(at, episode.ground(piece, time))
                    rows[tick - 1] = *place, off + contacts[0] * (time - begin)
            off += contacts[0] * (end - begin)
            if met:
                contacts = switched(y, episode.ground(piece, end), contacts, episode.params, tyre, stop)
            begin = end
    return rows


def _part(
    episode: Episode, piece: Piece, begin: float, y: np.ndarray, contacts: tuple[float, float], method: str,
    tolerance: float, wanted: np.ndarray,
) -> Any:  # fmt: skip
    """What `solve_ivp` finds from `begin` to the end of a piece or the next contact; `wanted`: instants on the way."""
    _, _, tyre, stop = episode.parts
    params, gamma, w2, climb = episode.params, piece.gamma, piece.w2, piece.climb

    def rates(time: float, at: np.ndarray) -> tuple[float, ...]:
        return slopes(at, episode.ground(piece, time), climb, contacts, gamma, w2, params, tyre, stop)

    def gap(time: float, at: np.ndarray) -> float:
        return gap_of(at, episode.ground(piece, time), contacts, params, tyre, stop)[0]

    gap.terminal, gap.direction = True, -1.0  # type: ignore[attr-defined]
    return solve_ivp(
        rates, (begin, piece.end), y, method, rtol=tolerance, atol=FINER * tolerance,
        t_eval=[*wanted[wanted > begin], piece.end], events=gap if episode.touching else None,
    )  # fmt: skip
