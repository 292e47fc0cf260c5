"""Scenario sets: which episodes a policy is judged on.

A scenario is a 64-bit episode key: start, scatter and disturbances all follow from it. Held-out keys and the keys
for tuning come from seed sequences with different, fixed entropies; the environments' own episodes come from
Gymnasium's `seeding.np_random(seed)`, whose entropy is `seed` alone. So the three streams are statistically
independent, and two sets of 1000 keys share one with probability below 1e-13.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

from vr_envs.envs.registry import limit_of, spec_of, task_of
from vr_envs.envs.scene import Scene, resolve
from vr_envs.envs.task import Task

Side = Literal["held-out", "training"]
_ENTROPY: dict[str, int] = {"held-out": 0x68656C642D6F7574, "training": 0x747261696E696E67}  # the names, in ASCII


@dataclasses.dataclass(frozen=True)
class ScenarioSet:
    """`n` episodes of one environment, the same for every policy.

    `scene` is what policies are designed for; `world` is the same scene at the level's disturbances, where they run.
    `keys`: uint64, shape (n,). `limit`: control intervals per episode.
    """

    env_id: str
    task: Task
    scene: Scene
    world: Scene
    level: str
    seed: int
    keys: np.ndarray
    limit: int

    def __len__(self) -> int:
        """Number of scenarios."""
        return len(self.keys)


def scenario_keys(n: int, seed: int = 0, side: Side = "held-out") -> np.ndarray:
    """`n` episode keys, uint64; the first k of a larger set are the set of k."""
    generator = np.random.default_rng(np.random.SeedSequence((_ENTROPY[side], seed)))
    return generator.integers(np.iinfo(np.uint64).max, size=n, dtype=np.uint64, endpoint=True)


def at_level(task: Task, scene: Scene, level: str) -> Scene:
    """`scene` with the level's changes laid over it.

    A level makes the disturbances that a scene has stronger or weaker; an option that the scene leaves out stays out.

    Raises:
        ValueError: unknown level.
    """
    if level not in task.levels:
        raise ValueError(f"{task.name} has no level {level!r}; choose one of {', '.join(task.levels)}")
    values = scene.as_dict()
    for key, change in task.levels[level].items():
        if key not in task.options:
            values[key] = change
        elif values[key] is not None:
            values[key] = {**values[key], **change} if isinstance(change, Mapping) else change
    return resolve(task, values)


def scenario_set(
    env_id: str,
    scene: str | Mapping[str, Any] | None = None,
    level: str = "nominal",
    n: int = 200,
    seed: int = 0,
    side: Side = "held-out",
) -> ScenarioSet:
    """The scenario set of an environment: `n` keys, the same at every level, so that levels are paired too.

    Raises:
        ValueError: unknown id, scene or level, a scene without metrics, or an n below 2.
    """
    if n < 2:
        raise ValueError(f"{n} scenarios; give at least 2")
    if seed < 0:
        raise ValueError(f"seed = {seed}; give a whole number of at least 0")
    task = task_of(env_id)
    base = resolve(task, scene)
    if not base.judged:
        raise ValueError("metrics = null is not allowed where policies are judged; give metrics = true")
    keys = scenario_keys(n, seed, side)
    return ScenarioSet(spec_of(env_id).id, task, base, at_level(task, base, level), level, seed, keys, limit_of(env_id))
