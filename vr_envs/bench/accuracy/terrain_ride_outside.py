"""Other people's integrators and engines on the ride: scipy, and MuJoCo driven directly.

What they are told: where the ground's slope and the suspension jump, so that they restart there, and, scipy, the
contacts as events. In MuJoCo everything is slide joints and tendons: a tendon between mass and hub is the suspension,
one with a dead band is a stop, one from hub to ground whose dead band begins where the tyre carries nothing is a tyre
that pushes and does not pull. The ground is a body so heavy that nothing moves it, given the road's height and rate at
every knot; over sines at every step. The absolute damper is the damping of the body's joint. Its contacts, which are
soft constraints, are not used: they are no linear springs.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import mujoco
import numpy as np
from scipy.integrate import solve_ivp

from vr_envs.bench.accuracy.terrain_ride_opponents import contacts_of, free_deflection, gap_of, slopes
from vr_envs.models.constants import G
from vr_envs.models.ride_options import TICK
from vr_envs.models.terrain import undulation_ahead
from vr_envs.models.terrain_ride import actuate, suspension

SAME = 1e-9  # s: two instants closer than this are one
HEAVY = 1e12  # kg, of the ground
FAR = 1e9  # m, where no dead band ends


class Episode(NamedTuple):
    """A scene in one episode: records of the model (None: absent), first state, actions, heights of the road."""

    params: Any
    undulation: Any
    road: Any
    tyre: Any
    stop: Any
    start: np.void
    actions: np.ndarray
    knots: np.ndarray | None


class Piece(NamedTuple):
    """From `begin` to `end` [s] the suspension is held; `climb` [m/s] is the even ground's rate, which is at `ground`."""

    begin: float
    end: float
    gamma: float
    w2: float
    ground: float
    climb: float


def pieces(episode: Episode) -> Iterator[Piece]:
    """The parts of an episode in which nothing jumps but contacts."""
    state, speed, actions = episode.start.copy(), float(episode.params["speed"]), episode.actions
    end = len(actions) * TICK
    changes = {0} | {k for k in range(1, len(actions)) if (actions[k] != actions[k - 1]).any()}
    corners = [k * TICK for k in changes] + [end]
    apart = np.inf
    if episode.knots is not None:
        apart = float(episode.road["knot_spacing"]) / speed
        corners += list(np.arange(0.0, end, apart))
    corners = sorted(corners)
    corners = [c for c, after in zip(corners, [*corners[1:], np.inf], strict=True) if after - c > SAME]
    for begin, finish in zip(corners, corners[1:], strict=False):
        actuate(state, actions[int((begin + SAME) / TICK)], None, None)
        gamma, w2, _ = suspension(state, episode.params)
        ground = climb = 0.0
        if episode.knots is not None:
            knot = int((begin + SAME) / apart)
            climb = float(episode.knots[knot + 1] - episode.knots[knot]) / apart
            ground = float(episode.knots[knot]) + climb * (begin - knot * apart)
        yield Piece(begin, finish, gamma, w2, ground, climb)


def first_heights(episode: Episode, ground: float) -> np.ndarray:
    """Height and velocity of the body and of the hub at the start."""
    start = episode.start
    hub = ground + float(start["deflection"])
    return np.array([hub + float(start["travel"]), start["velocity"], hub, start["hub_velocity"]], float)


def sines(episode: Episode, time: float) -> float:
    """Height of the sines under the wheel."""
    return undulation_ahead(episode.start, float(episode.params["speed"]) * time, episode.undulation)


def ticks_in(piece: Piece) -> np.ndarray:
    """Numbers of the ticks that end in a piece, from 0."""
    return np.arange(int((piece.begin + SAME) / TICK), int((piece.end + SAME) / TICK))


def seen_of(y: np.ndarray, ground: float, tyre: Any) -> tuple[float, float, float]:
    """Travel, velocity and deflection."""
    hub = ground if tyre is None else y[2]
    return y[0] - hub, y[1], hub - ground


def integrated(episode: Episode, method: str, tolerance: float) -> np.ndarray:
    """By scipy's `solve_ivp`: travel, velocity, deflection and time off the ground at every tick, (ticks, 4).

    The tolerance is relative, and the absolute one in m and m/s is a hundredth of it; the right-hand side is compiled.
    """
    params, tyre, stop = episode.params, episode.tyre, episode.stop
    rows = np.zeros((len(episode.actions), 4))
    y, off, contacts = None, 0.0, (0.0, 0.0)
    for piece in pieces(episode):
        _, _, gamma, w2, begin_ground, climb = piece

        def ground(time: float, piece: Piece = piece) -> float:
            if episode.undulation is not None:
                return sines(episode, time)
            return piece.ground + piece.climb * (time - piece.begin)

        if y is None:
            y = first_heights(episode, ground(0.0))
            contacts = contacts_of(tuple(y), ground(0.0), params, tyre, stop)
        time, ticks = piece.begin, ticks_in(piece)
        while piece.end - time > SAME:
            held = contacts

            def rates(t: float, at: np.ndarray, held: Any = held) -> tuple[float, ...]:
                return slopes(at, ground(t), climb, held, gamma, w2, params, tyre, stop)  # noqa: B023

            def gap(t: float, at: np.ndarray, held: Any = held) -> float:
                return gap_of(at, ground(t), held, params, tyre, stop)[0]  # noqa: B023

            gap.terminal, gap.direction = True, -1.0  # type: ignore[attr-defined]
            wanted = [t for t in (ticks + 1) * TICK if time < t < piece.end - SAME] + [piece.end]
            found = solve_ivp(
                rates, (time, piece.end), y, method, rtol=tolerance, atol=0.01 * tolerance, t_eval=wanted,
                events=None if tyre is None and stop is None else gap,
            )  # fmt: skip
            for t, at in zip(found.t, np.transpose(found.y), strict=True):
                tick = round(t / TICK)
                if abs(t - tick * TICK) < SAME:
                    rows[tick - 1, :3] = seen_of(at, ground(t), tyre)
                    rows[tick - 1, 3] = off + held[0] * (t - time)
            if found.status == 1:
                end, y = float(found.t_events[0][0]), found.y_events[0][0]
                contacts = _switched(y, ground(end), held, params, tyre, stop)
            else:
                end, y = piece.end, found.y[:, -1]
            off += held[0] * (end - time)
            time = end
    return rows


def _switched(y: np.ndarray, ground: float, held: Any, params: Any, tyre: Any, stop: Any) -> tuple[float, float]:
    """The contacts after that with the smallest gap has changed."""
    _, is_tyre = gap_of(y, ground, held, params, tyre, stop)
    if is_tyre:
        return 1.0 - held[0], held[1]
    return held[0], 0.0 if held[1] else float(np.sign(y[0] - (ground if tyre is None else y[2])))


def mujoco_model(episode: Episode, integrator: str) -> mujoco.MjModel:
    """Ground, hub (with a tyre) and body on slide joints, and the tendons between them."""
    params, tyre = episode.params, episode.tyre
    masses = {"ground": HEAVY, "body": float(params["mass"])}
    tendons = {"spring": ("body", "ground")}
    if tyre is not None:
        masses["hub"] = float(tyre["unsprung_mass"])
        tendons = {"spring": ("body", "hub"), "tyre": ("hub", "ground")}
    if episode.stop is not None:
        tendons["stop"] = tendons["spring"]
    bodies = "".join(
        f'<body name="{name}" gravcomp="{int(name == "ground")}"><joint name="{name}" type="slide" axis="0 0 1"/>'
        f'<inertial pos="0 0 0" mass="{mass}" diaginertia="1 1 1"/></body>'
        for name, mass in masses.items()
    )
    strings = "".join(
        f'<fixed name="{name}" springlength="0 0"><joint joint="{upper}" coef="1"/><joint joint="{lower}" coef="-1"/>'
        "</fixed>"
        for name, (upper, lower) in tendons.items()
    )
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option integrator="{integrator}" gravity="0 0 {-G!r}"><flag contact="disable"/></option>'
        f"<worldbody>{bodies}</worldbody><tendon>{strings}</tendon></mujoco>"
    )
    if tyre is not None:
        free = free_deflection(params, tyre)
        model.tendon_stiffness[model.tendon("tyre").id] = tyre["rate"]
        model.tendon_lengthspring[model.tendon("tyre").id] = free, FAR
    if episode.stop is not None:
        travel = episode.stop["travel"]
        model.tendon_stiffness[model.tendon("stop").id] = episode.stop["rate"]
        model.tendon_lengthspring[model.tendon("stop").id] = -travel, travel
    return model


def simulated(episode: Episode, integrator: str, step: float) -> np.ndarray:
    """By MuJoCo: travel, velocity and deflection at every tick, (ticks, 3), in equal steps of at most `step` [s]."""
    params, tyre = episode.params, episode.tyre
    model = mujoco_model(episode, integrator)
    data = mujoco.MjData(model)
    spring = model.tendon("spring").id
    base, body, hub = (
        None if name == "hub" and tyre is None else model.joint(name).qposadr[0] for name in ("ground", "body", "hub")
    )
    rows, mass = np.zeros((len(episode.actions), 3)), float(params["mass"])
    steps = max(1, round(TICK / step))
    model.opt.timestep = TICK / steps
    y = None
    for piece in pieces(episode):
        if y is None:
            y = first_heights(episode, piece.ground if episode.undulation is None else sines(episode, 0.0))
            data.qpos[body], data.qvel[body] = y[0], y[1]
            if hub is not None:
                data.qpos[hub], data.qvel[hub] = y[2], y[3]
        model.tendon_stiffness[spring] = mass * piece.w2
        model.tendon_lengthspring[spring] = G / piece.w2  # levelled: it carries the body at a travel of 0
        model.tendon_damping[spring] = mass * piece.gamma * params["relative"]
        model.dof_damping[body] = mass * piece.gamma * (1.0 - params["relative"])
        for tick in ticks_in(piece):
            if episode.undulation is None:
                data.qpos[base], data.qvel[base] = piece.ground + piece.climb * (tick * TICK - piece.begin), piece.climb
                mujoco.mj_step(model, data, steps)
                ground = piece.ground + piece.climb * ((tick + 1) * TICK - piece.begin)
            else:
                heights = [sines(episode, tick * TICK + k * TICK / steps) for k in range(steps + 1)]
                for below, above in zip(heights, heights[1:], strict=False):
                    data.qpos[base], data.qvel[base] = below, (above - below) * steps / TICK
                    mujoco.mj_step(model, data)
                ground = heights[-1]
            at = np.array([data.qpos[body], data.qvel[body], ground if hub is None else data.qpos[hub]])
            rows[tick] = seen_of(at, ground, tyre)
    return rows
