"""A clock that ticks at fixed instants of an episode, whatever the control intervals are.

What is done once per tick (limits renewed, a filter fed) then does not depend on how time is split into intervals.
"""

from __future__ import annotations

from vr_envs.models.jit import kernel

# s: two instants closer than this are one; rounding of sums of intervals stays far below
SAME = 1e-9


@kernel
def piece_of(left: float, to_tick: float) -> float:
    """How much of the time `left` > `SAME` [s] passes before the next tick, which is `to_tick` [s] away.

    If they meet, the tick's instant counts: the pieces from tick to tick add up to the period, however time is split.
    """
    return left if left < to_tick - SAME else to_tick


@kernel
def to_next_tick(to_tick: float, piece: float, period: float) -> tuple[float, bool]:
    """Time [s] to the next tick after a `piece` of time from `piece_of`, and whether the clock ticked at its end."""
    rest = to_tick - piece
    return (period, True) if rest <= SAME else (rest, False)
