"""What is measured of a ride: once per tick, so that no metric depends on how time is split into control intervals."""

from __future__ import annotations

import dataclasses

from vr_envs.models.jit import kernel
from vr_envs.models.record import quantity
from vr_envs.models.weighting import MEMORY, weight


@dataclasses.dataclass(frozen=True)
class MeterState:
    """The weighting filter, and sums over the ticks from which metrics follow."""

    ticks: int = quantity(0, "", "ticks done", low=0)
    weighting: float = quantity(0.0, "", "memory of the weighting filter", shape=(MEMORY,))
    weighted: float = quantity(0.0, "m/s^2", "weighted acceleration at the last tick")
    weighted_squares: float = quantity(0.0, "m^2/s^4", "its squares, summed over the ticks")
    travel_squares: float = quantity(0.0, "m^2", "squares of the travel, summed over the ticks")
    travel_peak: float = quantity(0.0, "m", "largest |u| at a tick")


@kernel
def sample(state, params, tyre):
    """Measure at the end of a tick: `state.acceleration` and `state.travel_rate` are the means over it."""
    state.ticks += 1
    state.weighted = weight(state.weighting, state.acceleration)
    state.weighted_squares += state.weighted * state.weighted
    state.travel_squares += state.travel * state.travel
    state.travel_peak = max(state.travel_peak, abs(state.travel))
