"""What was aimed at, beside what was found."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from vr_envs.bench.speed.arrays.namespace import NUMPY
from vr_envs.bench.speed.contestants import CARTPOLE, Case
from vr_envs.bench.speed.measure import NATIVE, SCALAR, Measured

GOAL_ROWS = 1024
OVER_NUMPY = {64: 10.0, 4096: 3.0}  # rows -> how many times as fast as NumPy


@dataclasses.dataclass(frozen=True)
class Goal:
    """A number that `found` is to reach."""

    what: str
    unit: str
    wanted: float
    found: float

    @property
    def met(self) -> bool:
        """Whether it does."""
        return self.found >= self.wanted


def goals(cases: Sequence[Case], measured: Measured) -> list[Goal]:
    """All goals for which there are measurements; medians count."""
    found: list[Goal] = []
    cartpole = measured.of(CARTPOLE, SCALAR, 1)
    for case in cases:
        name = f"{case.label}, native batch of {GOAL_ROWS}"
        batch, one = measured.of(case.label, NATIVE, GOAL_ROWS), measured.of(case.label, SCALAR, 1)
        if case.goal is not None and batch is not None:
            found.append(Goal(name, "million steps/s", 1e-6 * case.goal, 1e-6 * batch.median))
        if one is not None and cartpole is not None:
            found.append(Goal(f"{case.label}, gym.make", f"times {CARTPOLE}", 1.0, one.median / cartpole.median))
        for rows, wanted in OVER_NUMPY.items():
            ours, theirs = (measured.of(case.label, family, rows) for family in (NATIVE, NUMPY.name))
            if ours is not None and theirs is not None:
                name = f"{case.label}, native batch of {rows}"
                found.append(Goal(name, "times NumPy", wanted, ours.median / theirs.median))
    return found
