"""Scenes drawn from the fields' own ranges: every one is refused in words, or walked without a number going wrong."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np

from vr_envs.bench.stress.flight_check import REASONS as FLIGHT_REASONS
from vr_envs.bench.stress.flight_check import facts_of, in_range, jumping_demands
from vr_envs.bench.stress.rows_walk import BEYOND, CORNERS, HELD, UNIFORM, ZERO, Settings, judge, no_check, nothing
from vr_envs.bench.stress.trial import Failure, Outcome
from vr_envs.envs.registry import task_of
from vr_envs.envs.scene import resolve
from vr_envs.envs.task import Task

PRESETS = {"BallOnBar": ("bell", "lens"), "Autopilot": ("airliner-rough",), "TerrainRide": ("road", "quarter-car")}
"""Of each environment, the presets whose options are drawn: others would each be compiled anew."""
KINDS = (UNIFORM, CORNERS, HELD, ZERO, BEYOND)
STEPS = 200
MOST_CHANGES = 6
WIDTHS = {("terrain_ride", None, "actuation"), ("terrain_ride", "preview", "samples")}
"""Fields on which the number of actions or observations depends, for which the loops would be compiled anew."""
REFUSALS = ("is not allowed", "; give", ": give")
"""Words of which a refusal has one."""


def draw_value(field: dataclasses.Field[Any], draw: np.random.Generator) -> Any:
    """A value of a field: an end of its range, or anywhere in it; small and large alike where both are positive."""
    low, high, choices = (field.metadata[name] for name in ("low", "high", "choices"))
    if choices is not None:
        return str(draw.choice(choices))
    if str(field.type) == "bool":
        return bool(draw.integers(2))
    if not (math.isfinite(low) and math.isfinite(high)):
        return field.default
    if str(field.type).startswith("tuple"):
        return tuple(draw.uniform(low, high, draw.integers(1, 9)).tolist())
    end = draw.uniform()
    if end < 0.2:
        value = low if end < 0.1 else high
    elif low > 0.0:
        value = math.exp(draw.uniform(math.log(low), math.log(high)))
    elif draw.uniform() < 0.5:
        value = draw.uniform(low, high)
    else:  # near the usual value
        usual: Any = field.default
        value = float(np.clip(usual * draw.uniform(0.5, 2.0), low, high))
    value = min(high, max(low, value))
    return round(value) if str(field.type) == "int" else float(value)


def draw_scene(task: Task, preset: str, seed: int) -> dict[str, Any]:
    """A preset with a few of its values, and of its options', drawn."""
    draw = np.random.default_rng(seed)
    places: list[tuple[str | None, dataclasses.Field[Any]]] = [(None, f) for f in dataclasses.fields(task.params)]
    for name, cls in task.options.items():
        if task.scenes[preset].get(name):
            places += [(name, field) for field in dataclasses.fields(cls)]
    places = [(option, field) for option, field in places if (task.name, option, field.name) not in WIDTHS]
    scene: dict[str, Any] = {"base": preset}
    for k in draw.choice(len(places), int(draw.integers(1, MOST_CHANGES + 1)), replace=False):
        option, field = places[k]
        value = draw_value(field, draw)
        if option is None:
            scene[field.name] = value
        else:
            scene.setdefault(option, {})[field.name] = value
    return scene


def refused(task: Task, scene: dict[str, Any]) -> str | None:
    """What the task says against a scene; None if it takes it."""
    try:
        resolve(task, scene)
    except ValueError as error:
        return str(error)
    return None


def fuzzed(env_id: str) -> Any:
    """The cases of an environment."""

    def run(first: int, number: int, trace: np.ndarray) -> Outcome:
        outcome, task, presets = Outcome(), task_of(env_id), PRESETS[env_id]
        flies = env_id == "Autopilot"
        probe = (jumping_demands, in_range, FLIGHT_REASONS) if flies else (nothing, no_check, ())
        for seed in range(first, first + number):
            scene = draw_scene(task, presets[seed % len(presets)], seed)
            refusal = refused(task, scene)
            if refusal is None:
                facts = facts_of(resolve(task, scene)) if flies else (0.0,)
                settings = Settings(seed, STEPS, KINDS[seed // 2 % len(KINDS)], 1, facts)
                judge(task, scene, settings, outcome, trace, *probe)
            else:
                outcome.told += 1
                if not any(words in refusal for words in REFUSALS):
                    outcome.failures.append(Failure(seed, f"refused without saying what to do: {refusal}"))
        return outcome

    return run
