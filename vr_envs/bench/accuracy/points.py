"""Points of run time against error: one method with one setting on one episode, its cost and its errors.

A system declares its kinds of error (`Measure`) and its `Run`s; `measured` carries the runs out and makes `Point`s of
them. The reference against which a run's errors are judged has at least 30 digits or is a closed form.

    TIME = Measure("impact time", "s", "largest over the impacts", rounding=1e-15)
    EULER = Method("Euler", "fixed step", "step", fixed_step=True)
    runs = [Run(EULER, "period one", h, partial(simulate, h), 10.0, judge) for h in (1e-3, 1e-4, 1e-5)]
    points = measured(runs, repeats=3, seconds=0.05, progress=True, title="ball on a bar")
    System("ball_on_bar", "Ball on a bar", [TIME], {"period one": "what happens"}, points)
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from tqdm import tqdm

from vr_envs.bench.timing import Spread, cpu_seconds, per_call

FAMILIES: tuple[str, ...] = (
    "exact",
    "textbook",
    "rigid body",
    "scipy",
    "MuJoCo",
    "pymunk",
    "fixed step",  # a compiled loop of equal steps; an event happens at a step's end
    "located step",  # a compiled loop of steps that are split where an event is found in them
)
"""What moves the state."""
LONG = 0.1  # s, of a call whose time is not repeated more than once


@dataclasses.dataclass(frozen=True)
class Measure:
    """A kind of error: what is wrong by how much of which unit, and how it is taken (a clause for the table's note).

    The unit of a relative error is "".

    `rounding`: the error, in the unit, at which the rounding of double precision takes over. Smaller ones are all as
    good, and what is below ten times that tells nothing of a method's order. Nor does an error above `astray`: such a
    run has lost the reference, and its error is as large as it can be.
    """

    name: str
    unit: str
    meaning: str
    rounding: float
    astray: float = math.inf

    @property
    def label(self) -> str:
        """Name and unit."""
        return f"{self.name} ({self.unit})" if self.unit else self.name

    def amount(self, error: float) -> str:
        """An error with its unit."""
        return f"{error:g} {self.unit}".rstrip()

    def of(self, point: Point) -> float:
        """The point's error, not below rounding."""
        return max(point.errors[self.name], self.rounding)

    def resolves(self, point: Point) -> bool:
        """Whether the point's error is well above rounding, so that it depends on the setting."""
        return point.errors[self.name] > 10.0 * self.rounding


@dataclasses.dataclass(frozen=True)
class Method:
    """What moves the state: a name, one of `FAMILIES`, and the setting that is swept.

    `setting`: "step" (s), "tolerance" (relative), another name, or "" for a method without one. `fixed_step`: whether
    it advances by equal steps whatever happens in them. A method that looks for an event's place inside its step and
    splits the step there is event-driven, if without a guarantee that it sees every event.
    """

    name: str
    family: str
    setting: str = ""
    fixed_step: bool = False

    def __post_init__(self) -> None:
        """Refuse an unknown family."""
        if self.family not in FAMILIES:
            raise ValueError(f"{self.family!r} is no family; choose one of {', '.join(FAMILIES)}")


@dataclasses.dataclass(frozen=True)
class Run:
    """One method with one value of its setting on one episode, not yet carried out.

    `work`: simulates the episode and returns what `judge` takes. `simulated`: simulated seconds of one call of `work`,
    which repeats an episode that is short beside the call. `judge`: name of a measure -> error (not negative, in the
    measure's unit, infinite where the run went astray).
    """

    method: Method
    episode: str
    value: float | None
    work: Callable[[], Any]
    simulated: float
    judge: Callable[[Any], Mapping[str, float]]


@dataclasses.dataclass(frozen=True)
class Point:
    """A run carried out: CPU seconds per simulated second, and errors by name of the measure."""

    method: Method
    episode: str
    value: float | None
    cost: Spread
    errors: dict[str, float]

    @property
    def label(self) -> str:
        """The method and the value of its setting."""
        unit = " s" if self.method.setting == "step" else ""
        return self.method.name if self.value is None else f"{self.method.name}, {self.value:.3g}{unit}"

    def as_dict(self) -> dict[str, Any]:
        """For programs."""
        return {
            "method": self.method.name,
            "family": self.method.family,
            "fixed_step": self.method.fixed_step,
            "episode": self.episode,
            self.method.setting or "setting": self.value,
            "cpu_seconds_per_simulated_second": self.cost._asdict(),
            "errors": self.errors,
        }


def measured(runs: Sequence[Run], repeats: int, seconds: float, progress: bool, title: str) -> list[Point]:
    """Carry out each run, judge what it returns, and time it `repeats` times for about `seconds` each.

    The runs of an episode are timed in turn within a repeat; those of which one call takes `seconds` by themselves, one
    call a repeat, and two repeats if it takes `LONG`. Compilation is not timed.

    Raises:
        ValueError: a judge gave an error that is negative or not a number.
    """
    points: dict[int, Point] = {}
    with tqdm(total=len(runs), desc=title, unit="run", leave=False, disable=None if progress else True) as bar:
        for episode in dict.fromkeys(run.episode for run in runs):
            group = [k for k, run in enumerate(runs) if run.episode == episode]
            errors: dict[int, dict[str, float]] = {}
            times: dict[int, list[float]] = {}
            for k in group:
                errors[k] = {name: float(value) for name, value in runs[k].judge(runs[k].work()).items()}
                bar.update(0.5)
                for name, value in errors[k].items():
                    if math.isnan(value) or value < 0.0:
                        raise ValueError(f"{runs[k].method.name}, {episode}: error of the {name} is {value}")
                times[k] = [cpu_seconds(runs[k].work)]
            long = [k for k in group if times[k][0] >= seconds]
            for repeat in range(1, repeats):
                for k in long:
                    if repeat == 1 or times[k][0] < LONG:
                        times[k].append(cpu_seconds(runs[k].work))
            short = [k for k in group if times[k][0] < seconds]
            times |= zip(short, per_call([runs[k].work for k in short], repeats, seconds), strict=True)
            bar.update(0.5 * len(group))
            for k in group:
                cost = Spread.of(times[k]).scaled(1.0 / runs[k].simulated)
                points[k] = Point(runs[k].method, episode, runs[k].value, cost, errors[k])
    return [points[k] for k in range(len(runs))]
