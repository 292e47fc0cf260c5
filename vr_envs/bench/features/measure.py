"""All that a scene does not need, measured: options, flight, rest, finished rows, metrics, imports, start."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from typing import Any

from tqdm import tqdm

from vr_envs.bench.ahead import cores
from vr_envs.bench.features import sentences, skipped, startup, tables
from vr_envs.bench.features.ahead import compile_ahead
from vr_envs.bench.features.costs import ROWS, lockstep_cost, option_costs, outside_lockstep, pruning_costs
from vr_envs.bench.features.impacts import impact_costs
from vr_envs.bench.features.instructions import Instructions
from vr_envs.bench.features.picture import option_bars
from vr_envs.bench.report import Report
from vr_envs.envs.registry import ids as own_ids
from vr_envs.envs.registry import limit_of, spec_of, task_of
from vr_envs.envs.task import Task

BATCH = 64  # rows of the batch whose start is measured


@dataclasses.dataclass(frozen=True)
class Effort:
    """How much is measured: repeats of so many seconds, rows of a batch, starts of each kind, and compilations."""

    repeats: int = 5
    seconds: float = 0.05
    rows: int = ROWS
    starts: int = 2
    batches: tuple[int, ...] = (0, BATCH)
    cold: bool = True


QUICK = Effort(2, 0.01, 256, 1, (0,), False)


def report(ids: Sequence[str], effort: Effort, progress: bool = False) -> Report:
    """Measure every part for the given ids.

    Raises:
        ValueError: an id is unknown.
        ArithmeticError: what should be the same to the byte is not.
    """
    tasks = {task.name: task for task in map(task_of, ids)}
    compile_ahead([name for name in (spec_of(env_id).id for env_id in ids) if name in own_ids()], progress)
    found = Report("features", "What a scene does not need")
    _options(found, list(tasks.values()), effort, progress)
    if "ball_on_bar" in tasks:
        _ball(found, tasks["ball_on_bar"], effort, progress)
    _rows(found, {task_of(env_id).name: env_id for env_id in ids}, effort, progress)
    _starts(found, [spec_of(env_id).id for env_id in ids], effort, progress)
    return found


def _options(found: Report, tasks: list[Task], effort: Effort, progress: bool) -> None:
    given = (effort.repeats, effort.seconds, effort.rows, progress)
    on = {task.name: option_costs(task, *given) for task in tasks}
    off = {task.name: pruning_costs(task, *given) for task in tasks}
    lockstep = {t.name: lockstep_cost(t, *given[:-1]) for t in tasks if t.lockstep is not None}
    alone = {t.name: outside_lockstep(t) for t in tasks}
    found.sentences += [sentences.on(on), sentences.off(off)]
    found.tables += [*tables.option_tables(on), tables.pruning_table(off)]
    if lockstep:
        found.sentences.append(sentences.lockstep(lockstep, alone))
        found.tables.append(tables.lockstep_table(lockstep, alone))
    found.numbers |= {"options_on": _plain(on), "options_off": _plain(off), "lockstep": _plain(lockstep)}
    found.figures["options"] = option_bars(on, off)


def _ball(found: Report, task: Task, effort: Effort, progress: bool) -> None:
    impacts = impact_costs(task, effort.repeats, effort.seconds, progress)
    flights = skipped.flights(task, effort.repeats, effort.seconds, progress=progress)
    rests = skipped.rests(task, effort.repeats, effort.seconds)
    found.sentences += [sentences.flight(flights), sentences.rest(rests)]
    found.tables += [tables.impact_table(impacts), tables.flight_table(flights), tables.rest_table(rests)]
    found.numbers |= {"impacts": _plain(impacts), "flights": _plain(flights), "rests": _plain(rests)}


def _rows(found: Report, ids: dict[str, str], effort: Effort, progress: bool) -> None:
    finished, judging = {}, {}
    for system, env_id in _shown(list(ids.items()), "finished rows, metrics", progress):
        task = task_of(env_id)
        finished[system] = skipped.finished(task, effort.repeats, effort.seconds, effort.rows)
        judging[system] = skipped.judging(task, limit_of(env_id), effort.repeats, effort.seconds, effort.rows)
    found.sentences += [sentences.finished(finished, effort.rows), sentences.judging(judging)]
    found.tables += [tables.finished_table(finished, effort.rows), tables.judging_table(judging)]
    found.numbers |= {"finished_rows": _plain(finished), "metrics": _plain(judging)}


def _starts(found: Report, ids: list[str], effort: Effort, progress: bool) -> None:
    kinds = [(env_id, rows) for env_id in ids for rows in effort.batches]
    warm = [startup.warm_start(env_id, rows, effort.starts) for env_id, rows in _shown(kinds, "starts", progress)]
    found.sentences.append(sentences.warm(warm))
    found.tables.append(tables.warm_table(warm))
    found.numbers["warm_starts"] = _plain(warm)
    if find_spec("pygame") is not None:  # of the extra `render`
        looks = {env_id: startup.start(env_id, look=True) for env_id in _shown(ids, "pictures", progress)}
        found.sentences.append(sentences.imports(looks))
        found.tables.append(tables.import_table(looks))
        found.numbers["imports"] = _plain(looks)
    if effort.cold:
        with ThreadPoolExecutor(cores()) as pool:  # each in a process of its own, whose CPU time counts
            cold = list(_shown(pool.map(startup.cold_start, ids), "compiling in an empty cache", progress, len(ids)))
        found.sentences.append(sentences.cold(cold))
        found.tables.append(tables.cold_table(cold))
        found.numbers["cold_starts"] = _plain(cold)


def _shown(works: Iterable[Any], what: str, progress: bool, total: int | None = None) -> Iterator[Any]:
    return iter(tqdm(works, desc=what, total=total, leave=False, disable=None if progress else True))


def _plain(value: Any) -> Any:
    """As JSON can hold it; of instructions their numbers."""
    if isinstance(value, Instructions):
        return {"optimised": value.optimised.total(), "machine": value.machine.total()}
    if dataclasses.is_dataclass(value):
        return {field.name: _plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, dict):
        return {key: _plain(part) for key, part in value.items()}
    if hasattr(value, "_asdict"):
        return value._asdict()
    return [_plain(part) for part in value] if isinstance(value, list | tuple) else value
