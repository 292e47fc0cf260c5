"""All experiments, in the order of the source document."""

from __future__ import annotations

from vr_envs.experiments.experiment import Experiment

EXPERIMENTS: dict[str, Experiment] = {e.name: e for e in ()}
