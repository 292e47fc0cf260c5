"""How well the legs between the changes of the demands are flown: sums from which an episode's metrics follow.

A leg is judged if it lasts 20 s. A channel responds to a step in it if its demand steps by more than its band, to more
than its band from its value. With r = error / error at the leg's start, at the control instants:

* rise: time from r <= 0.9 to r <= 0.1; settling: time after which the error stays in band; where that never happens
  in the leg, the length of the leg counts;
* overshoot: the largest -r;
* steady error: mean |error| over the last 10 s of every judged leg; of one that has no end or ends with the loss of the
  aircraft, which nobody knows beforehand, over its last 10 to 20 s, or all of it;
* a leg is held if all three channels are in band at every instant of its last 10 s.

A leg counts when the demands change, and also when the aircraft leaves the envelope in it: with its whole length, not
settled and not held. A leg that the time limit cuts short does not count, except one without an end.
"""

from __future__ import annotations

import dataclasses
import math

from vr_envs.envs.autopilot_demands import NEVER, DemandState
from vr_envs.envs.autopilot_observation import BAND
from vr_envs.models.clock import SAME
from vr_envs.models.jit import kernel
from vr_envs.models.lanes import to_int, where
from vr_envs.models.record import quantity

JUDGED = 20.0  # s: shortest leg that is judged
HOLD = 10.0  # s
BEHIND = 0.5 * math.pi
RISE_FROM, RISE_TO = 0.9, 0.1  # of the error at the leg's start


@dataclasses.dataclass(frozen=True)
class LegState(DemandState):
    """The demands, how the present leg goes, and sums over the legs before it; times in control intervals."""

    leg_start: int = quantity(0, "", "step at which the leg began", low=0)
    per_start: float = quantity(0.0, "1/m, s/m, 1/rad", "1 / error at the leg's start, 0: no step", shape=(3,))
    lowest: float = quantity(0.0, "", "smallest error so far, in units of that at the leg's start", shape=(3,))
    rising: int = quantity(0, "", "steps from 10 % of the way to 90 %", low=0, shape=(3,))
    outside: int = quantity(0, "", "step of the leg at which the error was last out of band", low=0, shape=(3,))
    held: int = quantity(0, "", "steps for which all three errors have been within the band", low=0)
    tail_left: int = quantity(0, "", "steps until the sums of the tail begin anew", low=0)
    tail_sum: float = quantity(0.0, "m, m/s, rad", "sum of |error| in the tail", shape=(3,))
    tail_before: float = quantity(0.0, "m, m/s, rad", "`tail_sum` when it began anew", shape=(3,))
    legs: int = quantity(0, "", "legs judged", low=0)
    legs_held: int = quantity(0, "", "of which held", low=0)
    responses: int = quantity(0, "", "steps of the demand answered in judged legs", low=0, shape=(3,))
    rise_sum: int = quantity(0, "", "sum of their rise times", low=0, shape=(3,))
    settling_sum: int = quantity(0, "", "sum of their settling times", low=0, shape=(3,))
    overshoot_sum: float = quantity(0.0, "", "sum of their overshoots", shape=(3,))
    steady_sum: float = quantity(0.0, "m, m/s, rad", "sum of the judged legs' steady errors", shape=(3,))


@kernel
def tail_steps(params):  # type: ignore[no-untyped-def]
    """Control intervals in the last 10 s, at least one."""
    return max(1, math.ceil(HOLD / params.dt - SAME))


@kernel
def leg_steps(state, params):  # type: ignore[no-untyped-def]
    """Control intervals from the start of the present leg to its end; -1: it has none."""
    if state.next_change >= NEVER:
        return -1
    return math.ceil((state.next_change - SAME) / params.dt) - state.leg_start


@kernel
def begin_leg(state, params, errors, jumps):  # type: ignore[no-untyped-def]
    """The demands have just changed by `jumps`, to `errors` from the aircraft's values (3 each)."""
    state.leg_start = state.steps
    # the tail's sums begin anew every so many steps, and so that one such run ends with the leg
    state.tail_left = max(0, leg_steps(state, params)) % tail_steps(params)
    for channel in range(3):
        band = BAND[channel]
        step = abs(jumps[channel]) > band and abs(errors[channel]) > band and state.demand_rate[channel] == 0.0
        state.per_start[channel] = 1.0 / errors[channel] if step else 0.0
        state.lowest[channel] = 1.0
        state.rising[channel] = state.outside[channel] = 0
        state.tail_sum[channel] = state.tail_before[channel] = 0.0


@kernel
def watch_leg(state, params, errors, inside):  # type: ignore[no-untyped-def]
    """Take the errors (3) at the end of an interval; `inside`: all of them are within the band."""
    state.held = where(inside, state.held + 1, 0)
    left = state.tail_left
    anew = left == 0
    state.tail_left = where(anew, tail_steps(params), left) - 1
    flown = state.steps - state.leg_start
    # where the short way round has become the other one there is no overshoot
    other_way = (abs(errors[2]) > BEHIND) & (errors[2] * state.per_start[2] < 0.0)
    state.per_start[2] = where(other_way, -state.per_start[2], state.per_start[2])
    for channel in range(3):
        error = errors[channel]
        size = abs(error)
        lowest = min(state.lowest[channel], error * state.per_start[channel])
        state.lowest[channel] = lowest
        state.rising[channel] += to_int((lowest > RISE_TO) & (lowest <= RISE_FROM))
        state.outside[channel] = where(size > BAND[channel], flown, state.outside[channel])
        tail = state.tail_sum[channel]
        state.tail_before[channel] = where(anew, tail, state.tail_before[channel])
        state.tail_sum[channel] = where(anew, 0.0, tail) + size


@kernel
def finish_leg(state, params):  # type: ignore[no-untyped-def]
    """Add the present leg to the sums, if it is judged."""
    flown = state.steps - state.leg_start
    length = max(flown, leg_steps(state, params)) if state.lost else flown
    if length * params.dt < JUDGED - SAME:
        return
    state.legs += 1
    state.legs_held += not state.lost and state.held >= tail_steps(params)
    tail, before = tail_steps(params) - state.tail_left, 0.0
    if state.tail_left > 0:
        tail, before = tail + tail_steps(params), 1.0
    per_tail = 1.0 / max(1, min(flown, tail))
    for channel in range(3):
        state.steady_sum[channel] += (state.tail_sum[channel] + before * state.tail_before[channel]) * per_tail
        if state.per_start[channel] != 0.0:
            lowest, outside = state.lowest[channel], state.outside[channel]
            settled = not state.lost and outside < flown
            state.responses[channel] += 1
            state.rise_sum[channel] += state.rising[channel] if lowest <= RISE_TO else length
            state.settling_sum[channel] += outside + 1 if settled else length
            state.overshoot_sum[channel] += max(0.0, -lowest)


@kernel
def finish_episode(state, params):  # type: ignore[no-untyped-def]
    """Add the present leg of an episode that has ended to its sums: of a lost aircraft, or a leg without an end."""
    if state.lost or state.next_change >= NEVER:
        finish_leg(state, params)
