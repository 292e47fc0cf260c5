"""What an impact of the ball costs: the time of a step over the impacts in it."""

from __future__ import annotations

import dataclasses

from tqdm import tqdm

from vr_envs.bench.features.batch import SINK, Batch
from vr_envs.bench.features.cases import PLAIN, Changes, plain
from vr_envs.bench.timing import Spread, per_call
from vr_envs.envs.task import Task

ROWS = 256
WIDE = {"half_length": PLAIN["ball_on_bar"]["half_length"]}

STILL = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
HIGH = (0.4, 0.0, 0.5, 0.0, 0.5, 0.0)  # z at 10 m/s^2: a ball with every loss still bounces
CONTACT = ("scatter", "spin", "friction", "softening", "curve", "frequencies", "ramp")  # neither a sensor nor an engine


@dataclasses.dataclass(frozen=True)
class ImpactCost:
    """ns per impact in a scene, and how many impacts a step has."""

    name: str
    time: Spread
    impacts: float


def scenes(task: Task) -> dict[str, tuple[Changes, tuple[float, ...]]]:
    """Name -> scene and constant action."""
    bare = plain(task)
    return {
        "vertical, period one": (bare, STILL),
        "vertical, chatter": (bare | {"restitution": 0.5, "z_acceleration": 20.0}, STILL),
        "tilting, no option": (bare, SINK),
        **{name: ({"base": name} | WIDE, SINK) for name in ("bell", "rolling", "lens")},
        f"{', '.join(CONTACT)} at once": (bare | dict.fromkeys(CONTACT, True), HIGH),
    }


def impact_costs(task: Task, repeats: int, seconds: float, progress: bool = False) -> list[ImpactCost]:
    """Every scene of `scenes`, of the ball's task."""
    named = tqdm(scenes(task).items(), desc="impacts", leave=False, disable=None if progress else True)
    batches = {name: Batch(task, scene, ROWS, action=action) for name, (scene, action) in named}
    found = []
    for (name, batch), times in zip(batches.items(), per_call(list(batches.values()), repeats, seconds), strict=True):
        impacts = batch.impacts()
        assert impacts is not None
        found.append(ImpactCost(name, Spread.of(times).scaled(1e9 / batch.steps / impacts), impacts))
    return found
