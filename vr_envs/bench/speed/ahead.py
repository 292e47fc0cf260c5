"""The kernels of the cases, compiled before the measurements."""

from __future__ import annotations

from collections.abc import Sequence

from vr_envs.bench.ahead import side_by_side
from vr_envs.bench.features.ahead import Work, compile_one
from vr_envs.bench.speed.contestants import Case
from vr_envs.envs.registry import ids, task_of
from vr_envs.envs.rows import LOCKSTEP_FROM, in_lockstep
from vr_envs.envs.scene import resolve


def works_of(cases: Sequence[Case]) -> list[Work]:
    """The kernels of the cases' scenes: of rows one by one and, where there are any, of rows in lockstep."""
    found = []
    for env_id, scene in dict.fromkeys((case.env_id, case.scene) for case in cases):
        task = task_of(env_id)
        kinds = (False, True) if in_lockstep(task, resolve(task, scene), LOCKSTEP_FROM) else (False,)
        found += [Work(env_id, {"base": scene or task.default_scene}, lockstep) for lockstep in kinds]
    return found


def compile_ahead(cases: Sequence[Case], progress: bool = False) -> None:
    """Have the kernels of all cases of this suite in the cache."""
    side_by_side(compile_one, works_of([case for case in cases if case.env_id in ids()]), progress)
