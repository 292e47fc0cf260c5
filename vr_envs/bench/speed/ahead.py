"""Compilation before the measurements, by as many processes as there are cores; what they compile is in the cache."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from multiprocessing import get_context

from tqdm import tqdm

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
    works = works_of([case for case in cases if case.env_id in ids()])
    with (
        tqdm(total=len(works), desc="kernels", leave=False, disable=None if progress else True) as bar,
        ProcessPoolExecutor(os.cpu_count(), get_context("spawn")) as pool,
    ):
        waiting = {pool.submit(compile_one, work) for work in works}
        while waiting:
            done, waiting = wait(waiting, timeout=1.0, return_when=FIRST_COMPLETED)
            for future in done:
                future.result()
            bar.update(len(done))
            bar.refresh()
