"""Trials of the ball on a bar: every regime, with every flight between two impacts judged (`ball_walk`)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from vr_envs.bench.stress.ball_walk import CONSTANT, CORNERS, UNIFORM, Settings, Walk, judge
from vr_envs.bench.stress.trial import Outcome, log_uniform

NO_LIMIT = 1 << 60


def _walk(seed: int, scene: dict[str, Any], **changes: Any) -> Walk:
    """A walk of a ball from a little above the bar; what is not given is usual."""
    usual: dict[str, Any] = {
        "intervals": 100, "impacts": NO_LIMIT, "actions": UNIFORM, "every": 1, "height": 0.004, "speed": 0.05,
        "reach": 0.01,
    }  # fmt: skip
    return Walk(scene, Settings(key=seed, **{**usual, **changes}))


def chatter(seed: int) -> Walk:
    """A bar that moves up and down only, at a peak acceleration of 5 to 100 m/s^2: chatter, rest and release."""
    draw = np.random.default_rng(seed)
    scene = {"z_acceleration": draw.uniform(5.0, 100.0), "restitution": draw.uniform(0.0, 0.9)}
    return _walk(seed, scene, actions=CONSTANT, height=log_uniform(draw, 1e-3, 0.1), speed=0.0, reach=0.0)


def losses(seed: int) -> Walk:
    """Restitution 0 and 1, the bar still, up and down, or in random motion."""
    draw = np.random.default_rng(seed)
    scene = {
        "restitution": float(seed % 2),
        "z_acceleration": draw.choice([0.0, draw.uniform(0.0, 100.0)]),
        "tangential_loss": draw.choice([0.0, 2.0 / 7.0, 1.0]),
        "half_length": 1.0,
    }
    return _walk(
        seed,
        scene,
        intervals=20,
        actions=int(draw.choice([CONSTANT, UNIFORM])),
        height=log_uniform(draw, 1e-12, 0.1),
        speed=0.01,
    )


def motions(seed: int) -> Walk:
    """A bar that goes to another random motion in every cycle, over the whole range of the actions."""
    return _walk(seed, {}, intervals=1000, actions=(UNIFORM, CORNERS)[seed % 2], every=2)


def speeds(seed: int) -> Walk:
    """Bars from 0.5 to 200 Hz, accelerations up to 100 m/s^2, blends from 0.05 cycles on, one or two actions each."""
    draw = np.random.default_rng(seed)
    frequency = log_uniform(draw, 0.5, 200.0)
    hold = float(draw.choice([0.5, 1.0]))
    scene = {
        "frequency": frequency,
        "hold": hold,
        "blend": log_uniform(draw, 0.05, hold),
        "restitution": draw.uniform(0.0, 0.95),
        "half_length": 1.0,
        "x_acceleration": draw.uniform(0.0, 100.0),
        "tilt_acceleration": min(5000.0, draw.uniform(0.0, 0.3) * (2.0 * np.pi * frequency) ** 2),
        "z_acceleration": draw.uniform(0.0, 100.0),
        "z_acceleration_span": draw.uniform(0.0, 100.0),
    }
    return _walk(seed, scene, actions=(UNIFORM, CORNERS)[seed % 2])


def dropped(seed: int) -> Walk:
    """A ball dropped from 10 m onto a moving bar."""
    draw = np.random.default_rng(seed)
    scene = {"restitution": draw.uniform(0.0, 1.0), "half_length": 10.0, "z_acceleration": draw.uniform(0.0, 100.0)}
    return _walk(seed, scene, intervals=200, height=10.0, actions=(CONSTANT, UNIFORM)[seed % 2])


def curved(seed: int) -> Walk:
    """A bar curved up to 45 degrees at its ends, hollow or humped, with a sphere that spins and slips on it."""
    draw = np.random.default_rng(seed)
    half = log_uniform(draw, 0.01, 0.1)
    steep = 1.0 - 10.0 ** draw.uniform(-4.0, 0.0)
    curvature = float(draw.choice([-1.0, 1.0], p=[0.2, 0.8]) * min(100.0, steep / half))
    scene = {
        "half_length": half,
        "start_max": 0.5 * half,
        "start_min": 0.0,
        "restitution": draw.choice([draw.uniform(0.0, 1.0), 1.0], p=[0.9, 0.1]),
        "scatter": {
            "restitution": draw.choice([0.0, draw.uniform(0.0, 0.3)]),
            "normal": draw.choice([0.0, draw.uniform(0.0, 0.1)]),
        },
        "spin": {"inertia_ratio": draw.uniform(0.0, 1.0)},
        "friction": {"coefficient": log_uniform(draw, 1e-3, 10.0), "restitution": draw.uniform(0.0, 1.0)},
        "curve": {"curvature": curvature},
    }
    return _walk(
        seed, scene, actions=(CONSTANT, UNIFORM)[seed % 2], reach=0.9 * half, height=0.01, speed=0.2,
        curvature=curvature,
    )  # fmt: skip


def impacts(seed: int) -> Walk:
    """A hundred thousand impacts on a bar that moves up and down; of one interval in 200 not only the end is judged."""
    draw = np.random.default_rng(seed)
    scene = {"z_acceleration": draw.uniform(12.0, 25.0), "restitution": draw.uniform(0.2, 0.7)}
    return _walk(
        seed, scene, intervals=NO_LIMIT, impacts=100_000, actions=CONSTANT, every=200, speed=0.0, reach=0.0
    )  # fmt: skip


def runs(walk_of: Callable[[int], Walk], motions: bool = False) -> Callable[[int, int, np.ndarray], Outcome]:
    """The cases of a walk; with `motions` the intervals are counted, not the impacts."""

    def run(first: int, number: int, trace: np.ndarray) -> Outcome:
        outcome = Outcome()
        for seed in range(first, first + number):
            judge(seed, walk_of(seed), outcome, trace, motions)
        return outcome

    return run
