"""Engines of the ride: how far from the exact motion, over the time step.

The lecture's recurrence and Chipmunk both change velocities once a step and move with them in between: order 1. What
Chipmunk adds to that is a late contact: a slope, a stop or the ground is felt up to a step after it is met.
The exact model has no step: it is run in intervals of 10 ms and of 1 ms, which must give the same.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vr_envs.envs.terrain_ride import TASK
from vr_envs.envs.world import World
from vr_envs.experiments.experiment import Finding, Outcome, Progress
from vr_envs.experiments.look import BALL, BAR, FAINT, label

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SPAN = 0.6  # s
INTERVAL = 0.01  # s, after which the engines are compared
KEYS = range(5, 10)  # episodes: where in a step a contact falls is a matter of chance
STEPS = INTERVAL / np.array([10, 27, 71, 188, 500])  # s, Chipmunk's
LECTURE_STEPS = INTERVAL / np.array([1, 3, 10, 32, 100, 316, 1000])
PASSIVE = np.array([0.2, 0.0])  # damping and modulus, held
SPLIT = 1e-12  # m/s, by which exact runs in other intervals may differ
LIMITS = 0.85, 1.25  # order
# what rides, its scene, and the engines that know it with their steps
SCENES: dict[str, tuple[dict[str, Any], dict[str, np.ndarray]]] = {
    "wheel on sines": ({"base": "lecture"}, {"textbook": LECTURE_STEPS, "rigid_body": STEPS}),
    "wheel on a road with stops": (
        {"road": {"iso_class": "F"}, "stop": {"travel": 0.05}},
        {"rigid_body": STEPS},
    ),
    "quarter car that lifts off": ({"tyre": True, "road": {"iso_class": "E"}}, {"rigid_body": STEPS}),
}


class Ride(NamedTuple):
    """Velocities of the mass (m/s) every 10 ms, touches of a stop, and lift-offs, of all episodes."""

    velocities: np.ndarray
    touches: int
    liftoffs: int


def ridden(scene: Mapping[str, Any], interval: float = INTERVAL) -> Ride:
    """The first part of the episodes with a constant action, in control intervals of `interval` (s)."""
    world = World(TASK, {**scene, "dt": interval}, len(KEYS))
    world.reset(np.arange(len(KEYS)), np.array(KEYS, np.uint64), world.observe())
    velocities, touches, each = [], 0, round(INTERVAL / interval)
    for k in range(round(SPAN / interval)):
        for state in world.states:
            if world.simulator is None:
                TASK.advance(state, PASSIVE, world.params, *world.options)
            else:
                world.simulator.advance(state, PASSIVE)
        touches += int(world.states["touches"].sum())
        if (k + 1) % each == 0:
            velocities.append(world.states["velocity"].copy())
    return Ride(np.array(velocities), touches, int(world.states["liftoffs"].sum()))


def engines(progress: Progress) -> Outcome:
    """Every engine in every scene that it knows."""
    findings: list[Finding] = []
    errors: dict[tuple[str, str], np.ndarray] = {}
    tables: dict[str, dict[str, np.ndarray]] = {}
    for name in progress(SCENES, desc="scenes"):
        scene, engines = SCENES[name]
        exact = ridden(scene)
        split = float(np.abs(ridden(scene, 0.1 * INTERVAL).velocities - exact.velocities).max())
        findings.append(
            Finding(
                f"{name}: exact, in intervals of 1 ms and of 10 ms",
                f"the same within {SPLIT:g} m/s",
                f"{split:.1e} m/s; {exact.touches} touches of a stop, {exact.liftoffs} lift-offs",
                split < SPLIT,
            )
        )
        for engine, steps in engines.items():
            rides = [ridden({**scene, engine: {"step": float(step)}}) for step in steps]
            found = np.array([math.sqrt(np.mean((ride.velocities - exact.velocities) ** 2)) for ride in rides])
            errors[name, engine] = found
            tables[f"{name.replace(' ', '_')}-{engine}"] = {"step_s": steps, "rms_error_m_s": found}
            findings.append(_order(name, engine, steps, found))
            same = rides[-1].touches == exact.touches and rides[-1].liftoffs == exact.liftoffs
            if exact.touches + exact.liftoffs > 0:
                findings.append(
                    Finding(
                        f"{name}: touches and lift-offs of {engine} at {steps[-1]:g} s",
                        f"{exact.touches} and {exact.liftoffs}",
                        f"{rides[-1].touches} and {rides[-1].liftoffs}",
                        same,
                    )
                )
    return Outcome(tuple(findings), tables, lambda figure: _draw(figure, errors))


def _order(name: str, engine: str, steps: np.ndarray, found: np.ndarray) -> Finding:
    """The slope of the errors, by least squares in logarithms."""
    order = float(np.polyfit(np.log(steps), np.log(found), 1)[0])
    return Finding(
        f"{name}: order of {engine}, {steps[0]:g} to {steps[-1]:g} s",
        f"1, between {LIMITS[0]:g} and {LIMITS[1]:g}",
        f"{order:.3f}; rms error {found[0]:.1e} to {found[-1]:.1e} m/s",
        LIMITS[0] < order < LIMITS[1],
    )


def _draw(figure: Figure, errors: dict[tuple[str, str], np.ndarray]) -> None:
    """Errors over steps, one panel a scene."""
    figure.set_size_inches(11.0, 4.5)
    for axes, (name, (_, engines)) in zip(figure.subplots(1, len(SCENES), sharey=True), SCENES.items(), strict=True):
        for (engine, steps), colour in zip(engines.items(), (BALL, BAR) if len(engines) > 1 else (BAR,), strict=True):
            found = errors[name, engine]
            axes.loglog(steps, found, "o", color=colour, ms=4.0, label=engine)
            axes.loglog(steps, found[-1] * steps / steps[-1], "-", color=FAINT, lw=0.6)
        first = name == next(iter(SCENES))
        label(axes, name, "step (s)", "rms error of the velocity (m/s)" if first else "", legend=True)
