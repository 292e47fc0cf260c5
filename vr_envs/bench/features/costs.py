"""What each option costs where it is on, and that it costs nothing where it is off.

Timed is the native loop over rows, one by one, observation and score included, in CPU time; a scene with and one
without the option are timed in turn within each repeat, so that a ratio compares times taken side by side. Compilation
is not timed. What it gains to move rows in lockstep, and which options exclude that, is told apart.
"""

from __future__ import annotations

import dataclasses

from tqdm import tqdm

from vr_envs.bench.features.batch import Batch
from vr_envs.bench.features.cases import Changes, cases, plain
from vr_envs.bench.features.instructions import Instructions
from vr_envs.bench.features.stripped import stripped_task
from vr_envs.bench.timing import Spread, per_call
from vr_envs.envs.rows import LOCKSTEP_FROM, in_lockstep
from vr_envs.envs.scene import resolve
from vr_envs.envs.task import Task

ROWS = 1024
NO_OPTION = "no option"  # the name of the plain scene


def one_by_one(task: Task) -> Task:
    """The task without the kernels that move rows in lockstep."""
    return dataclasses.replace(task, lockstep=None)


def outside_lockstep(task: Task) -> list[str]:
    """The options with which the rows of a large batch are moved one by one; the default scene has none of them."""
    default = resolve(task, task.default_scene).options
    others = [case for case in cases(task) if default[case.option] is None]
    return [case.option for case in others if not in_lockstep(task, resolve(task, case.with_it), LOCKSTEP_FROM)]


@dataclasses.dataclass(frozen=True)
class Cost:
    """Time (ns per step) and instructions of a scene, and of the one that it is compared with.

    `ratio`: of the times, where steps have impacts per impact, since an option may change their number.
    """

    name: str
    time: Spread
    other_time: Spread
    ratio: Spread
    impacts: float | None
    other_impacts: float | None
    instructions: Instructions
    other_instructions: Instructions


def same_calculation(cost: Cost) -> bool:
    """Whether both kernels have as many instructions of every kind that calculates."""
    return cost.instructions.calculation() == cost.other_instructions.calculation()


def compare(name: str, batch: Batch, other: Batch, repeats: int, seconds: float) -> Cost:
    """The cost of a batch beside another one."""
    runs = zip([batch, other], per_call([batch, other], repeats, seconds), strict=True)
    times, other_times = ([1e9 * time / one.steps for time in some] for one, some in runs)
    impacts, other_impacts = batch.impacts(), other.impacts()
    per_impact = 1.0 if impacts is None or other_impacts is None else other_impacts / impacts
    return Cost(
        name,
        Spread.of(times),
        Spread.of(other_times),
        Spread.of([per_impact * a / b for a, b in zip(times, other_times, strict=True)]),
        impacts,
        other_impacts,
        batch.instructions,
        other.instructions,
    )


def option_costs(task: Task, repeats: int, seconds: float, rows: int = ROWS, progress: bool = False) -> list[Cost]:
    """Every option of a task, one at a time: the scene with it beside the same scene without it."""
    task, found, without = one_by_one(task), [], {}
    for case in tqdm(
        list(cases(task)), desc=f"options of {task.name}", leave=False, disable=None if progress else True
    ):
        basis = repr(case.without)
        if basis not in without:
            without[basis] = Batch(task, case.without, rows)
        found.append(compare(case.option, Batch(task, case.with_it, rows), without[basis], repeats, seconds))
    return found


def same(batch: Batch, other: Batch) -> bool:
    """Whether two batches do the same, to the byte."""
    pairs = zip(batch.results(), other.results(), strict=True)
    return all(a.tobytes() == b.tobytes() for a, b in pairs)


def pruning_cost(name: str, task: Task, scene: Changes, repeats: int, seconds: float, rows: int = ROWS) -> Cost:
    """The shipped kernels in a scene beside kernels that never had the options that it lacks.

    Raises:
        ArithmeticError: the two differ in a byte.
    """
    task = one_by_one(task)
    with stripped_task(task, scene) as bare:
        shipped, other = Batch(task, scene, rows), Batch(bare, None, rows)
        if not same(shipped, other):
            raise ArithmeticError(f"{task.name}, {name}: the kernels without the absent options give another result")
        return compare(name, shipped, other, repeats, seconds)


def lockstep_cost(task: Task, repeats: int, seconds: float, rows: int = ROWS) -> Cost:
    """The default scene with its rows in lockstep beside the same one by one; they do the same to the byte.

    Raises:
        ArithmeticError: they do not.
    """
    together, alone = Batch(task, None, rows), Batch(one_by_one(task), None, rows)
    if not same(together, alone):
        raise ArithmeticError(f"{task.name}: rows in lockstep give another result than rows one by one")
    return compare(task.default_scene, together, alone, repeats, seconds)


def pruning_costs(task: Task, repeats: int, seconds: float, rows: int = ROWS, progress: bool = False) -> list[Cost]:
    """Of the plain scene of a task and of its default one."""
    scenes = [(NO_OPTION, plain(task)), (task.default_scene, {"base": task.default_scene})]
    works = tqdm(scenes, desc=f"{task.name}, options that are off", leave=False, disable=None if progress else True)
    return [pruning_cost(name, task, scene, repeats, seconds, rows) for name, scene in works]
