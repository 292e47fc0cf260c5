"""What is measured of a ride: once per tick, so that no metric depends on how time is split into control intervals."""

from __future__ import annotations

import dataclasses

import numpy as np

from vr_envs.models.constants import G
from vr_envs.models.jit import kernel
from vr_envs.models.record import quantity
from vr_envs.models.ride_options import TICK
from vr_envs.models.weighting import MEMORY, weight


@dataclasses.dataclass(frozen=True)
class MeterState:
    """The weighting filter, and sums over the ticks from which metrics follow."""

    ticks: int = quantity(0, "", "ticks done", low=0)
    weighting: float = quantity(0.0, "", "memory of the weighting filter", shape=(MEMORY,))
    weighted: float = quantity(0.0, "m/s^2", "weighted acceleration at the last tick")
    weighted_squares: float = quantity(0.0, "m^2/s^4", "its squares, summed over the ticks", low=0.0)
    weighted_fourths: float = quantity(0.0, "m^4/s^8", "its fourth powers, summed over the ticks", low=0.0)
    measured: float = quantity(0.0, "m/s^2", "mean acceleration over the last tick measured")
    acceleration_squares: float = quantity(0.0, "m^2/s^4", "its squares, summed over the ticks", low=0.0)
    jump_squares: float = quantity(0.0, "m^2/s^4", "squares of its changes from tick to tick, summed", low=0.0)
    travel_squares: float = quantity(0.0, "m^2", "squares of the travel, summed over the ticks", low=0.0)
    travel_peak: float = quantity(0.0, "m", "largest |u| at a tick", low=0.0)
    load_squares: float = quantity(0.0, "", "squares of dynamic over static tyre load, summed over the ticks", low=0.0)
    force_squares: float = quantity(0.0, "N^2", "squares of the actuator's force, summed over the ticks", low=0.0)


@kernel
def sample(state, gamma, params, tyre, metrics):
    """Measure at the end of a tick: `state.acceleration` and `state.travel_rate` are the means over it.

    Without `metrics` that is the weighted acceleration alone. The actuator's force is the one commanded, or that of a
    damper of `gamma` [1/s]: its mean over the tick, or, where it acts on the mass's own velocity, what it is at the
    end.
    """
    acceleration, travel = state.acceleration, state.travel
    weighted = weight(state.weighting, acceleration)
    state.weighted = weighted
    if metrics is None:
        return
    state.ticks += 1
    square = weighted * weighted
    state.weighted_squares += square
    state.weighted_fourths += square * square
    jump = acceleration - state.measured
    state.jump_squares += jump * jump
    state.measured = acceleration
    state.acceleration_squares += acceleration * acceleration
    state.travel_squares += travel * travel
    state.travel_peak = max(state.travel_peak, abs(travel))
    if params.active > 0.0:
        force = params.force * state.held[0]
    else:
        rate = params.relative * state.travel_rate + (1.0 - params.relative) * state.velocity
        force = params.mass * gamma * rate
    state.force_squares += force * force
    if tyre is not None:
        # off the ground the tyre carries nothing: all of the static load is missing
        load = max(-1.0, -tyre.rate * state.deflection / ((params.mass + tyre.unsprung_mass) * G))
        state.load_squares += load * load


def readings(states: np.ndarray, seconds: np.ndarray) -> dict[str, np.ndarray]:
    """What the meter says of the rides so far, which took `seconds` [s], one value per record.

    acceleration_rms_m_s2: of the mass, weighted with Wk of ISO 2631-1; unweighted_rms_m_s2: without; vdv_m_s175: the
    vibration dose value of the weighted one, (integral of its fourth power)^(1/4); jerk_rms_m_s3: of the change of
    the mean acceleration from one tick of 10 ms to the next, over the tick; travel_rms_mm, travel_peak_mm: of the
    spring, at the ticks; tyre_load_rms: dynamic tyre load over the static one, 0 without a tyre; airborne_fraction:
    part of the time that the tyre was off the ground; force_rms_n: of the actuator, which is the damper where no
    force is commanded.
    """
    ticks = np.maximum(states["ticks"], 1)

    def rms(squares: str) -> np.ndarray:
        return np.sqrt(states[squares] / ticks)

    return {
        "acceleration_rms_m_s2": rms("weighted_squares"),
        "travel_rms_mm": 1e3 * rms("travel_squares"),
        "travel_peak_mm": 1e3 * states["travel_peak"],
        "tyre_load_rms": rms("load_squares"),
        "airborne_fraction": states["airborne_time"] / seconds,
        "unweighted_rms_m_s2": rms("acceleration_squares"),
        "vdv_m_s175": (states["weighted_fourths"] * TICK) ** 0.25,
        "jerk_rms_m_s3": rms("jump_squares") / TICK,
        "force_rms_n": rms("force_squares"),
    }
