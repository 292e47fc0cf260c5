"""What an episode of the autopilot is judged by, from the sums in its record."""

from __future__ import annotations

import math

import numpy as np

from vr_envs.envs.autopilot_legs import finish_episode, watch_leg
from vr_envs.envs.autopilot_observation import BAND
from vr_envs.envs.scene import Scene
from vr_envs.models.autopilot_limits import commanded_rates
from vr_envs.models.jit import kernel
from vr_envs.models.lanes import to_int
from vr_envs.models.load_factor import lateral_load_factor, normal_load_factor

SATURATED = 0.999  # of the limit
_CHANNELS = (("altitude", "m"), ("airspeed", "m_s"), ("heading", "deg"))
_UNITS = (1.0, 1.0, math.degrees(1.0))  # of the channels, from those of the record
_NAMES = (
    "is_success",
    *(f"{channel}_error_{unit}" for channel, unit in _CHANNELS),
    "time_in_band",
    "movement",
    "left_envelope",
    "legs_judged",
    "legs_held",
    "saturated",
    *(f"{channel}_{name}" for name in ("rise_s", "settling_s", "overshoot_pct") for channel, _ in _CHANNELS),
    *(f"{channel}_steady_error_{unit}" for channel, unit in _CHANNELS),
    "lateral_load_factor",
    "normal_load_factor",
)  # in the order in which `_judge` writes them
_TYPES = {"is_success": np.bool_, "left_envelope": np.bool_, "legs_judged": np.int64}  # others: float


@kernel
def _judge(states, params, found):  # type: ignore[no-untyped-def]
    """Write the metrics of every record, each into a row of `found`."""
    after = np.empty_like(states[:1])
    for i in range(states.shape[0]):
        after[0] = states[i]
        state = after[0]
        finish_episode(state, params)
        steps, legs = max(1, state.steps), max(1, state.legs)
        found[0, i] = not state.lost and state.legs_held == state.legs and state.legs > 0
        found[4, i] = state.in_band / steps
        found[5, i] = state.movement_sum / steps
        found[6, i] = state.lost
        found[7, i] = state.legs
        found[8, i] = state.legs_held / legs
        found[9, i] = state.saturated / (3.0 * steps)
        for channel in range(3):
            responses = max(1, state.responses[channel])
            found[1 + channel, i] = state.error_sum[channel] / steps * _UNITS[channel]
            found[10 + channel, i] = state.rise_sum[channel] * params.dt / responses
            found[13 + channel, i] = state.settling_sum[channel] * params.dt / responses
            found[16 + channel, i] = 100.0 * state.overshoot_sum[channel] / responses
            found[19 + channel, i] = state.steady_sum[channel] / legs * _UNITS[channel]
        found[22, i] = state.lateral_peak
        found[23, i] = state.normal_peak


@kernel
def take_loads(state, pull):  # type: ignore[no-untyped-def]
    """Take the load factors after a control interval; `pull`: mean vertical acceleration in it [m/s^2]."""
    turn, speed = state.turn_rate, state.speed
    state.lateral_peak = max(state.lateral_peak, abs(lateral_load_factor(turn, speed)))
    state.normal_peak = max(state.normal_peak, normal_load_factor(turn, speed, pull))


@kernel
def count_step(state, action, errors, movement, params, envelope, energy):  # type: ignore[no-untyped-def]
    """Take an interval's action, the errors (3) at its end and the mean `movement` of the commands."""
    inside = True
    for channel in range(3):
        size = abs(errors[channel])
        state.error_sum[channel] += size
        inside = inside & (size <= BAND[channel])
    limited = to_int(abs(action[0]) >= SATURATED) + to_int(abs(action[2]) >= SATURATED)
    at_limit = abs(action[1]) >= SATURATED
    if energy is not None:
        at_limit = at_limit | _gives_way(state, action, params, envelope, energy)
    state.saturated += limited + to_int(at_limit)
    state.movement_sum += movement
    state.in_band += to_int(inside)
    watch_leg(state, params, errors, inside)


@kernel
def _gives_way(state, action, params, envelope, energy):  # type: ignore[no-untyped-def]
    """Whether the commanded acceleration is changed by the shared power."""
    _, given, _, _ = commanded_rates(state, action, params, envelope, energy)
    _, asked, _, _ = commanded_rates(state, action, params, envelope, None)
    return given != asked


def metrics(states: np.ndarray, scene: Scene) -> dict[str, np.ndarray]:
    """Domain metrics of episodes, one value per record; all finite.

    altitude_error_m, airspeed_error_m_s, heading_error_deg: mean absolute errors (the integral of the absolute error
    per second); time_in_band: share of the time with all three errors within 15 m, 1 m/s and 0.5 deg; movement:
    mean change of the commands per interval; saturated: share of the commands at their limits (or, of
    accelerations, changed by the shared power); left_envelope.

    Of the legs, as `autopilot_legs` judges them: legs_judged: how many there were, with none the others are 0;
    legs_held: share of them that ended with all three channels held in band for 10 s; per channel ..._rise_s,
    ..._settling_s, ..._overshoot_pct (means over its steps, 0 if it had none) and ..._steady_error (mean over the
    legs). lateral_load_factor, normal_load_factor: largest ones, `vr_envs.models.load_factor`, with the vertical
    acceleration's mean over an interval.

    is_success: never left the envelope, and every leg held (at least one).
    """
    found = np.empty((len(_NAMES), len(states)))
    _judge(states, scene.records()[0], found)
    named: dict[str, np.ndarray] = dict(zip(_NAMES, found, strict=True))
    return named | {name: named[name].astype(kind) for name, kind in _TYPES.items()}
