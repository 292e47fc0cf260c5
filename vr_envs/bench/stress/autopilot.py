"""Trials of the aircraft: demands that jump, standstill, a million turns, intervals from 1 ms to 1 h, rough air."""

from __future__ import annotations

import math
from typing import Any

import mpmath as mp
import numpy as np

from vr_envs.bench.stress.flight_check import REASONS, ROUNDING, facts_of, in_range, jumping_demands, lecture
from vr_envs.bench.stress.rows_walk import CORNERS, HELD, UNIFORM, Settings, judge
from vr_envs.bench.stress.trial import Failure, Outcome, log_uniform
from vr_envs.envs.autopilot import TASK
from vr_envs.envs.scene import resolve
from vr_envs.envs.world import World
from vr_envs.models import autopilot as model
from vr_envs.models.jit import kernel
from vr_envs.models.record import dtype_of, pack

KINDS = (CORNERS, UNIFORM, HELD)
STANDING = {"stall_speed": 0.0, "speed_low": 10.0}
LONGEST, SHORTEST = 3600.0, 1e-3  # s, of a control interval
_TURNS = 1_000_000
TURNED = 2.0**-52 * 2.0 * math.pi * _TURNS  # rad, by which the heading may be off after that: rounding of the angle
_ROWS, _WHILE = 30, 300  # aircraft, and steps
_LAW = {"headwind": 1.0, "updraught": 0.5, "updraught_lag": 0.25, "crosswind": 0.5, "crosswind_lag": 0.25}
_GUSTS = 0.25  # parts of a variance: more than five standard deviations of its estimate


def demands(first: int, number: int, trace: np.ndarray) -> Outcome:
    """Demands at the ends of the whole envelope, others in every step; actions as abrupt."""
    outcome = Outcome()
    for seed in range(first, first + number):
        scene = {"base": "airliner-rough", "demands": {"hold_low": 1.0, "hold_high": 1.0, "share_high": 1.0}}
        settings = Settings(seed, 2000, KINDS[seed % 3], 1, facts_of(resolve(TASK, scene), jumping=True))
        judge(TASK, scene, settings, outcome, trace, jumping_demands, in_range, REASONS)
    return outcome


def standing(first: int, number: int, trace: np.ndarray) -> Outcome:
    """An aircraft that never stalls, slowed to airspeed 0 and sped up again; the lecture's, and that of the default."""
    outcome = Outcome()
    for seed in range(first, first + number):
        draw = np.random.default_rng(seed)
        rates = {name: log_uniform(draw, 0.01, 10.0) for name in ("acceleration", "deceleration")}
        # the altitude does not matter here, and must not end the flight
        wide = {"ceiling": 2e4, "altitude_low": 9000.0, "altitude_high": 11000.0, "turn": draw.uniform(0.01, 1.0)}
        scene = {**STANDING, **rates, **wide, "base": ("lecture", "airliner-rough")[seed % 2]}
        if seed % 2:
            scene |= {"speed_high": 100.0, "shear": {"gradient": draw.uniform(0.0, 0.2)}}
        settings = Settings(seed, 1000, KINDS[seed // 2 % 3], 1, facts_of(resolve(TASK, scene)))
        judge(TASK, scene, settings, outcome, trace, jumping_demands, (lecture, in_range)[seed % 2], REASONS)
    return outcome


@kernel
def _turn(state, action, params, steps):
    """Turn on and on in one direction."""
    for _ in range(steps):
        model.advance(state, action, params, None, None, None, None, None, None, None, None, None)


def turns(first: int, number: int, trace: np.ndarray) -> Outcome:
    """A million turns in one direction, at intervals of up to an hour: the heading against 40 digits."""
    outcome = Outcome()
    for seed in range(first, first + number):
        draw = np.random.default_rng(seed)
        params = model.Params(turn=draw.uniform(0.5, 1.0), dt=log_uniform(draw, 1.0, LONGEST))
        steps = int(_TURNS * 2.0 * math.pi / (params.turn * params.dt))
        state = np.zeros(1, dtype_of(model.State))[0]
        _turn(state, np.array([0.0, 0.0, 1.0]), pack(params), steps)
        with mp.workdps(40):
            left = mp.mpf(params.turn) * mp.mpf(params.dt) * steps - mp.mpf(float(state["heading"]))
            error = abs(float(left - 2 * mp.pi * mp.nint(left / (2 * mp.pi))))
        outcome.add(Outcome(_TURNS, [], error, seed))
        if not (error < TURNED and abs(state["heading"]) <= math.pi + ROUNDING):
            outcome.failures.append(Failure(seed, f"the heading is {error:.1e} rad off"))
    return outcome


def intervals(first: int, number: int, trace: np.ndarray) -> Outcome:
    """One control interval of 1 ms to 1 h against the same time in several: the aircraft is in the same place."""
    outcome = Outcome()
    for seed in range(first, first + number):
        draw = np.random.default_rng(seed)
        whole = log_uniform(draw, 2.0 * SHORTEST, LONGEST)
        parts = max(2, int(min(draw.integers(2, 8), whole / SHORTEST)))
        scene: dict[str, Any] = {
            "base": "airliner-rough", "turbulence": None, "sensing": None, "demands": None, **STANDING,
            "refresh": min(10.0, max(whole / 500.0, log_uniform(draw, SHORTEST, 10.0))),
            "shear": {"gradient": draw.uniform(0.0, 0.2)},
            "lags": {"turn": log_uniform(draw, 0.05, 60.0), "along": log_uniform(draw, 0.05, 60.0)},
        }  # fmt: skip
        apart = _apart(scene, whole, parts, seed)
        outcome.add(Outcome(1, [], apart, seed))
        if not apart < 1e-9:
            outcome.failures.append(Failure(seed, f"{whole:.4g} s in {parts} intervals differs by {apart:.1e}"))
    return outcome


def _apart(scene: dict[str, Any], whole: float, parts: int, seed: int) -> float:
    """The `difference` of one interval from `parts`."""
    actions = np.random.default_rng([seed, 1]).uniform(-1.0, 1.0, (2, 3))
    world, ends = World(TASK, {**scene, "dt": whole}, 2), []
    world.reset(np.arange(2), np.array([seed, seed + 1], np.uint64), world.observe())
    before = world.copy()
    for count in (1, parts):
        world = World(TASK, {**scene, "dt": whole / count}, 2)
        world.load(before, np.arange(2))
        for _ in range(count):
            world.step(actions, np.ones(2, np.bool_), 1 << 62)
        ends.append(world.copy())
    return difference(before, *ends)


def difference(before: np.ndarray, one: np.ndarray, many: np.ndarray) -> float:
    """The largest difference of two flights from `before`, over what it changes and 1 m, 1 m/s, 1 rad."""
    apart = []
    for name in ("altitude", "speed", "x", "z", "vertical_speed", "acceleration", "turn_rate", "heading"):
        off = one[name] - many[name]
        if name == "heading":
            off = np.remainder(off + math.pi, 2.0 * math.pi) - math.pi
        scale = 1.0 + np.abs(one[name] - before[name])
        apart.append(np.abs(off) / scale)
    return float(np.max(apart))  # undefined where one is


def rough(first: int, number: int, trace: np.ndarray) -> Outcome:
    """Turbulence of up to 20 m/s: finite, and the gusts as strong as their law says."""
    outcome = Outcome()
    for seed in range(first, first + number):
        air = {"sigma": 20.0, "wind_20ft": 60.0}
        scene = {**STANDING, "base": "airliner-rough", "turbulence": air, "altitude_low": 1.0 if seed % 2 else 5000.0}
        settings = Settings(seed, 1000, KINDS[seed % 3], 1, facts_of(resolve(TASK, scene)))
        judge(TASK, scene, settings, outcome, trace, jumping_demands, in_range, REASONS)
        off = _gusts_off({**scene, "speed_low": 100.0}, seed)
        outcome.add(Outcome(worst=off, worst_seed=seed))
        if not off <= _GUSTS:
            outcome.failures.append(Failure(seed, f"a gust's variance is {off:.2f} of it off"))
    return outcome


def _gusts_off(scene: dict[str, Any], seed: int) -> float:
    """By how much the variances of the gusts, over many aircraft and a while, are off the law's, in parts of it."""
    world = World(TASK, scene, _ROWS)
    world.reset(np.arange(_ROWS), np.arange(_ROWS, dtype=np.uint64) + np.uint64(seed << 32), world.observe())
    sums = np.zeros(len(_LAW))
    for _ in range(_WHILE):
        world.step(np.zeros((_ROWS, 3)), np.ones(_ROWS, np.bool_), 1 << 62)
        sums += [float((world.states[name] ** 2).mean()) for name in _LAW]
    return float(np.abs(sums / _WHILE / np.array(list(_LAW.values())) - 1.0).max())
