"""The ball in MuJoCo, driven directly: a box on joints that are put where the bar is, a sphere, soft contacts.

What it can do and what not:
- A mocap body has no velocity, so a bar made of one would hit nothing. Here the bar hangs on two slides and a hinge
  that get the mean velocity of each step, and is too heavy for the ball to move it.
- MuJoCo has no restitution. Its contact is a spring and a damper per unit of mass (`solref` with negative numbers)
  that cannot pull; the damping is chosen so that the ball leaves with the restitution of the scene (`rebound`).
- The stiffer the spring, the shorter and the more coarsely followed is a contact, so its restitution depends on where
  in a step it begins; the softer, the longer it lasts. A contact is made to last `STEPS` steps at the step `STEP`, and
  more of smaller ones (`POWER`), so that both errors fall, together slower than the step. An impact's time is that of
  the first step with a contact.
- Impedances are at most 0.9999: a ten-thousandth of the motion without contact is left.
- The tangential law is that of a sphere that grips and whose spin is forgotten before every contact, with the moment of
  inertia that loses the share of the scene; the damper of the friction (`solreffriction`) stops the slip in one step.
- A semi-implicit Euler step is exact on a parabola if the velocity is that in the middle of a step.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
from scipy.optimize import root_scalar

from vr_envs.bench.accuracy.ball_on_bar_episodes import Episode, Track
from vr_envs.bench.accuracy.ball_on_bar_loops import bar_track

STEP, STEPS, POWER = 1e-4, 20.0, 1.0 / 3.0  # s; of these a contact lasts so many; exponent of the growth of that
SMALLEST = math.exp(-2.0)  # restitution at critical damping
RADIUS = 0.0025  # m
ENGINE: Any = mujoco  # a compiled module without types
HEAVY = 1e9  # mass of the bar over that of the ball
GRIP = 1e3  # coefficient of friction

SCENE = """
<mujoco>
  <option timestep="{step!r}" gravity="0 0 -{gravity!r}" integrator="Euler" cone="elliptic" jacobian="dense">
    <flag eulerdamp="disable"/>
  </option>
  <worldbody>
    <body gravcomp="1">
      <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/><joint type="hinge" axis="0 1 0"/>
      <inertial pos="0 0 0" mass="{heavy!r}" diaginertia="{heavy!r} {heavy!r} {heavy!r}"/>
      <geom name="bar" type="box" size="25 1 0.05" pos="0 0 {below!r}"/>
    </body>
    <body>
      <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/><joint type="hinge" axis="0 1 0"/>
      <inertial pos="0 0 0" mass="1" diaginertia="{inertia!r} {inertia!r} {inertia!r}"/>
      <geom name="ball" type="sphere" size="{radius!r}"/>
    </body>
  </worldbody>
  <contact>
    <pair geom1="bar" geom2="ball" condim="3" friction="{grip!r} {grip!r} 0 0 0" solimp="0.9999 0.9999 0.001 0.5 2"
      solref="-{stiffness!r} {against!r}" solreffriction="0 -{stopping!r}"/>
  </contact>
</mujoco>
"""


def rebound(ratio: float) -> tuple[float, float]:
    """A mass that meets a spring with a damper that cannot pull: restitution, and how long it touches times omega.

    `ratio` in [0, 1): damping over critical damping. The contact ends where the force, 2 ratio x' + x, is zero.
    """
    damped = math.sqrt(1.0 - ratio**2)
    phase = math.atan2(2.0 * ratio * damped, 2.0 * ratio**2 - 1.0)  # pi without a damper
    time = phase / damped
    return math.exp(-ratio * time) * (ratio / damped * math.sin(phase) - math.cos(phase)), time


def _ratio(restitution: float) -> float:
    """The damping that `rebound` needs."""
    return float(root_scalar(lambda ratio: rebound(ratio)[0] - restitution, bracket=(0.0, 1.0 - 1e-9)).root)


def contact_of(restitution: float, step: float) -> tuple[float, float]:
    """Stiffness (1/s^2) and damping (1/s) per unit of mass of a contact with this restitution, see `STEPS`.

    Raises:
        ValueError: no damping gives so little or so much.
    """
    if not SMALLEST < restitution <= 1.0:
        raise ValueError(f"restitution = {restitution:g}; this contact can have one in ({SMALLEST:.3g}, 1]")
    ratio = 0.0 if restitution == 1.0 else _ratio(restitution)
    omega = rebound(ratio)[1] / (STEPS * (STEP / step) ** POWER * step)
    return omega**2, 2.0 * ratio * omega


def simulated(episode: Episode, steps: int) -> Callable[[], Track]:
    """The episode in `steps` equal steps a base cycle; the model stands, and knows where the bar is at their ends."""
    p = episode.params
    gravity, step, share = float(p["gravity"]), float(p["period"]) / steps, float(p["tangential_loss"])
    stiffness, damping = contact_of(float(p["restitution"]), step)
    text = SCENE.format(
        step=step, gravity=gravity, heavy=HEAVY, below=-0.05 - RADIUS, inertia=share / (1.0 - share) * RADIUS**2,
        radius=RADIUS, grip=GRIP, stiffness=stiffness, against=-damping, stopping=1.0 / step,
    )  # fmt: skip
    model = ENGINE.MjModel.from_xml_string(text)
    data = ENGINE.MjData(model)
    x, z, u, w = episode.place
    track = bar_track(episode.motions, p, steps)
    place = np.array([*track[0], x, z, 0.0])
    motion = np.array([0.0, 0.0, 0.0, u, w + 0.5 * gravity * step, 0.0])
    velocities = (np.diff(track, axis=0) / step).tolist()

    def work() -> Track:
        ENGINE.mj_resetData(model, data)
        data.qpos[:], data.qvel[:] = place, motion
        begun, ends, touching = [], [], False
        velocity = data.qvel
        for number, (vx, vz, turn) in enumerate(velocities):
            velocity[0], velocity[1], velocity[2] = vx, vz, turn
            if not touching:
                velocity[5] = turn
            ENGINE.mj_step(model, data)
            if (data.ncon > 0) != touching:
                touching = not touching
                if touching:  # where the ball was at the beginning of this step
                    begun.append((number // steps, number % steps * step, velocity[4] - vz))
            if (number + 1) % steps == 0:
                ends.append([data.qpos[3], data.qpos[4], velocity[3], velocity[4] - 0.5 * gravity * step])
        return Track(np.array(begun).reshape(-1, 3), np.array(ends))

    return work
