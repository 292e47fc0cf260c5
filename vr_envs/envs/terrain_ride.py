"""The ride task: carry a mass over rough ground softly, within the travel that the spring has."""

from __future__ import annotations

import dataclasses
from typing import Any

from vr_envs.envs.batch import BatchEnv
from vr_envs.envs.scalar import ScalarEnv
from vr_envs.envs.scene import Scene
from vr_envs.envs.task import Lockstep, Metrics, Task
from vr_envs.envs.terrain_ride_engines import ENGINES
from vr_envs.envs.terrain_ride_metrics import metrics
from vr_envs.envs.terrain_ride_observation import (
    Preview,
    SensorNoise,
    action_channels,
    channels,
    lateness,
    observe,
)
from vr_envs.envs.terrain_ride_rules import validate
from vr_envs.models import terrain_ride as model
from vr_envs.models.jit import kernel
from vr_envs.models.lanes import where
from vr_envs.models.noise import uniform
from vr_envs.models.record import quantity
from vr_envs.models.ride_options import ActuatorLag, Cruise, Payload, Textbook, Tyre
from vr_envs.models.road import start_road
from vr_envs.models.road_options import Bumps, Obstacle, Profile, Road, Wheel
from vr_envs.models.terrain import Undulation, start_undulation
from vr_envs.models.travel_stop import TravelStop

_PAYLOAD_DRAW = 1 << 49

ROAD: dict[str, Any] = {
    "road": True,
    "bumps": True,
    "stop": True,
    "payload": True,
    "lag": True,
    "preview": True,
    "noise": True,
    "metrics": True,
}
QUARTER_CAR: dict[str, Any] = {
    **ROAD,
    "damping_low": 1.0,
    "damping_high": 14.0,
    "comfort": 1.5,
    "tyre": True,
    "road": {"knot_spacing": 0.1},
}


@dataclasses.dataclass(frozen=True)
class State(model.State):
    """The whole episode: the ride and what is counted of it."""

    hits: int = quantity(0, "", "touches of a stop so far", low=0)


@kernel
def start(
    state, params, undulation, road, profile, bumps, obstacle, wheel, tyre, stop, payload, lag, cruise,
    preview, noise, textbook, metrics,
):  # type: ignore[no-untyped-def]  # fmt: skip
    """At rest where spring and tyre balance the payload, actuators at mid-range."""
    if undulation is not None:
        start_undulation(state)
    if road is not None:
        start_road(state, road, profile, bumps, obstacle, wheel)
    if payload is not None:
        state.payload = payload.size * (2.0 * uniform(state.key, _PAYLOAD_DRAW) - 1.0)
    model.rest(state, params, tyre)


@kernel
def advance(
    state, action, params, undulation, road, profile, bumps, obstacle, wheel, tyre, stop, payload, lag, cruise,
    preview, noise, textbook, metrics,
):  # type: ignore[no-untyped-def]  # fmt: skip
    """The ride over one control interval."""
    model.advance(
        state, action, params,
        undulation, road, profile, bumps, obstacle, wheel, tyre, stop, lag, cruise, textbook, metrics,
    )  # fmt: skip


@kernel
def ready(
    state, params, undulation, road, profile, bumps, obstacle, wheel, tyre, stop, payload, lag, cruise,
    preview, noise, textbook, metrics,
):  # type: ignore[no-untyped-def]  # fmt: skip
    """Whether the next control interval is one whole tick."""
    return model.even(state, params)


@kernel
def advance_evenly(
    state, action, params, undulation, road, profile, bumps, obstacle, wheel, tyre, stop, payload, lag, cruise,
    preview, noise, textbook, metrics,
):  # type: ignore[no-untyped-def]  # fmt: skip
    """`advance` of a record that is ready, on lanes too."""
    model.advance_evenly(state, action, params, undulation, road, profile, bumps, obstacle, wheel, stop, lag, metrics)


@kernel
def outcome(
    state, action, params, undulation, road, profile, bumps, obstacle, wheel, tyre, stop, payload, lag, cruise,
    preview, noise, textbook, metrics,
):  # type: ignore[no-untyped-def]  # fmt: skip
    """Score the interval that has ended: comfort and travel together, nothing in contact with a stop."""
    discomfort, stroke = state.weighted * (1.0 / params.comfort), state.travel * (1.0 / params.rattle)
    reward = 1.0 / (1.0 + discomfort * discomfort + stroke * stroke)
    if cruise is not None:
        late = max(0.0, lateness(state, params, cruise)) / cruise.lateness
        reward /= 1.0 + late * late
    ended = state.fault != 0
    if stop is not None:
        state.hits += state.touches
        reward = where((state.side != 0.0) | (state.touches > 0), 0.0, reward)
        ended = ended | (abs(state.travel) > stop.travel + stop.crush)
    return where(state.fault != 0, 0.0, reward), ended


def _lockstep_possible(scene: Scene) -> bool:
    """Contacts of a tyre, a choice of speed, sines on a road and what is rare on one go record by record."""
    present = {name for name, option in scene.options.items() if option is not None}
    rare = {"tyre", "cruise", "textbook", "profile", "obstacle", "wheel"}
    return not present & rare and not {"undulation", "road"} <= present


def _control_interval(scene: Scene) -> float:
    return scene.params.dt


TASK = Task(
    name="terrain_ride",
    params=model.Params,
    options={
        "undulation": Undulation,
        "road": Road,
        "profile": Profile,
        "bumps": Bumps,
        "obstacle": Obstacle,
        "wheel": Wheel,
        "tyre": Tyre,
        "stop": TravelStop,
        "payload": Payload,
        "lag": ActuatorLag,
        "cruise": Cruise,
        "preview": Preview,
        "noise": SensorNoise,
        "textbook": Textbook,
        "metrics": Metrics,
    },
    state=State,
    scenes={
        "road": ROAD,
        "quarter-car": QUARTER_CAR,
        "active": {**QUARTER_CAR, "actuation": "active", "passive_damping": 3.0},
        "journey": {
            **ROAD,
            "speed": 15.0,
            "cruise": {"fastest": 25.0, "schedule": 15.0},
            "preview": {"horizon": 1.6, "samples": 20},
        },
        "lecture": {"undulation": True, "damping": "absolute", "metrics": True},
    },
    default_scene="road",
    levels={
        "nominal": {},
        "light": {"payload": {"size": 1.5}, "bumps": {"stretch": 20.0}},
        "severe": {"road": {"iso_class": "D"}},
    },
    start=start,
    advance=advance,
    outcome=outcome,
    observe=observe,
    observation_channels=channels,
    action_channels=action_channels,
    metrics=metrics,
    dt=_control_interval,
    validate=validate,
    engines=ENGINES,
    lockstep=Lockstep(_lockstep_possible, ready, advance_evenly),
)


class TerrainRideEnv(ScalarEnv):
    """Carry a mass over rough ground softly, within the travel of its spring, by setting damping and modulus.

    ## Description
    A mass rides on a spring and damper over a wheel that follows the terrain (the lecture on virtual environments,
    after Vince 1995: a spring whose parameters can be changed while it runs). Softness and travel pull in opposite
    directions: a hard damper passes the road's roughness on, a soft one lets the mass swing against its stops. The
    default scene is a quarter of a car, 290 kg at 20 m/s on an ISO 8608 road of class C with bumps and dips, with
    rubber stops at 80 mm of travel, an unknown payload, lagging actuators and 0.3 s of the road ahead in view. The
    spring acts about its levelled equilibrium, so that a change of modulus does not lift the mass. Motion over a
    control interval (`dt`, 0.01 s) is exact, contacts with the stops included. Actuators that lag, the frequency
    weighting and the metrics work at ticks of 0.01 s, whatever the control interval is.

    ## Action Space
    `Box(-1, 1, (2,), float32)`, logarithmic, 0 is the geometric mean of both ends:

    | # | command | -1 | 1 |
    |---|---|---|---|
    | 0 | damping c/m between mass and wheel | 0.3 1/s | 10 1/s |
    | 1 | modulus of the spring, as a fraction of 16812 N/m | 0.5 | 2 |

    In the scene "quarter-car" the damping is 1 to 14 1/s. In "active", `Box(-1, 1, (1,), float32)`: a force between
    mass and wheel, -1450 N (pulls the mass down) to 1450 N, beside the spring at modulus 1 and a damping of 3 1/s. In
    "journey" one action more, the last: the speed, linear, 5 m/s at -1 to 25 m/s at 1; it goes there at 3 m/s^2.

    ## Observation Space
    `Box(float32)` of 17 numbers; numbers 0-4 and the road within [-5, 5], the actuators in [-1, 1]. Sensor errors are
    uniform with the standard deviation given.

    | # | quantity | unit | 1 stands for | error |
    |---|---|---|---|---|
    | 0 | travel: height of the mass over the wheel, from levelled rest | m | 0.05 m | 0.5 mm |
    | 1 | travel rate, mean over the last tick | m/s | 0.5 m/s | 0.02 m/s |
    | 2 | vertical velocity of the mass | m/s | 0.5 m/s | 0.02 m/s |
    | 3 | vertical acceleration of the mass, mean over the last tick | m/s^2 | 2 m/s^2 | 0.1 m/s^2 |
    | 4 | the acceleration through the frequency weighting Wk of ISO 2631-1 | m/s^2 | 2 m/s^2 | none |
    | 5, 6 | present positions of the actuators, damping and modulus (5: of the force) | 1 | as the action | none |
    | 7-16 | height of the road 0.03, 0.06 ... 0.3 s ahead over the road under the wheel | m | 0.05 m | none |

    A tyre adds two numbers after the first five: its deflection (height of the hub over the ground from levelled rest;
    1 is 0.02 m, error 0.5 mm) and the hub's vertical velocity (1 is 1 m/s, error 0.05 m/s). A choice of speed adds two
    there: the speed (1 is the fastest one) and the distance behind the schedule (1 is `cruise.lateness`). The road
    ahead is then at fixed distances, 1.2 m to 24 m in "journey".

    `vr_envs.envs.terrain_ride_observation.read` turns a batch back into SI units.

    ## Rewards
    1 / (1 + (a / comfort)^2 + (u / rattle)^2) at the end of the interval, with the weighted acceleration a and the
    travel u: 1 is perfect. `rattle` is 30 mm, `comfort` 1 m/s^2, in "quarter-car" and "active" 1.5 m/s^2. 0 for an
    interval with a stop in contact. The load of a tyre is measured, not rewarded. With a schedule, times
    1 / (1 + (distance behind it / 5 m)^2); being early earns nothing.

    ## Starting State
    The mass at rest at the equilibrium that its payload gives, actuators at 0. Drawn for the episode: the payload,
    which gives a constant acceleration of up to 1 m/s^2 either way; the road's density, 256e-6 m^3 times 2^U(-1, 1),
    which spans the class; the road; one bump or dip of 30 to 80 mm in every 40 m.

    ## Episode End
    Terminated when, at a control instant, a stop's rubber is compressed by more than 15 mm (a compression that comes
    and goes within one interval does not count), or when a search for contacts, of a stop or a tyre, does not end
    (`fault`, reward 0). Truncated after 1000 steps by the registered time limit.

    At the end `info` holds `is_success` (no stop hit, rms acceleration below `comfort` and rms travel below `rattle`),
    `acceleration_rms_m_s2` (weighted), `unweighted_rms_m_s2`, `vdv_m_s175` (vibration dose), `jerk_rms_m_s3`,
    `travel_rms_mm`, `travel_peak_mm`, `stop_hits`, `force_rms_n` (of damper or force), `tyre_load_rms` (dynamic over
    static) and `airborne_fraction` (both 0 without a tyre), `mean_speed_m_s`, `lateness_m` and `fault`.

    ## Arguments
    - `scene`: "road" (default); "quarter-car" (the wheel has 59 kg and a tyre that pushes but does not pull, and leaves
      the ground); "active" (the same with a force); "journey" (over a wheel that follows the ground, the speed is an
      action and there is a schedule); "lecture" (the lecture's model and nothing else: three sines for terrain,
      damping of the mass's own velocity as its factor k_d has it, no stop, payload, lag, preview or sensor error); or
      a dict of overrides: the fields of `vr_envs.models.terrain_ride.Params`, and the options `undulation` (sines),
      `road` (`iso_class` "A" to "H" or "flat"), `profile` (heights, or the path of a CSV file), `bumps`, `obstacle`,
      `wheel` (of finite radius), `tyre`, `stop`, `payload`, `lag`, `cruise`, `preview`, `noise` and `metrics` (without
      it `info` stays empty), each null, true or a dict of its fields. docs/terrain_ride.md says what they are and which
      exclude each other.
    - `engine`: "exact" (default), "textbook" (the lecture's recurrence; it knows the lecture's vehicle alone), or
      "rigid_body" (Chipmunk bodies; not in a batch).
    - `render_mode`: None, "rgb_array" or "human".

    ## Version History
    - v0: first version.
    """

    task = TASK


class TerrainRideBatchEnv(BatchEnv):
    """Many `TerrainRideEnv` in one call; see there."""

    task = TASK
