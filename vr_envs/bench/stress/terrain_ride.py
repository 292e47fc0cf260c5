"""Trials of the ride: kerbs, springs from nothing to rock, wheels that hop, a very long way, the smallest numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

from vr_envs.bench.stress.ride_check import REASONS, check, denormal, facts_of
from vr_envs.bench.stress.rows_walk import CORNERS, HELD, UNIFORM, ZERO, Settings, judge, no_check, nothing
from vr_envs.bench.stress.trial import Outcome, log_uniform
from vr_envs.envs.scene import Scene, resolve
from vr_envs.envs.terrain_ride import TASK

_BARE: dict[str, Any] = dict.fromkeys(("bumps", "payload", "lag", "preview", "noise"))


def _vehicle(draw: np.random.Generator, tyre: bool) -> dict[str, Any]:
    """Parts of a vehicle on a road with kerbs; without a tyre the wheel follows the ground."""
    top = log_uniform(draw, 0.1, 5.0)
    return {
        "speed": log_uniform(draw, 1.0, 100.0),
        "road": {"iso_class": "flat", "knot_spacing": log_uniform(draw, 0.01, 0.1)},
        "obstacle": {
            "kind": "kerb",
            "height": log_uniform(draw, 0.01, 1.0),
            "top": top,
            "every": 2.0 * top,
            "first": 0.5,
        },
        "stop": {"travel": draw.uniform(0.02, 0.1), "rate": log_uniform(draw, 1e4, 1e6), "crush": 10.0},
        "tyre": {"unsprung_mass": log_uniform(draw, 0.1, 100.0), "rate": log_uniform(draw, 1e4, 1e8)} if tyre else None,
    }


def _accepted(propose: Any, seed: int) -> Scene:
    """The first of the drawn scenes that the task accepts: a vehicle may be too stiff."""
    draw = np.random.default_rng(seed)
    while True:
        changes = {**_BARE, **propose(draw)}
        try:
            return resolve(TASK, changes)
        except ValueError:
            continue


def kerbs(draw: np.random.Generator) -> dict[str, Any]:
    """Kerbs up and down at equal distances, a square wave, at 1 to 100 m/s."""
    return _vehicle(draw, bool(draw.integers(2)))


def switched(draw: np.random.Generator) -> dict[str, Any]:
    """Damping from 0.001 to 1000 1/s and spring modulus from 0.01 to 100, over the whole range in every step."""
    vehicle = _vehicle(draw, bool(draw.integers(2)))
    rate = log_uniform(draw, 1.0, 1e7)
    ends = {"damping_low": 1e-3, "damping_high": 1e3, "modulus_low": 0.01, "modulus_high": 100.0}
    return {**vehicle, **ends, "spring_rate": rate, "mass": log_uniform(draw, 1.0, 1e4)}


def hopping(draw: np.random.Generator) -> dict[str, Any]:
    """A light wheel on a stiff tyre over the roughest road, fast: it leaves the ground and lands all the time."""
    vehicle = _vehicle(draw, True)
    return {**vehicle, "road": {"iso_class": str(draw.choice(list("EFGH"))), "knot_spacing": 0.05}, "speed": 100.0}


def still(draw: np.random.Generator) -> dict[str, Any]:
    """A level road."""
    vehicle = _vehicle(draw, bool(draw.integers(2)))
    return {**vehicle, "obstacle": {**vehicle["obstacle"], "height": 0.0}}


def _runs(propose: Any, steps: int, kinds: tuple[int, ...], every: int, small: bool = False) -> Any:
    def run(first: int, number: int, trace: np.ndarray) -> Outcome:
        outcome = Outcome()
        for seed in range(first, first + number):
            scene = _accepted(propose, seed)
            settings = Settings(seed, steps, kinds[seed % len(kinds)], every, facts_of(scene, small))
            judge(TASK, scene.as_dict(), settings, outcome, trace, denormal, check, REASONS)
        return outcome

    return run


def far(first: int, number: int, trace: np.ndarray) -> Outcome:
    """The default scene, on and on."""
    outcome = Outcome()
    for seed in range(first, first + number):
        settings = Settings(seed, 100_000, (UNIFORM, CORNERS, HELD, ZERO)[seed % 4], 1, (0.0,))
        judge(TASK, {}, settings, outcome, trace, nothing, no_check, ())
    return outcome


kerb_cases = _runs(kerbs, 500, (HELD, UNIFORM, CORNERS), 32)
switch_cases = _runs(switched, 500, (CORNERS, UNIFORM), 32)
hop_cases = _runs(hopping, 500, (HELD, CORNERS, ZERO), 32)
small_cases = _runs(still, 2000, (HELD, UNIFORM, CORNERS, ZERO), 1, True)
