"""What is not computed because nothing happens in it: flight, rest, finished rows, and metrics nobody waits for."""

from __future__ import annotations

import copy
import dataclasses
import math
from collections.abc import Sequence
from functools import partial

import numpy as np
from tqdm import tqdm

from vr_envs.bench.features.batch import Batch
from vr_envs.bench.features.cases import Changes, plain
from vr_envs.bench.features.impacts import STILL
from vr_envs.bench.timing import Spread, per_call
from vr_envs.envs.task import Task
from vr_envs.models.constants import G

FLIGHT_ROWS = 16
FLIGHT_STEPS = 60  # base cycles: four seconds
HEIGHTS = (0.001, 0.01, 0.1, 1.0, 10.0)  # m
STILL_BAR: Changes = {"z_acceleration": 0.0, "z_acceleration_span": 0.0}
REST_ROWS = 256
REST_AGE = 60  # base cycles, after which a ball without bounce is at rest
LIVE = (1.0, 0.25, 1.0 / 64.0)  # shares of the rows that are not finished
ROWS = 1024


@dataclasses.dataclass(frozen=True)
class Flight:
    """CPU time (us) per simulated second of a ball that bounces for ever, `height` (m) high, `impacts` times a second.

    `exact` jumps from impact to impact, `sampled` looks at the gap as often as Bell's simulator does.
    """

    height: float
    impacts: float
    exact: Spread
    sampled: Spread


def flights(
    task: Task, repeats: int, seconds: float, heights: Sequence[float] = HEIGHTS, progress: bool = False
) -> list[Flight]:
    """On a bar that stands still, without losses."""
    scene = plain(task) | STILL_BAR | {"restitution": 1.0, "half_length": 10.0}
    found = []
    for height in tqdm(heights, desc="flights", leave=False, disable=None if progress else True):
        fields = {"x": 0.0, "z": height, "w": 0.0}
        batches = [
            Batch(task, changes, FLIGHT_ROWS, FLIGHT_STEPS, 0, STILL, fields)
            for changes in (scene, scene | {"textbook": True})
        ]
        simulated = batches[0].steps * task.dt(batches[0].world.scene)
        exact, sampled = (Spread.of(times).scaled(1e6 / simulated) for times in per_call(batches, repeats, seconds))
        found.append(Flight(height, 0.5 / math.sqrt(2.0 * height / G), exact, sampled))
    return found


@dataclasses.dataclass(frozen=True)
class Rest:
    """ns per base cycle of a ball in one condition."""

    name: str
    time: Spread


def rests(task: Task, repeats: int, seconds: float) -> list[Rest]:
    """A ball that bounces twice a cycle, and one that lies on the bar.

    Raises:
        ArithmeticError: a ball that should lie does not.
    """
    bare = plain(task)
    lying = bare | {"restitution": 0.0}
    scenes = {
        "bounces twice a cycle": bare,
        "lies on a bar that stands still": lying | STILL_BAR,
        "lies on a bar that moves with 8 m/s^2": lying | {"z_acceleration": 8.0},
    }
    batches = [Batch(task, scene, REST_ROWS, ages=REST_AGE, action=STILL) for scene in scenes.values()]
    for name, batch in zip(scenes, batches, strict=True):
        # the youngest rows are at their start, in the air
        resting = batch.begin["resting"][REST_ROWS // 2 :]
        if resting.all() != name.startswith("lies"):
            raise ArithmeticError(f"a ball that {name} is at rest in {int(resting.sum())} of {resting.size} rows")
    times = per_call(batches, repeats, seconds)
    return [Rest(name, Spread.of(t).scaled(1e9 / b.steps)) for name, b, t in zip(scenes, batches, times, strict=True)]


@dataclasses.dataclass(frozen=True)
class Finished:
    """us per call of `step` for `ROWS` rows of which only `live` run, and that over the time with all of them."""

    live: int
    time: Spread
    ratio: Spread


def finished(task: Task, repeats: int, seconds: float, rows: int = ROWS) -> list[Finished]:
    """In the default scene, with fewer and fewer rows that run.

    Raises:
        ArithmeticError: a finished row has changed.
    """
    whole = Batch(task, None, rows)
    batches = []
    for share in LIVE:
        batch = copy.copy(whole)
        batch.live = np.arange(rows) % round(1.0 / share) == 0
        after = batch.results()[-1]
        moved = after["steps"] - batch.begin["steps"]
        if after[~batch.live].tobytes() != batch.begin[~batch.live].tobytes() or (moved[batch.live] == 0).any():
            raise ArithmeticError(f"{task.name}: a finished row has changed, or one that runs has not")
        batches.append(batch)
    times = per_call(batches, repeats, seconds)
    return [
        Finished(
            int(batch.live.sum()),
            Spread.of(own).scaled(1e6 / len(batch.actions)),
            Spread.of([a / b for a, b in zip(own, times[0], strict=True)]),
        )
        for batch, own in zip(batches, times, strict=True)
    ]


@dataclasses.dataclass(frozen=True)
class Judging:
    """us for the metrics of so many rows whose episodes have ended, per row, and over the steps of one episode."""

    rows: int
    time: Spread
    share: float


def judging(task: Task, limit: int, repeats: int, seconds: float, rows: int = ROWS) -> list[Judging]:
    """In the default scene, for one row at a time and for all; `limit`: steps of an episode."""
    batch = Batch(task, None, rows)
    batch()  # every row has made a step
    counts = (1, rows)
    works = [partial(batch.world.metrics, np.arange(count)) for count in counts]
    *times, steps = per_call([*works, batch], repeats, seconds)
    episode = Spread.of(steps).median / batch.steps * limit
    return [
        Judging(count, Spread.of(own).scaled(1e6 / count), Spread.of(own).median / count / episode)
        for count, own in zip(counts, times, strict=True)
    ]
