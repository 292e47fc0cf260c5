"""What the autopilot is asked for: demanded altitude, airspeed and heading, constant, stepping or ramping.

The demands are functions of time, piecewise constant or linear; between two changes lies a leg. They are sampled at
the control instants, whatever the control interval: a change shows at the first instant at or after it. Random ones are
drawn from the episode's key alone, so every policy meets the same demands. A demand changes by a share of what the
aircraft, at the demanded altitude and speed, can reach until the next change. Airspeeds are as measured.
"""

from __future__ import annotations

import dataclasses
import math

from vr_envs.models import autopilot as model
from vr_envs.models.atmosphere import airspeed, highest_airspeed, true_airspeed
from vr_envs.models.autopilot import wrap
from vr_envs.models.autopilot_limits import rate_limits
from vr_envs.models.clock import SAME
from vr_envs.models.jit import kernel
from vr_envs.models.lanes import where
from vr_envs.models.noise import uniform
from vr_envs.models.record import quantity

# counters of the episode's random numbers; those of the gusts begin at 0
START_DRAWS = 1 << 40
DEMAND_DRAWS = 1 << 41
_PER_CHANGE = 16
_HEADING = 2
NEVER = 1e12  # s: the leg has no end


@dataclasses.dataclass(frozen=True)
class Demands:
    """When and by how much the demands change; without this option they stay what the aircraft starts with."""

    hold_low: float = quantity(40.0, "s", "shortest time between changes", low=1.0, high=1e5)
    hold_high: float = quantity(120.0, "s", "longest time between changes", low=1.0, high=1e5)
    share_low: float = quantity(0.03, "", "smallest change, as a share of what can be reached", low=0.0, high=1.0)
    share_high: float = quantity(0.6, "", "largest change, as a share of what can be reached", low=0.0, high=1.0)
    change: float = quantity(0.75, "", "probability that a channel changes", low=0.0, high=1.0)
    ramp: float = quantity(0.25, "", "probability that a change is a ramp over the whole hold", low=0.0, high=1.0)


@dataclasses.dataclass(frozen=True)
class DemandState(model.State):
    """The aircraft and the demands on it; channels in the order altitude [m], airspeed [m/s], heading [rad]."""

    demand: float = quantity(0.0, "m, m/s, rad", "present demands", shape=(3,))
    demand_rate: float = quantity(0.0, "m/s, m/s^2, rad/s", "their rates of change", shape=(3,))
    demand_target: float = quantity(0.0, "m, m/s, rad", "demands at the end of the leg", shape=(3,))
    changes: int = quantity(0, "", "number of legs begun so far", low=0)
    next_change: float = quantity(0.0, "s", "time of the next change, 1e12: never", low=0.0, high=NEVER)


@kernel
def demands_at(state, time):  # type: ignore[no-untyped-def]
    """Bring the demands of the present leg to the time [s] since the start.

    An interval in which the leg ends is flown and judged by it to its own end: nobody knows before that the demands
    will change.
    """
    left = state.next_change - time
    for channel in range(3):
        rate = state.demand_rate[channel]
        ramped = state.demand_target[channel] - rate * left
        state.demand[channel] = where(rate != 0.0, ramped, state.demand[channel])
    state.demand[_HEADING] = wrap(state.demand[_HEADING])


@kernel
def change_is_due(state, params):  # type: ignore[no-untyped-def]
    """Whether the demands change at the present control instant."""
    return state.steps * params.dt > state.next_change - SAME


@kernel
def _next_target(demand, down, up, low, high, share, toss):  # type: ignore[no-untyped-def]
    """A demand `share` of the reach `down` or `up` away, on the side that the toss and [low, high] leave."""
    rising, falling = demand + share * up, demand - share * down
    if (toss < 0.5 and falling >= low) or rising > high:
        return max(low, falling)
    return rising


@kernel
def change_demands(state, params, envelope, atmosphere, demands):  # type: ignore[no-untyped-def]
    """Draw the next leg: demands, whether they ramp, and its end.

    Airspeeds can be flown at the demanded altitudes: below the upper end of their operating range at both ends of the
    leg, to which a demand is lowered that would be above it.
    """
    base = DEMAND_DRAWS + _PER_CHANGE * state.changes
    hold = demands.hold_low + (demands.hold_high - demands.hold_low) * uniform(state.key, base)
    state.changes += 1
    state.next_change += hold
    altitude, measured = state.demand_target[0], state.demand_target[1]
    falling, rising = rate_limits(altitude, true_airspeed(altitude, measured, atmosphere), params, envelope)
    share_of_true = airspeed(altitude, 1.0, atmosphere)
    units = (1.0, share_of_true, 1.0)
    lows = (params.altitude_low, params.speed_low, -math.inf)
    high = highest_airspeed(altitude, params, atmosphere)
    for channel in range(3):
        draw = base + 1 + 4 * channel
        demand = state.demand_target[channel]
        limit = params.altitude_high if channel == 0 else (high if channel == 1 else math.inf)
        target = demand
        if uniform(state.key, draw) < demands.change:
            share = demands.share_low + (demands.share_high - demands.share_low) * uniform(state.key, draw + 1)
            toss = uniform(state.key, draw + 2)
            reach = hold * units[channel]
            target = _next_target(
                demand, falling[channel] * reach, rising[channel] * reach, lows[channel], limit, share, toss
            )
        target = min(target, limit)
        if channel == 0:
            high = min(high, highest_airspeed(target, params, atmosphere))
        ramps = uniform(state.key, draw + 3) < demands.ramp
        state.demand_rate[channel] = (target - demand) / hold if ramps else 0.0
        state.demand[channel] = state.demand_target[channel] = target
    state.demand_target[_HEADING] = wrap(state.demand_target[_HEADING])
    demands_at(state, state.steps * params.dt)
