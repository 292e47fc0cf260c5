"""What the aircraft must obey after a step, judged apart from the model: its ranges, and in still air its motion."""

from __future__ import annotations

import math

from vr_envs.envs.scene import Scene
from vr_envs.models.jit import kernel
from vr_envs.models.noise import uniform

REASONS = (
    "the airspeed is negative",
    "the heading is not within half a turn",
    "a rate is beyond its limit",
    "altitude, airspeed or heading is not that of the commands",
    "the ground track is not that of an integration",
)
_NEGATIVE, _HEADING, _RATE, _MOTION, _TRACK = range(1, len(REASONS) + 1)
ROUNDING = 1e-12  # of 10 km, 100 m/s or a turn
ALIKE = 1e-7  # of the way flown: the integration's own error is below
_PANELS = 100
_DEMANDS = 1 << 44  # counters of the demands, apart from the actions and the episodes


def facts_of(scene: Scene, jumping: bool = False) -> tuple[float, ...]:
    """What the check needs to know: the ends of the demands, if they jump, and the largest climb rate."""
    p, envelope = scene.params, scene.options["envelope"]
    ends = (1.0, p.ceiling, p.stall_speed, p.top_speed) if jumping else (0.0,) * 4
    climb = p.climb
    if envelope is not None and envelope.cruise_climb > climb:  # it grows with altitude
        climb = math.inf
    return (*ends, climb)


@kernel
def jumping_demands(state, settings, step):
    """Before every step put each demand to an end of the range that the facts give, if they do, with a new heading."""
    low, high, slow, fast, _ = settings.facts
    if high <= low:
        return
    draw = _DEMANDS + 3 * step
    state.demand[0] = low if uniform(settings.key, draw) < 0.5 else high
    state.demand[1] = slow if uniform(settings.key, draw + 1) < 0.5 else fast
    state.demand[2] = math.pi * (2.0 * uniform(settings.key, draw + 2) - 1.0)
    for channel in range(3):
        state.demand_target[channel], state.demand_rate[channel] = state.demand[channel], 0.0


@kernel
def in_range(before, state, action, params, facts):
    """(failure, 0, whether it stands): signs and limits, which hold in any air."""
    if state.speed < 0.0:
        return _NEGATIVE, 0.0, False
    if abs(state.heading) > math.pi + ROUNDING:
        return _HEADING, 0.0, False
    beyond = max(state.vertical_speed - facts[4], -params.descent - state.vertical_speed)
    beyond = max(beyond, state.acceleration - params.acceleration, -params.deceleration - state.acceleration)
    beyond = max(beyond, abs(state.turn_rate) - params.turn)
    return (0 if beyond <= 1e-9 else _RATE), 0.0, state.speed == 0.0


@kernel
def _turned(angle):
    """The same direction within half a turn."""
    return angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi) + 0.5)


@kernel
def lecture(before, state, action, params, facts):
    """(failure, rounding, whether it stands): constant rates over the interval, which follow at once."""
    code, _, stands = in_range(before, state, action, params, facts)
    if code != 0:
        return code, 0.0, stands
    rise = action[0] * (params.climb if action[0] > 0.0 else params.descent)
    gain = action[1] * (params.acceleration if action[1] > 0.0 else params.deceleration)
    turn = action[2] * params.turn
    speed = max(0.0, before.speed + gain * params.dt)
    error = max(abs(state.altitude - before.altitude - rise * params.dt) / 1e4, abs(state.speed - speed) / 100.0)
    error = max(error, abs(_turned(state.heading - before.heading - turn * params.dt)) / (2.0 * math.pi))
    # the angle turned is rounded as the number that it is
    if not error <= ROUNDING + 1e-16 * abs(turn * params.dt):
        return _MOTION, error, stands
    end = params.dt
    if gain < 0.0 and before.speed + gain * end < 0.0:
        end = -before.speed / gain
    panels = 2 * (_PANELS + int(20.0 * abs(turn) * end))
    h, x, z = end / panels, 0.0, 0.0
    for k in range(panels + 1):
        weight = 1.0 if k in (0, panels) else (4.0 if k % 2 else 2.0)
        way = weight * h / 3.0 * (before.speed + gain * h * k)
        x += way * math.sin(before.heading + turn * h * k)
        z += way * math.cos(before.heading + turn * h * k)
    apart = abs(state.x - before.x - x) + abs(state.z - before.z - z)
    way = before.speed * end + abs(before.x) + abs(before.z) + 1.0
    return (0 if apart <= ALIKE * way else _TRACK), error, stands
