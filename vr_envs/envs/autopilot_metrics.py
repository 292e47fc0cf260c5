"""What an episode of the autopilot is judged by, from the sums in its record."""

from __future__ import annotations

import numpy as np

from vr_envs.envs.autopilot_legs import finish_episodes, watch_leg
from vr_envs.envs.autopilot_observation import BAND
from vr_envs.envs.scene import Scene
from vr_envs.models.autopilot import commanded_rates
from vr_envs.models.jit import kernel
from vr_envs.models.lanes import to_int
from vr_envs.models.load_factor import lateral_load_factor, normal_load_factor

SATURATED = 0.999  # of the limit
# channel, unit, factor from the record's unit
_CHANNELS = (("altitude", "m", 1.0), ("airspeed", "m_s", 1.0), ("heading", "deg", np.degrees(1.0)))


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
    after = states.copy()
    finish_episodes(after, scene.records()[0])
    steps = np.maximum(states["steps"], 1)
    dt = scene.params.dt
    legs, responses = np.maximum(after["legs"], 1), np.maximum(after["responses"], 1)
    lost = states["lost"] != 0
    per_channel = {
        "error": (states["error_sum"] / steps[:, None], True),
        "rise_s": (after["rise_sum"] * dt / responses, False),
        "settling_s": (after["settling_sum"] * dt / responses, False),
        "overshoot_pct": (100.0 * after["overshoot_sum"] / responses, False),
        "steady_error": (after["steady_sum"] / legs[:, None], True),
    }
    found = {
        f"{channel}_{name}" + (f"_{unit}" if has_unit else ""): values[:, k] * (factor if has_unit else 1.0)
        for name, (values, has_unit) in per_channel.items()
        for k, (channel, unit, factor) in enumerate(_CHANNELS)
    }
    errors = {name: found.pop(name) for name in list(found)[:3]}
    return {
        "is_success": ~lost & (after["legs_held"] == after["legs"]) & (after["legs"] > 0),
        **errors,
        "time_in_band": states["in_band"] / steps,
        "movement": states["movement_sum"] / steps,
        "left_envelope": lost,
        "legs_judged": after["legs"].copy(),
        "legs_held": after["legs_held"] / legs,
        "saturated": states["saturated"] / (3.0 * steps),
        **found,
        "lateral_load_factor": states["lateral_peak"],
        "normal_load_factor": states["normal_peak"],
    }
