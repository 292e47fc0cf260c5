"""All experiments, in the order of the source document."""

from __future__ import annotations

from vr_envs.experiments.experiment import Experiment

VERTICAL = (
    Experiment("period-one", "Figs 3.1, 3.2, Table 3.1", "period one at 30 Hz", "period_figures:period_one"),
    Experiment("period-two", "Figs 3.3, 3.4, Table 3.2", "period two at 30 Hz", "period_figures:period_two"),
    Experiment(
        "period-three", "Fig 3.5", "period three at 30 Hz, and the starts that lead to it", "period_three:period_three"
    ),
    Experiment("period-one-m2", "Fig 3.6", "period one over two bar cycles at 20 Hz", "period_figures:period_one_m2"),
    Experiment("period-two-m2", "Fig 3.7", "period two over four bar cycles at 20 Hz", "period_figures:period_two_m2"),
)

EXPERIMENTS: dict[str, Experiment] = {e.name: e for e in VERTICAL}
