"""A clock that ticks at fixed instants of an episode, whatever the control intervals are.

What is done once per tick (limits renewed, a filter fed) then does not depend on how time is split into intervals.
An interval that ends at a tick ends there to the last digit; the time by which that was early or late, which is
rounding, is owed to the next interval, so that no time is lost or gained.
"""

from __future__ import annotations

import math

from vr_envs.models.jit import kernel

SAME = 1e-9  # s: two instants of an episode that are closer than this are one
MEET = 1e-11  # s: so near to a tick, an interval ends at it; rounding within an interval stays below


@kernel
def piece_of(left: float, to_tick: float) -> float:
    """How much of the time `left` > `MEET` [s] passes before the next tick, which is `to_tick` [s] away.

    If they meet, the tick's instant counts: the pieces from tick to tick add up to the period, however time is split.
    """
    return left if left < to_tick - MEET else to_tick


@kernel
def to_next_tick(to_tick: float, piece: float, period: float) -> tuple[float, bool]:
    """Time [s] to the next tick after a `piece` of time from `piece_of`, and whether the clock ticked at its end."""
    rest = to_tick - piece
    return (period, True) if rest <= MEET else (rest, False)


@kernel
def left_after(total: float, first: float, ticks: int, period: float) -> float:
    """What is left [s] of an interval after its tick number `ticks` >= 1, the first one `first` [s] after its begin.

    Not summed piece by piece, which would add rounding at every tick.
    """
    return total - (first + (ticks - 1) * period)


@kernel
def equal_steps(duration: float, longest: float) -> int:
    """Into how many equal steps, none longer than `longest` [s], a duration > 0 [s] is divided.

    A ratio that is a whole number but for rounding is one.
    """
    return max(1, int(math.ceil(duration / longest - 1e-9)))
