"""Compilation ahead of the measurements, by as many processes as there are cores; what they compile is in the cache."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import NamedTuple

from tqdm import tqdm

from vr_envs.bench.features.cases import Changes, cases, plain
from vr_envs.bench.features.impacts import scenes
from vr_envs.bench.features.stripped import stripped_task
from vr_envs.envs.registry import task_of
from vr_envs.envs.world import World

ROWS = 64  # enough for the kernels of a large batch


class Work(NamedTuple):
    """A scene of an id, with the shipped kernels or with some that never had the options that it lacks."""

    env_id: str
    scene: Changes
    bare: bool = False


def works_of(env_id: str) -> Iterator[Work]:
    """Everything that is compiled for an id."""
    task = task_of(env_id)
    default = {"base": task.default_scene}
    yield from (Work(env_id, scene, bare) for scene in (plain(task), default) for bare in (False, True))
    for case in cases(task):
        yield from (Work(env_id, scene) for scene in (case.without, case.with_it))
    if task.name == "ball_on_bar":
        yield from (Work(env_id, scene) for scene, _ in scenes(task).values())


def compile_one(work: Work) -> bool:
    """Compile a scene's kernels, or load them; whether they were in the cache."""
    task = task_of(work.env_id)
    if work.bare:
        with stripped_task(task, work.scene) as bare:
            return _cached(World(bare, None, ROWS))
    return _cached(World(task, work.scene, ROWS))


def _cached(world: World) -> bool:
    missed = sum(world.rows.reset.stats.cache_misses.values())
    world.compile()
    return sum(world.rows.reset.stats.cache_misses.values()) == missed


def compile_ahead(env_ids: Sequence[str], progress: bool = False) -> None:
    """Compile everything for some ids of this suite, side by side, unless the first scene is in the cache."""
    works = list({repr(work): work for env_id in env_ids for work in works_of(env_id)}.values())
    if all(compile_one(work) for work in works[:1]):
        return
    with ProcessPoolExecutor(os.cpu_count(), get_context("spawn")) as pool:
        rest = pool.map(compile_one, works[1:])
        list(tqdm(rest, "compiling", len(works) - 1, leave=False, disable=not progress))
