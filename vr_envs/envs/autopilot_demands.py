"""What the autopilot is asked for: demanded altitude, airspeed and heading, constant, stepping or ramping.

Schedule and sizes are drawn from the episode's key alone, so every policy meets the same demands. A demand
changes by a share of what the aircraft, at the demanded altitude and speed, can reach until the next change.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from vr_envs.models import autopilot as model
from vr_envs.models.autopilot import rate_limits, wrap
from vr_envs.models.jit import kernel
from vr_envs.models.noise import uniform
from vr_envs.models.record import quantity

# counters of the episode's random numbers; those of the gusts begin at 0
START_DRAWS = 1 << 40
DEMAND_DRAWS = 1 << 41
_PER_CHANGE = 16
_HEADING = 2


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
    demand_target: float = quantity(0.0, "m, m/s, rad", "demands at the end of a ramp", shape=(3,))
    changes: int = quantity(0, "", "number of demand changes so far")
    next_change: int = quantity(0, "", "step at which the demands change next")


@kernel
def move_demands(state, params):  # type: ignore[no-untyped-def]
    """Bring ramping demands to the end of the present control interval, number `state.steps` from 0."""
    left = (state.next_change - state.steps - 1) * params.dt
    for channel in range(3):
        if state.demand_rate[channel] != 0.0:
            state.demand[channel] = state.demand_target[channel] - state.demand_rate[channel] * left
    state.demand[_HEADING] = wrap(state.demand[_HEADING])


@kernel
def _next_target(demand, down, up, low, high, share, toss):  # type: ignore[no-untyped-def]
    """A demand `share` of the reach `down` or `up` away, on the side that the toss and [low, high] leave."""
    rising, falling = demand + share * up, demand - share * down
    if (toss < 0.5 and falling >= low) or rising > high:
        return max(low, falling)
    return rising


@kernel
def change_demands(state, params, envelope, demands):  # type: ignore[no-untyped-def]
    """Draw new demands and the step of the next change."""
    base = DEMAND_DRAWS + _PER_CHANGE * state.changes
    hold = demands.hold_low + (demands.hold_high - demands.hold_low) * uniform(state.key, base)
    steps = max(1, round(hold / params.dt))
    hold = steps * params.dt
    state.changes += 1
    state.next_change = state.steps + steps
    falling, rising = rate_limits(state.demand[0], state.demand[1], params, envelope)
    lows = (params.altitude_low, params.speed_low, -np.inf)
    highs = (params.altitude_high, params.speed_high, np.inf)
    for channel in range(3):
        draw = base + 1 + 4 * channel
        demand = state.demand[channel]
        target = demand
        if uniform(state.key, draw) < demands.change:
            share = demands.share_low + (demands.share_high - demands.share_low) * uniform(state.key, draw + 1)
            toss = uniform(state.key, draw + 2)
            target = _next_target(
                demand, falling[channel] * hold, rising[channel] * hold, lows[channel], highs[channel], share, toss
            )
        state.demand_target[channel] = target
        if uniform(state.key, draw + 3) < demands.ramp:
            state.demand_rate[channel] = (target - demand) / hold
        else:
            state.demand_rate[channel] = 0.0
            state.demand[channel] = target
    state.demand[_HEADING] = wrap(state.demand[_HEADING])
