"""The autopilot task: hold demanded altitude, airspeed and heading with smooth commands."""

from __future__ import annotations

import dataclasses
import math

from vr_envs.envs.autopilot_demands import NEVER, START_DRAWS, Demands, change_demands, change_is_due, demands_at
from vr_envs.envs.autopilot_legs import LegState, begin_leg, finish_leg
from vr_envs.envs.autopilot_metrics import count_step, metrics, take_loads
from vr_envs.envs.autopilot_observation import BAND, channels, errors, observe
from vr_envs.envs.autopilot_plan import Plan, fly_leg
from vr_envs.envs.autopilot_scenes import LEVELS, SCENES, action_channels, validate
from vr_envs.envs.autopilot_sensing import MEASURED, RING, Sensing, remember
from vr_envs.envs.batch import BatchEnv
from vr_envs.envs.scalar import ScalarEnv
from vr_envs.envs.scene import Scene
from vr_envs.envs.task import Lockstep, Metrics, Task
from vr_envs.models import autopilot as model
from vr_envs.models.atmosphere import airspeed, highest_airspeed, true_airspeed
from vr_envs.models.autopilot import left_envelope, wrap
from vr_envs.models.autopilot_options import OPTIONS
from vr_envs.models.jit import kernel
from vr_envs.models.lane_records import lane, lane_count
from vr_envs.models.lanes import any_lane, negate, to_float, where
from vr_envs.models.noise import uniform
from vr_envs.models.record import quantity
from vr_envs.models.turbulence import blow, start_gusts

# mean command change per interval at which, and share of the score that, restless commands cost
RESTLESS = 0.5
RESTLESS_COST = 0.1
THIRD = 1.0 / 3.0  # a kernel multiplies: division by a constant is several times slower


@dataclasses.dataclass(frozen=True)
class State(LegState):
    """The whole episode: aircraft, demands, the last two actions, and the sums from which metrics follow."""

    action: float = quantity(0.0, "", "last action", shape=(3,))
    earlier_action: float = quantity(0.0, "", "the action before", shape=(3,))
    error_sum: float = quantity(0.0, "m, m/s, rad", "sum of |error| over the steps", shape=(3,))
    movement_sum: float = quantity(0.0, "", "sum of the mean command change")
    saturated: int = quantity(
        0, "", "commands at their limits, or accelerations that gave way to the shared power", low=0
    )
    lateral_peak: float = quantity(0.0, "", "largest lateral load factor, either way", low=0.0)
    normal_peak: float = quantity(0.0, "", "largest normal load factor, in the mean over an interval", low=0.0)
    in_band: int = quantity(0, "", "steps with all three errors within the band", low=0)
    lost: bool = quantity(False, "", "the aircraft has left the envelope")
    past: float = quantity(0.0, "m, m/s, rad, ...", "past values for late instruments", shape=(RING, MEASURED))


@kernel
def _errors(state, atmosphere):  # type: ignore[no-untyped-def]
    return errors(state.demand, state.altitude, airspeed(state.altitude, state.speed, atmosphere), state.heading)


@kernel
def _change_leg(state, params, envelope, atmosphere, demands, plan, metrics):  # type: ignore[no-untyped-def]
    """Begin the next leg of the programme, or one without an end where there is none."""
    old_altitude, old_speed, old_heading = state.demand[0], state.demand[1], state.demand[2]
    if demands is not None:
        change_demands(state, params, envelope, atmosphere, demands)
    elif plan is not None:
        fly_leg(state, params, plan)
    else:
        state.next_change = NEVER
    if metrics is not None:
        jumps = errors(state.demand, old_altitude, old_speed, old_heading)
        begin_leg(state, params, _errors(state, atmosphere), jumps)


@kernel
def start(
    state, params, envelope, energy, lags, atmosphere, wind, shear, turbulence, track, textbook, demands, plan,
    sensing, metrics,
):  # type: ignore[no-untyped-def]  # fmt: skip
    """Level flight on the first waypoint or anywhere in the operating range; the first leg begins at once."""
    if plan is None:
        state.altitude = params.altitude_low + (params.altitude_high - params.altitude_low) * uniform(
            state.key, START_DRAWS
        )
        highest = highest_airspeed(state.altitude, params, atmosphere)
        state.demand[1] = params.speed_low + (highest - params.speed_low) * uniform(state.key, START_DRAWS + 1)
        state.heading = math.pi * (2.0 * uniform(state.key, START_DRAWS + 2) - 1.0)
    else:
        state.altitude, state.demand[1], state.heading = plan.altitude[0], plan.airspeed[0], wrap(plan.heading[0])
    state.speed = true_airspeed(state.altitude, state.demand[1], atmosphere)
    state.demand[0], state.demand[2] = state.altitude, state.heading
    for channel in range(3):
        state.demand_target[channel] = state.demand[channel]
    if turbulence is not None:
        start_gusts(state, START_DRAWS // 2 + 2, turbulence, track)
    if track is not None:
        state.x, state.z = track.x, track.z
    _change_leg(state, params, envelope, atmosphere, demands, plan, metrics)
    if sensing is not None:
        remember(state, atmosphere)


@kernel
def advance(
    state, action, params, envelope, energy, lags, atmosphere, wind, shear, turbulence, track, textbook,
    demands, plan, sensing, metrics,
):  # type: ignore[no-untyped-def]  # fmt: skip
    """Aircraft and ramping demands over one control interval."""
    before = state.vertical_speed
    model.advance(state, action, params, envelope, energy, lags, atmosphere, wind, shear, turbulence, track, textbook)
    _settle(state, before, params, demands, plan, metrics)


@kernel
def ready(
    state, params, envelope, energy, lags, atmosphere, wind, shear, turbulence, track, textbook,
    demands, plan, sensing, metrics,
):  # type: ignore[no-untyped-def]  # fmt: skip
    """Whether the aircraft flies the next control interval in one piece."""
    return model.even(state, params, envelope, energy, shear, textbook)


@kernel
def advance_evenly(
    state, action, params, envelope, energy, lags, atmosphere, wind, shear, turbulence, track, textbook,
    demands, plan, sensing, metrics,
):  # type: ignore[no-untyped-def]  # fmt: skip
    """`advance` of a record that is ready, on lanes too."""
    before, altitude, speed, heading = state.vertical_speed, state.altitude, state.speed, state.heading
    model.advance_evenly(state, action, params, envelope, energy, lags, wind, track)
    if turbulence is not None:
        blow(state, altitude, speed, heading, params.dt, turbulence, track)
    _settle(state, before, params, demands, plan, metrics)


@kernel
def _settle(state, before, params, demands, plan, metrics):  # type: ignore[no-untyped-def]
    """After the aircraft has moved, from the vertical speed `before` [m/s]: load factors, and demands that ramp."""
    if metrics is not None:
        take_loads(state, (state.vertical_speed - before) * (1.0 / params.dt))
    if demands is not None or plan is not None:
        demands_at(state, to_float(state.steps + 1) * params.dt)


@kernel
def outcome(
    state, action, params, envelope, energy, lags, atmosphere, wind, shear, turbulence, track, textbook,
    demands, plan, sensing, metrics,
):  # type: ignore[no-untyped-def]  # fmt: skip
    """Score the interval that has ended; then, when due, change the demands."""
    away = _errors(state, atmosphere)
    closeness, movement = 0.0, 0.0
    for channel in range(3):
        command, last = action[channel], state.action[channel]
        closeness += BAND[channel] / (BAND[channel] + abs(away[channel]))
        movement += abs(command - last)
        state.earlier_action[channel] = last
        state.action[channel] = command
    movement *= THIRD
    lost = left_envelope(state, params, atmosphere)
    state.lost = lost
    if metrics is not None:
        count_step(state, action, away, movement, params, envelope, energy)
    calm = 1.0 - min(RESTLESS_COST / RESTLESS * movement, RESTLESS_COST)
    reward = where(lost, 0.0, THIRD * closeness * calm)
    if demands is not None or plan is not None:
        due = change_is_due(state, params) & negate(lost)
        if any_lane(due):
            for k in range(lane_count(state)):
                if lane(due, k):
                    record = lane(state, k)
                    if metrics is not None:
                        finish_leg(record, params)
                    _change_leg(record, params, envelope, atmosphere, demands, plan, metrics)
    if sensing is not None:
        remember(state, atmosphere)
    return reward, lost


def _lockstep_possible(scene: Scene) -> bool:
    """Quadrature of the track behind lags, shear, instruments and the textbook's steps go record by record."""
    present = {name for name, option in scene.options.items() if option is not None}
    return not present & {"shear", "textbook", "sensing"} and not {"lags", "track"} <= present


def _control_interval(scene: Scene) -> float:
    return scene.params.dt


TASK = Task(
    name="autopilot",
    params=model.Params,
    options={**OPTIONS, "demands": Demands, "plan": Plan, "sensing": Sensing, "metrics": Metrics},
    state=State,
    scenes=SCENES,
    default_scene="airliner",
    levels=LEVELS,
    start=start,
    advance=advance,
    outcome=outcome,
    observe=observe,
    observation_channels=channels,
    action_channels=action_channels,
    metrics=metrics,
    dt=_control_interval,
    validate=validate,
    engines={"textbook": OPTIONS["textbook"]},
    rivals=(("demands", "plan"),),
    lockstep=Lockstep(_lockstep_possible, ready, advance_evenly),
)


class AutopilotEnv(ScalarEnv):
    """Fly an airliner to demanded altitude, airspeed and heading.

    ## Description
    The first-order aircraft of the lecture (virtual environments, after Vince 1995): a point with altitude, airspeed
    and heading, whose vertical speed, acceleration and turn rate are commanded within limits. The default scene is
    an airliner of about 100 t: its rates lag behind the commands, its limits depend on altitude and speed, climbing
    and accelerating draw on one power, airspeeds are equivalent ones in the standard atmosphere, and turbulence
    disturbs it. The demands change every 40 to 120 s. Motion over a control interval (1 s) is exact.

    ## Action Space
    `Box(-1, 1, (3,), float32)`, held over the interval:

    | # | command | -1 | 1 |
    |---|---|---|---|
    | 0 | vertical speed | descent limit, 10 m/s | climb limit, 13 m/s at sea level, 6 m/s at 11 km |
    | 1 | true acceleration | -0.6 m/s^2 | 0.6 m/s^2 |
    | 2 | turn rate | -3 deg/s, or what 25 deg of bank allow | as much to the other side (z towards x) |

    With the option `energy` the acceleration gives way, so that the commanded g v_y + v a stays between -8 m/s and
    the climb limit, times g.

    ## Observation Space
    `Box(-1, 1, (23,), float32)`; e = demand - value, the heading's the short way round; band b = 15 m, 1 m/s,
    0.5 deg; channels in the order altitude, airspeed, heading; the airspeed is the equivalent one with the option
    `atmosphere`, the true one otherwise:

    | # | quantity | unit | value |
    |---|---|---|---|
    | 0-2 | error, logarithmic | m, m/s, rad | sign(e) ln(1 + abs(e) / b) / ln(1 + s / b), s = 15 km, 300 m/s, pi |
    | 3-5 | error, near | m, m/s, rad | e / (b + abs(e)) |
    | 6-8 | lead error e - lag (rate - demand rate) | m, m/s, rad | as 3-5; the rate is that of the value |
    | 9-11 | vertical speed, true acceleration, turn rate | m/s, m/s^2, rad/s | in units of the largest limit |
    | 12-14 | rates of change of the demands | m/s, m/s^2, rad/s | in units of the largest limit |
    | 15 | airspeed | m/s | -1 at the stall speed (60), 1 at the top speed (185) |
    | 16 | altitude | m | -1 at 0, 1 at the ceiling (13000) |
    | 17-19 | last action | 1 | as given |
    | 20-22 | the action before | 1 | as given |

    Values are clipped to [-1, 1]. `vr_envs.envs.autopilot_observation.read` turns a batch back into SI units. With the
    option `sensing` all but the demands and actions are late and have errors.

    ## Rewards
    Mean over the channels of b / (b + abs(e)) at the end of the interval, times 1 - 0.1 min(c / 0.5, 1), where c is
    the mean change of the three commands: 1 is perfect, 0 when the aircraft leaves the envelope.

    ## Starting State
    Level flight without turn, altitude uniform in 300 to 11000 m, equivalent airspeed in 75 to 160 m/s (or to Mach
    0.79), any heading; gusts from their stationary distribution. The demands are that state with a first change. At
    each change every channel changes with probability 3/4, by 3 to 60 % of what can be reached until the next change;
    one change in four is a ramp over that time. Demands depend on the episode's key alone, not on the flight. With a
    flight plan the start is its first waypoint.

    ## Episode End
    Terminated: on the ground, below 60 or above 185 m/s of equivalent airspeed, above Mach 0.86 or the ceiling (13 km).
    Truncated: after 480 steps by the registered time limit.

    At the end `info` holds `is_success`: never left the envelope, and every leg between two changes (that lasts 20 s
    and ended) was held: all three errors within their bands throughout its last 10 s. Further the mean absolute
    `altitude_error_m`, `airspeed_error_m_s`, `heading_error_deg`; `time_in_band`; `movement` (mean command change per
    step); `left_envelope`; `saturated` (share of the commands); `legs_judged` (their number; with none the rest is 0)
    and `legs_held` (share); for each channel `..._rise_s`, `..._settling_s`, `..._overshoot_pct` and
    `..._steady_error_...` (`vr_envs.envs.autopilot_legs` defines them); the peaks `lateral_load_factor` and
    `normal_load_factor`.

    ## Arguments
    - `scene`: "airliner" (default), "airliner-rough" (with wind, shear, ground track, instruments and more turbulence),
      "lecture" (constant limits, rates follow at once, still air, true airspeeds, with ground track), or a dict of
      overrides: the fields of `vr_envs.models.autopilot.Params`, and the options `envelope` (limits that depend on
      altitude and speed), `energy`, `lags`, `atmosphere`, `wind`, `shear`, `turbulence`, `track` (ground track x, z),
      `demands` (random ones; without a programme the demands stay what the flight starts with), `plan` (a flight plan
      in their place, also as the path of a CSV file) and `sensing` (errors and delay of the instruments), each null,
      true or a dict of its fields. Angles in rad.
    - `engine`: "exact" (default) or "textbook" (the lecture's recurrence at a chosen step; knows no lags and no air
      that moves).
    - `render_mode`: None, "rgb_array" or "human".

    ## Version History
    - v1: equivalent airspeeds in the ISA; Dryden turbulence in place of first-order gusts; limits renewed once per
      second of flight; demands that do not depend on the control interval; success is judged leg by leg.
    - v0: first version.
    """

    task = TASK


class AutopilotBatchEnv(BatchEnv):
    """Many `AutopilotEnv` in one call; see there."""

    task = TASK
