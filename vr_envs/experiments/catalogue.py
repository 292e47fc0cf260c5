"""All experiments, in the order of the source document."""

from __future__ import annotations

from vr_envs.experiments.experiment import Experiment

_ALL = (
    Experiment("vision", "2.1, 2.2", "The vision system tracks ball and bar", "vision:run"),
    Experiment("vision-error", "", "Error of the vision system over noise and resolution", "vision_error:run"),
)

EXPERIMENTS: dict[str, Experiment] = {e.name: e for e in _ALL}
