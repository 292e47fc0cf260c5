"""The tables of what scenes do not need, one a part."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeVar

from vr_envs.bench.features.costs import Cost, same_calculation
from vr_envs.bench.features.impacts import ImpactCost
from vr_envs.bench.features.skipped import Finished, Flight, Judging, Rest
from vr_envs.bench.features.startup import Cold, Start, Warm
from vr_envs.bench.report import Table
from vr_envs.bench.timing import Spread

T = TypeVar("T")
PerSystem = Mapping[str, Sequence[T]]


def _two(spread: Spread) -> str:
    low, middle, high = (f"{value:.2f}" for value in spread)
    return f"{middle} ({low} to {high})"


def _time(spread: Spread) -> str:
    """Without a power of ten."""
    low, middle, high = (f"{value:.0f}" if value >= 100.0 else f"{value:.3g}" for value in spread)
    return f"{middle} ({low} to {high})"


def _change(new: int, old: int) -> str:
    return f"{new} ({new - old:+d})"


def option_tables(costs: PerSystem[Cost]) -> list[Table]:
    """One row an option."""
    head = [
        "option",
        "ns per step",
        "ns without it",
        "time ratio",
        "LLVM instructions",
        "machine instructions",
    ]
    tables = []
    for system, found in costs.items():
        rows = [
            [
                cost.name,
                _time(cost.time),
                _time(cost.other_time),
                _two(cost.ratio),
                *(
                    _change(own.total(), other.total())
                    for own, other in zip(cost.instructions, cost.other_instructions, strict=True)
                ),
            ]
            for cost in found
        ]
        note = (
            "Rows one by one; median (minimum to maximum). Instructions of the loop over rows with all that it calls, "
            "in brackets how many more than without the option."
        )
        if any(cost.impacts is not None for cost in found):
            note += " The ratio is per impact."
        tables.append(Table(f"Options that are on: {system}", head, rows, note=note))
    return tables


def pruning_table(costs: PerSystem[Cost]) -> Table:
    """One row a scene."""
    rows = [
        [
            system,
            cost.name,
            f"{cost.instructions.optimised.total()}",
            f"{cost.other_instructions.optimised.total()}",
            "yes" if same_calculation(cost) else "no",
            f"{cost.instructions.machine.total()}",
            f"{cost.other_instructions.machine.total()}",
            _two(cost.ratio),
        ]
        for system, found in costs.items()
        for cost in found
    ]
    head = ["system", "scene", "LLVM", "LLVM, cut", "calculate alike", "machine", "machine, cut", "time ratio"]
    note = (
        "Instructions of the shipped kernels and of kernels from which the absent options were cut by machine, which "
        "give the same bytes. They calculate alike if they have as many floating-point operations, loads and calls of "
        "library functions of each kind. An absent option is a null pointer in each call that is not inlined, which "
        "machine code passes on; and a call with fewer arguments may be inlined where the other is not."
    )
    return Table("Options that are off", head, rows, (0, 1), note)


def lockstep_table(costs: Mapping[str, Cost], alone: Mapping[str, Sequence[str]]) -> Table:
    """One row a system that moves rows in lockstep."""
    rows = [
        [system, cost.name, _time(cost.time), _time(cost.other_time), _two(cost.ratio), ", ".join(alone[system])]
        for system, cost in costs.items()
    ]
    head = ["system", "scene", "ns per step in lockstep", "one by one", "time ratio", "options that exclude it"]
    return Table("Rows in lockstep", head, rows, (0, 1, 5), "Eight rows are moved at a time, to the same bytes.")


def impact_table(costs: Sequence[ImpactCost]) -> Table:
    """One row a scene of the ball."""
    rows = [[cost.name, _time(cost.time), f"{cost.impacts:.2f}"] for cost in costs]
    return Table("An impact of the ball", ["scene", "ns per impact", "impacts per step"], rows)


def flight_table(found: Sequence[Flight]) -> Table:
    """One row a height."""
    rows = [[f"{f.height:g}", f"{f.impacts:.3g}", f.exact.text(), f.sampled.text()] for f in found]
    head = ["height [m]", "impacts per s", "exact, us per simulated s", "sampled (textbook engine)"]
    note = "A ball without losses on a bar that stands still; one step a base cycle, 15 a second."
    return Table("Jumped flight", head, rows, note=note)


def rest_table(found: Sequence[Rest]) -> Table:
    """One row a condition."""
    return Table("Resting ball", ["the ball", "ns per base cycle"], [[rest.name, _time(rest.time)] for rest in found])


def finished_table(found: PerSystem[Finished], rows: int) -> Table:
    """One row a share of rows that run."""
    body = [[system, f"{f.live}", _time(f.time), _two(f.ratio)] for system, some in found.items() for f in some]
    head = ["system", f"rows that run, of {rows}", "us per call of step", "over all running"]
    note = (
        "Default scenes, the rows that run evenly spread: where rows move eight at a time, a block with a finished one "
        "goes record by record. The records of finished rows are the same bytes afterwards."
    )
    return Table("Finished rows", head, body, note=note)


def judging_table(found: PerSystem[Judging]) -> Table:
    """One row a number of rows."""
    body = [
        [system, f"{j.rows}", j.time.text(), f"{100.0 * j.share:.2g} %"] for system, some in found.items() for j in some
    ]
    head = ["system", "rows that end at once", "us per row", "of an episode's steps in a batch"]
    return Table("Metrics at the end of an episode", head, body, note="Asked for when an episode ends, not in a step.")


def import_table(starts: Mapping[str, Start]) -> Table:
    """One row a stage of a start that ends with a picture."""
    body = [
        [f"{name}, {stage.name}", f"{1e3 * stage.cpu:.1f}", f"{stage.modules}", ", ".join(stage.heavy) or "-"]
        for name, found in starts.items()
        for stage in found.stages.values()
    ]
    head = ["stage", "ms CPU", "modules loaded", "of which heavy"]
    return Table("What is loaded when", head, body, (0, 3))


def warm_table(found: Sequence[Warm]) -> Table:
    """One row an id, scalar and batch."""
    rows = [
        [
            w.env_id,
            f"{w.rows} rows" if w.rows else "scalar",
            w.gymnasium.text(2),
            w.vr_envs.text(2),
            w.numba.text(2),
            w.kernels.text(2),
        ]
        for w in found
    ]
    head = ["id", "environment", "gymnasium", "vr_envs", "numba", "make, kernels, first step"]
    return Table("Start with kernels in the cache, CPU seconds", head, rows, (0, 1))


_SIDE_BY_SIDE = "In processes of their own, as many at a time as there are cores."


def cold_table(found: Sequence[Cold]) -> Table:
    """One row an id."""
    rows = [[c.env_id, f"{c.cpu:.1f}", f"{c.wall:.1f}", "yes" if c.said else "no"] for c in found]
    return Table(
        "Start with an empty cache, default scene", ["id", "CPU s", "clock s", "said so"], rows, note=_SIDE_BY_SIDE
    )
