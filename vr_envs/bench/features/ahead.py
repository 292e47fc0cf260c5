"""The kernels of all scenes that are measured, compiled before the measurements."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from tqdm import tqdm

from vr_envs.bench.ahead import side_by_side
from vr_envs.bench.features.cases import Changes, cases, plain
from vr_envs.bench.features.costs import one_by_one
from vr_envs.bench.features.impacts import scenes
from vr_envs.bench.features.stripped import stripped_task
from vr_envs.envs.registry import task_of
from vr_envs.envs.world import World

ROWS = 64  # enough for the kernels of a large batch


class Work(NamedTuple):
    """A scene of an id: in lockstep or one by one, as shipped or with kernels that never had the options it lacks."""

    env_id: str
    scene: Changes
    lockstep: bool = False
    bare: bool = False


def works_of(env_id: str) -> Iterator[Work]:
    """Everything that is compiled for an id."""
    task = task_of(env_id)
    default = {"base": task.default_scene}
    yield Work(env_id, default, lockstep=True)
    yield from (Work(env_id, scene, bare=bare) for scene in (plain(task), default) for bare in (False, True))
    for case in cases(task):
        yield from (Work(env_id, scene) for scene in (case.without, case.with_it))
    if task.name == "ball_on_bar":
        yield from (Work(env_id, scene) for scene, _ in scenes(task).values())


def compile_one(work: Work) -> bool:
    """Compile a scene's kernels, or load them; whether they were in the cache."""
    task = task_of(work.env_id)
    task = task if work.lockstep else one_by_one(task)
    if work.bare:
        with stripped_task(task, work.scene) as bare:
            return _cached(World(bare, None, ROWS))
    return _cached(World(task, work.scene, ROWS))


def _cached(world: World) -> bool:
    missed = sum(world.rows.reset.stats.cache_misses.values())
    world.compile()
    return sum(world.rows.reset.stats.cache_misses.values()) == missed


def compile_ahead(env_ids: Sequence[str], progress: bool = False) -> None:
    """Load everything for some ids of this suite; from the first scene on that is not in the cache, side by side."""
    works = list({repr(work): work for env_id in env_ids for work in works_of(env_id)}.values())
    left = iter(works)
    for work in tqdm(left, "kernels", len(works), leave=False, disable=None if progress else True):
        if not compile_one(work):
            break
    side_by_side(compile_one, list(left), progress)
