"""Which scenes show what an option costs: a plain scene of each system, and the same with one option more."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

from vr_envs.envs.task import Task

Changes = dict[str, Any]

PLAIN: dict[str, Changes] = {
    # long enough for every motion, and a lens on it is nowhere steeper than 45 degrees
    "ball_on_bar": {"base": "bell", "half_length": 0.07},
    "autopilot": {"base": "lecture"},
    "terrain_ride": {"base": "lecture", "damping": "relative", "road": True},
}
"""System -> its scene without any option that it can do without."""

OVER: dict[tuple[str, str], Changes] = {
    ("autopilot", "wind"): {"track": True},  # without a track it moves nothing
    ("terrain_ride", "road"): {"undulation": True, "road": None},
    ("terrain_ride", "textbook"): {"damping": "absolute"},  # all that the lecture's recurrence knows
}
"""What an option needs, or stands in place of: the plain scene that it is compared with has it too."""

SETTINGS: dict[tuple[str, str], Changes] = {
    ("autopilot", "plan"): {
        "time": [30.0 * k for k in range(17)],
        "altitude": [3000.0 + 200.0 * (k % 5) for k in range(17)],
        "airspeed": [120.0 + 2.0 * (k % 7) for k in range(17)],
        "heading": [0.3 * (k % 3) for k in range(17)],
    },
    ("terrain_ride", "profile"): {"height": [0.01 * math.sin(0.3 * k) for k in range(512)]},
    ("terrain_ride", "obstacle"): {"first": 0.0, "every": 10.0},
}
"""Fields of an option whose defaults would leave it idle."""


class Case(NamedTuple):
    """An option, the scene without it and the scene with it, which differ in nothing else."""

    option: str
    without: Changes
    with_it: Changes


def plain(task: Task) -> Changes:
    """The plain scene of a task: every option absent that need not be there."""
    return {**dict.fromkeys(task.options), **PLAIN.get(task.name, {})}


def cases(task: Task) -> Iterator[Case]:
    """One case for every option of a task."""
    for option in task.options:
        key = (task.name, option)
        without = {**plain(task), **OVER.get(key, {option: None})}
        yield Case(option, without, {**without, option: SETTINGS.get(key, True)})
