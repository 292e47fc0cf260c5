"""The ride in MuJoCo, driven directly.

Everything is slide joints and tendons: a tendon between mass and hub is the suspension, one with a dead band is a
stop, one from hub to ground whose dead band begins where the tyre carries nothing is a tyre that pushes and does not
pull. The ground is a body so heavy that nothing moves it, given the road's height and rate at every knot, over sines
at every step, within which it goes on at that rate. The absolute damper is the damping of the body's joint. MuJoCo's
contacts, which are soft constraints, are not used: they are no linear springs.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np

from vr_envs.bench.accuracy.terrain_ride_episodes import Episode
from vr_envs.bench.accuracy.terrain_ride_loops import free_deflection
from vr_envs.models.constants import G
from vr_envs.models.ride_options import TICK

HEAVY = 1e12  # kg, of the ground
FAR = 1e9  # m, where no dead band ends


def model_of(episode: Episode, integrator: str) -> Any:
    """Ground, hub (with a tyre) and body on slide joints, and the tendons between them."""
    _, _, tyre, stop = episode.parts
    masses = {"ground": HEAVY, "body": float(episode.params["mass"])}
    tendons = {"spring": ("body", "ground")}
    if tyre is not None:
        masses["hub"] = float(tyre["unsprung_mass"])
        tendons = {"spring": ("body", "hub"), "tyre": ("hub", "ground")}
    if stop is not None:
        tendons["stop"] = tendons["spring"]
    bodies = "".join(
        f'<body name="{name}" gravcomp="{int(name == "ground")}"><joint name="{name}" type="slide" axis="0 0 1"/>'
        f'<inertial pos="0 0 0" mass="{mass!r}" diaginertia="1 1 1"/></body>'
        for name, mass in masses.items()
    )
    strings = "".join(
        f'<fixed name="{name}" springlength="0 0"><joint joint="{upper}" coef="1"/><joint joint="{lower}" coef="-1"/>'
        "</fixed>"
        for name, (upper, lower) in tendons.items()
    )
    model = mujoco.MjModel.from_xml_string(  # type: ignore[attr-defined]
        f'<mujoco><option integrator="{integrator}" gravity="0 0 -{G!r}"><flag contact="disable"/></option>'
        f"<worldbody>{bodies}</worldbody><tendon>{strings}</tendon></mujoco>"
    )
    if tyre is not None:
        model.tendon_stiffness[model.tendon("tyre").id] = tyre["rate"]
        model.tendon_lengthspring[model.tendon("tyre").id] = free_deflection(episode.params, tyre), FAR
    if stop is not None:
        model.tendon_stiffness[model.tendon("stop").id] = stop["rate"]
        model.tendon_lengthspring[model.tendon("stop").id] = -stop["travel"], stop["travel"]
    return model


def simulated(episode: Episode, integrator: str, step: float) -> Callable[[], np.ndarray]:
    """Work that drives the episode in equal steps of about `step` [s] and returns what is seen.

    That is travel, velocity and deflection at every tick, (ticks, 3). The model stands, and what it is given while it
    runs is known beforehand.
    """
    model, relative, mass = model_of(episode, integrator), episode.params["relative"], episode.params["mass"]
    data: Any = mujoco.MjData(model)  # type: ignore[attr-defined]
    joints = ("body", "ground") if episode.records["tyre"] is None else ("body", "ground", "hub")
    place, spring = {name: model.joint(name).id for name in joints}, model.tendon("spring").id
    body, road, hub = place["body"], place["ground"], place.get("hub", place["ground"])
    steps = max(1, round(TICK / step))
    model.opt.timestep = TICK / steps
    # the ground's rate is even on a road, so that it need not be told at every step
    stints, each = (steps, 1) if episode.knots is None else (1, steps)
    pieces = list(episode.pieces())
    told = []  # of each piece the ticks in it, and in each the ground's heights
    for piece in pieces:
        times = {tick: TICK * (tick + np.arange(stints + 1) / stints) for tick in piece.ticks.tolist()}
        told.append([(tick, [float(episode.ground(piece, t)) for t in some]) for tick, some in times.items()])
    first = episode.first(told[0][0][1][0])

    def work() -> np.ndarray:
        mujoco.mj_resetData(model, data)  # type: ignore[attr-defined]
        rows, qpos, qvel = np.zeros((len(episode.actions), 3)), data.qpos, data.qvel
        for at, joint in ((2, hub), (0, body)):  # the ground, where there is no hub, is put in its place below
            qpos[joint], qvel[joint] = first[at], first[at + 1]
        for piece, ticks in zip(pieces, told, strict=True):
            model.tendon_stiffness[spring] = mass * piece.w2
            model.tendon_lengthspring[spring] = G / piece.w2  # levelled: it carries the body at a travel of 0
            model.tendon_damping[spring] = mass * piece.gamma * relative
            model.dof_damping[body] = mass * piece.gamma * (1.0 - relative)
            for tick, heights in ticks:
                for below, above in zip(heights, heights[1:], strict=False):
                    qpos[road], qvel[road] = below, (above - below) * stints / TICK
                    mujoco.mj_step(model, data, each)  # type: ignore[attr-defined]
                rows[tick] = episode.seen(np.array([qpos[body], qvel[body], qpos[hub], 0.0]), heights[-1])
        return rows

    return work
