"""The autopilot's scenes: presets, what their actions command, and which values go together."""

from __future__ import annotations

from typing import Any

import numpy as np

from vr_envs.envs.autopilot_plan import check_plan
from vr_envs.envs.scene import Scene
from vr_envs.envs.task import Channel
from vr_envs.models.atmosphere import airspeed_of_mach, true_airspeed
from vr_envs.models.autopilot import State, left_envelope
from vr_envs.models.record import dtype_of

MOST_PIECES = 10_000  # renewals of the limits in a control interval, so that a step takes milliseconds at most

# its airspeeds are equivalent ones
_AIRLINER: dict[str, Any] = {
    "speed_low": 75.0,
    "speed_high": 160.0,
    "stall_speed": 60.0,
    "top_speed": 185.0,
    "envelope": True,
    "energy": True,
    "lags": True,
    "atmosphere": True,
    "turbulence": True,
    "demands": True,
    "metrics": True,
}
SCENES: dict[str, dict[str, Any]] = {
    "airliner": _AIRLINER,
    "airliner-rough": {
        **_AIRLINER,
        "turbulence": {"wind_20ft": 5.0, "sigma": 1.0},
        "wind": True,
        "shear": True,
        "track": True,
        "sensing": True,
    },
    "lecture": {"track": True, "demands": True, "metrics": True},
}
# light and moderate turbulence of MIL-F-8785C
LEVELS: dict[str, dict[str, Any]] = {
    "nominal": {},
    "light": {"turbulence": {"wind_20ft": 7.7, "sigma": 1.5}},
    "severe": {"turbulence": {"wind_20ft": 15.4, "sigma": 3.0}},
}


def action_channels(scene: Scene) -> tuple[Channel, ...]:
    """The three commands, each a fraction of its limit."""
    p = scene.params
    climbs = "" if scene.options["envelope"] is None else ", climb limit falling with altitude"
    turns = "" if scene.options["envelope"] is None else ", limited by bank"
    return (
        Channel("vertical speed command", "m/s", f"-1 descends at {p.descent:g}, 1 climbs at {p.climb:g} m/s{climbs}"),
        Channel("acceleration command", "m/s^2", f"-1 is -{p.deceleration:g}, 1 is {p.acceleration:g} m/s^2"),
        Channel("turn command", "rad/s", f"-1 is -{p.turn:.4g}, 1 is {p.turn:.4g} rad/s{turns}"),
    )


def validate(scene: Scene) -> None:
    """The ranges must be ordered, the operating range inside the envelope, and a plan possible."""
    p, demands = scene.params, scene.options["demands"]
    orders = [
        ("altitude_low", p.altitude_low, "altitude_high", p.altitude_high, False),
        ("altitude_high", p.altitude_high, "ceiling", p.ceiling, True),
        ("stall_speed", p.stall_speed, "top_speed", p.top_speed, True),
        ("stall_speed", p.stall_speed, "speed_low", p.speed_low, False),
        ("speed_low", p.speed_low, "speed_high", p.speed_high, False),
        ("speed_high", p.speed_high, "top_speed", p.top_speed, True),
    ]
    if (atmosphere := scene.options["atmosphere"]) is not None:
        top = airspeed_of_mach(atmosphere.mach_high, p.altitude_high)
        orders += [
            ("speed_low", p.speed_low, "the airspeed of atmosphere.mach_high at altitude_high", top, True),
            ("atmosphere.mach_high", atmosphere.mach_high, "atmosphere.top_mach", atmosphere.top_mach, True),
        ]
    if demands is not None:
        orders += [
            ("dt", p.dt, "demands.hold_low", demands.hold_low, False),
            ("demands.hold_low", demands.hold_low, "demands.hold_high", demands.hold_high, False),
            ("demands.share_low", demands.share_low, "demands.share_high", demands.share_high, False),
        ]
    renewing = any(scene.options[name] is not None for name in ("envelope", "energy", "shear"))
    if renewing:
        orders.append(("dt", p.dt, f"{MOST_PIECES} refresh", MOST_PIECES * p.refresh, False))
    if (textbook := scene.options["textbook"]) is not None:
        orders.append(("dt", p.dt, f"{MOST_PIECES * 10} textbook.step", 10.0 * MOST_PIECES * textbook.step, False))
    for low_name, low, high_name, high, strict in orders:
        if low > high or (strict and low == high):
            rule = "be below" if strict else "not exceed"
            raise ValueError(f"{low_name} = {low:g} is not allowed; it must {rule} {high_name} = {high:g}")
    if scene.options["plan"] is not None:
        _check_waypoints(scene)


def _check_waypoints(scene: Scene) -> None:
    """Every waypoint must lie inside the envelope."""
    plan, (params, options) = scene.options["plan"], scene.records()
    atmosphere = options[list(scene.options).index("atmosphere")]
    check_plan(plan)
    aircraft = np.zeros(1, dtype_of(State))[0]
    for i, (altitude, speed) in enumerate(zip(plan.altitude, plan.airspeed, strict=True)):
        aircraft["altitude"], aircraft["speed"] = altitude, true_airspeed(altitude, speed, atmosphere)
        if left_envelope(aircraft, params, atmosphere):
            raise ValueError(
                f"waypoint {i} of the plan, {altitude:g} m at {speed:g} m/s, is not allowed; it must be above the "
                f"ground, below the ceiling ({params['ceiling']:g} m), between stall_speed "
                f"({params['stall_speed']:g} m/s) and top_speed ({params['top_speed']:g} m/s), and below the Mach "
                "number where the aircraft breaks up"
            )
