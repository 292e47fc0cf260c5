"""Task: keep a bouncing ball at the centre of a bar by choosing the bar's motion."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from vr_envs.envs.ball_on_bar_engines import ENGINES
from vr_envs.envs.ball_on_bar_observation import observations, observe
from vr_envs.envs.batch import BatchEnv
from vr_envs.envs.scalar import ScalarEnv
from vr_envs.envs.scene import Scene
from vr_envs.envs.task import Channel, Task
from vr_envs.models.ball_on_bar import Params as BarParams
from vr_envs.models.ball_on_bar import State as BallState
from vr_envs.models.ball_on_bar import advance
from vr_envs.models.ball_options import OPTIONS
from vr_envs.models.ball_sensors import ages_of, sense_start
from vr_envs.models.jit import kernel
from vr_envs.models.noise import uniform
from vr_envs.models.record import quantity

_START_COUNTER = 1 << 62  # apart from the impact counter, which the scatter uses


@dataclasses.dataclass(frozen=True)
class Params(BarParams):
    """The model's parameters and the task's."""

    start_min: float = quantity(0.003, "m", "smallest |x| at the start", low=0.0, high=10.0)
    start_max: float = quantity(0.015, "m", "largest |x| at the start", low=0.0, high=10.0)
    reward_width: float = quantity(
        0.002, "m", "distance at which the reward has fallen to one half", low=1e-6, high=1.0
    )


@dataclasses.dataclass(frozen=True)
class State(BallState):
    """The ball, the bar, and the sums from which the metrics follow."""

    sum_x2: float = quantity(0.0, "m^2", "sum of x^2 over control intervals")
    max_x: float = quantity(0.0, "m", "largest |x| at the end of an interval")


@kernel
def start(state, params, scatter, spin, friction, softening, curve, frequencies, ramp, sensing, camera, textbook):
    """Ball displaced along the bar, on the vertical period-one orbit of the bar's motion at action 0.

    It is the orbit of a constant restitution and of z at twice the base frequency.

    Impacts happen at the phase phi of sin(2 omega t + pi/2) with cos(phi) = pi g (1 - alpha)/(1 + alpha)/Acc; below
    the smallest acceleration at which the orbit exists the nearest phase, 0, is taken.
    """
    acceleration = 4.0 * params.omega * params.omega * params.z_centre
    needed = math.pi * params.gravity * (1.0 - params.restitution) / (1.0 + params.restitution)
    phase = math.acos(min(1.0, needed / acceleration)) if acceleration > 0.0 else 0.0
    since = (0.5 * math.pi - phase) / (2.0 * params.omega)
    launch = 0.25 * params.gravity * params.period
    size = params.start_min + (params.start_max - params.start_min) * uniform(state.key, _START_COUNTER)
    state.x = size if uniform(state.key, _START_COUNTER + 1) < 0.5 else -size
    state.z = params.z_centre * math.sin(phase) + (launch - 0.5 * params.gravity * since) * since
    state.w = launch - params.gravity * since
    state.motion[4] = params.z_centre
    if curve is not None:
        state.z += 0.5 * curve.curvature * state.x * state.x
    sense_start(state, params.gravity, sensing, camera)


@kernel
def outcome(state, action, params, *_options):
    """(reward, terminated): 1 / (1 + (x / width)^2), and 0 with the end of the episode when the ball is lost."""
    state.sum_x2 += state.x * state.x
    state.max_x = max(state.max_x, abs(state.x))
    if state.lost or state.fault:
        return 0.0, True
    offset = state.x / params.reward_width
    return 1.0 / (1.0 + offset * offset), False


def _actions(scene: Scene) -> tuple[Channel, ...]:
    p = scene.params
    return (
        Channel("x in phase", f"{p.x_acceleration:g} m/s^2", "cosine part of x, as peak acceleration"),
        Channel("x quadrature", f"{p.x_acceleration:g} m/s^2", "sine part of x"),
        Channel("tilt in phase", f"{p.tilt_acceleration:g} rad/s^2", "cosine part of the tilt"),
        Channel("tilt quadrature", f"{p.tilt_acceleration:g} rad/s^2", "sine part of the tilt"),
        Channel(
            "z in phase", f"{p.z_acceleration_span:g} m/s^2", f"cosine part of z, added to {p.z_acceleration:g} m/s^2"
        ),
        Channel("z quadrature", f"{p.z_acceleration_span:g} m/s^2", "sine part of z"),
    )


def _metrics(states: np.ndarray, scene: Scene) -> dict[str, np.ndarray]:
    steps = np.maximum(states["steps"], 1)
    rms = np.sqrt(states["sum_x2"] / steps)
    on_bar = (states["lost"] == 0) & (states["fault"] == 0)
    return {
        "is_success": on_bar & (rms <= 0.002),
        "on_bar": on_bar,
        "rms_x_mm": 1e3 * rms,
        "max_x_mm": 1e3 * states["max_x"],
        "impacts_per_cycle": states["impacts"] / (steps * scene.params.hold),
        "fault": states["fault"] != 0,
    }


def _interval(scene: Scene) -> float:
    return scene.params.hold * scene.params.period


def _validate(scene: Scene) -> None:
    p = scene.params
    if p.start_min > p.start_max or p.start_max >= p.half_length:
        raise ValueError(
            f"start_min = {p.start_min:g}, start_max = {p.start_max:g}, half_length = {p.half_length:g}: "
            "give start_min <= start_max < half_length"
        )
    if p.tilt_span > 0.3:
        raise ValueError(
            f"tilt_acceleration = {p.tilt_acceleration:g} rad/s^2 at frequency = {p.frequency:g} Hz is a tilt of "
            f"{p.tilt_span:.3g} rad; give at most 0.3 rad, which is {0.3 * p.omega**2:.4g} rad/s^2"
        )
    if p.hold not in (0.5, round(p.hold)):
        raise ValueError(f"hold = {p.hold:g} cycles; give 0.5 or a whole number")
    if p.blend > p.hold:
        raise ValueError(f"blend = {p.blend:g} is longer than hold = {p.hold:g}; give blend <= hold")
    curve, camera = scene.options["curve"], scene.options["camera"]
    if curve is not None and abs(curve.curvature) * p.half_length > 1.0:
        raise ValueError(
            f"curve.curvature = {curve.curvature:g} 1/m at half_length = {p.half_length:g} m is steeper than 45 "
            f"degrees; give at most {1.0 / p.half_length:.4g} 1/m"
        )
    longest = min(1.0, p.hold) * p.period
    if camera is not None:
        tall, wide = (0.5 * n * camera.resolution - camera.ball_radius for n in (camera.rows, camera.columns))
        if abs(camera.height) > tall or wide < 0.0:
            raise ValueError(
                f"camera: the ball at rest is not in the picture of {camera.columns} x {camera.rows} pixels of "
                f"{camera.resolution:g} m at height = {camera.height:g} m; give more pixels, or a smaller height"
            )
    age, _ = ages_of.py_func(scene.options["sensing"], camera)
    if age > longest:
        raise ValueError(
            f"{scene.observation} looks {age:.4g} s before the observation; give a delay (or a latency and the time "
            f"between two frames) of at most {longest:.4g} s, the last base cycle or the interval"
        )


TASK = Task(
    name="ball_on_bar",
    params=Params,
    options=OPTIONS,
    state=State,
    scenes={
        "bell": {"scatter": True},
        "bell-2dof": {"scatter": True, "x_acceleration": 0.0},
        "rolling": {"scatter": {"normal": 0.003}, "spin": True},
        "lens": {"scatter": True, "spin": True, "curve": True},
    },
    default_scene="bell",
    levels={
        "nominal": {},
        "light": {"scatter": {"restitution": 0.03, "normal": 0.004}},
        "severe": {"scatter": {"restitution": 0.05, "normal": 0.006}},
    },
    start=start,
    advance=advance,
    outcome=outcome,
    observe=observe,
    observation_channels=observations,
    action_channels=_actions,
    metrics=_metrics,
    dt=_interval,
    validate=_validate,
    engines=ENGINES,
    sensors=("sensing", "camera"),
)


class BallOnBarEnv(ScalarEnv):
    """Keep a bouncing ball at the centre of a bar by choosing the bar's motion.

    ## Description
    A ball bounces on a bar with three degrees of freedom (Bell, section IV): x and tilt move at the base frequency
    (15 Hz), z at twice that, so the bar's centre runs along a parabola. An action comes once per base cycle. The ball
    flies freely; every impact is located to rounding. Restitution and surface normal scatter a little from impact to
    impact. The bar never jumps: it goes to a new motion along a blend with continuous position and velocity.

    ## Action Space
    `Box(-1, 1, (6,), float32)`, clipped to it: amplitude and phase of the three motions as in-phase and quadrature
    parts (an amplitude of zero has no phase, and phases wrap; the two parts have neither flaw).

    | # | action | at 1 (default scene) |
    |---|--------|----------------------|
    | 0 | x, cosine part | peak acceleration 10 m/s^2 |
    | 1 | x, sine part | 10 m/s^2 |
    | 2 | tilt, cosine part (positive tilt lowers the right end) | 100 rad/s^2 |
    | 3 | tilt, sine part | 100 rad/s^2 |
    | 4 | z, cosine part, added to 8 m/s^2 | 4 m/s^2 |
    | 5 | z, sine part | 4 m/s^2 |

    ## Observation Space
    `Box(-1, 1, (10,), float32)` (11 with spin), taken at the start of a cycle, each clipped to its range.

    | # | observation | at 1 |
    |---|-------------|------|
    | 0 | ball x from the centre | half length, 25 mm |
    | 1 | ball velocity along x | 0.5 m/s |
    | 2 | ball height from the bar's mean height | 20 mm |
    | 3 | ball velocity upwards | 1 m/s |
    | 4-9 | the bar's present motion, as the action that asks for it | |
    | 10 | ball radius times spin (only with the option `spin`) | 0.5 m/s |

    ## Rewards
    1 / (1 + (x / 2 mm)^2) at the end of each cycle, in (0, 1]; 0 when the ball is lost.

    ## Starting State
    |x| uniform in 3 to 15 mm on either side, at rest along x, on the vertical period-one orbit of the bar's motion
    at action 0.

    ## Episode End
    Terminated when the ball meets the plane of the bar beyond its ends, or a cycle needs more than 20 000 events, as
    without losses it may (`fault`). Truncated after 150 cycles, 10 s. The last info holds `is_success` (on the bar with
    an rms x of at most 2 mm), `on_bar`, `rms_x_mm`, `max_x_mm`, `impacts_per_cycle`, `fault`.

    ## Arguments
    `scene`, a name or a dict of overrides, `{"base": "bell", "restitution": 0.8, "spin": True}`;
    `vr-envs list BallOnBar` prints every parameter and option with its unit:

    - `"bell"` (default): part c = 2/7 of the tangential velocity is lost at an impact, no spin;
    - `"bell-2dof"`: the same without x-motion;
    - `"rolling"`: a solid sphere that grips, spins and rolls, on a surface half as rough again: no open-loop motion of
      a flat bar holds it;
    - `"lens"`: the sphere on a concave bar, which draws it in by itself, slowly.

    What a scene may add, each compiled away where it is absent: `scatter` of restitution and surface normal, `spin`,
    `friction` (Coulomb's limit of the grip, tangential restitution), `softening` (restitution that falls with the
    impact speed), `curve` (concave or convex bar), `frequencies` of their own for x, tilt and z, a slow `ramp` of the
    amplitudes. `hold` is the number of base cycles between two actions: 0.5 or a whole number.

    `observation`: `"state"` (default), `"sensing"` (the state late and with noise) or `"camera"` (what Bell's vision
    system would see: place and velocity from two exposures, with its latency; no spin). Like engines they are options
    of the scene, with settings: `scene={"camera": {"noise": 10.0}}`. `render_mode`: None, `"rgb_array"` or `"human"`.

    `engine`, what moves the ball: `"exact"` (default), `"textbook"` (contacts found as in Bell's simulator: `samples`
    of the gap per period of z, then a binary search) or `"rigid_body"` (the Chipmunk engine in fixed time steps of
    `step`; one environment at a time, so not in `gym.make_vec` with the native batch). The settings are laid into the
    scene, `scene={"rigid_body": {"step": 5e-5}}`, which chooses the engine too; `engine` takes its defaults where the
    scene has none, and replaces another engine of the scene. With each of them a step follows from record and action
    alone, so a saved state replays to the same bytes.

    ## Version History
    * v0: first version.
    """

    task = TASK


class BallOnBarBatchEnv(BatchEnv):
    """Native batch of `BallOnBarEnv`."""

    task = TASK
