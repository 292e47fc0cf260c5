"""A ladder of policies on one scenario set: one table, one JSON."""

from __future__ import annotations

import dataclasses
import platform
from collections.abc import Mapping
from typing import Any

import gymnasium
import numba
import numpy as np
from tqdm import tqdm

import vr_envs
from vr_envs.controllers.ladder import NOTHING, baseline_of, ladder
from vr_envs.controllers.policy import Policy
from vr_envs.evaluation.files import plain, write_json
from vr_envs.evaluation.rollout import Rollout, rollout
from vr_envs.evaluation.scenarios import ScenarioSet, scenario_set
from vr_envs.evaluation.statistics import Estimate, bootstrap, difference, estimate, iqm, normalised
from vr_envs.evaluation.table import interval, markdown

SUCCESS = "is_success"
METRICS_SHOWN = 4
LEGEND = (
    "score: mean reward per possible step, 1 is perfect. normalised: do-nothing is 0, the documents' baseline 1.\n"
    "minus baseline: paired difference of the scores. success: share of the episodes with is_success."
)


@dataclasses.dataclass(frozen=True)
class Row:
    """One policy's results, each a mean with its 95 % interval.

    `score`: mean reward per possible step, `iqm`: its interquartile mean over scenarios, `normalised`: on the scale
    do-nothing = 0, baseline = 1, `difference`: paired, to the documents' baseline, `success`: share of scenarios,
    `metrics`: the task's own, `length`: control intervals.
    """

    policy: str
    score: Estimate
    iqm: Estimate
    normalised: Estimate
    difference: Estimate
    success: Estimate
    length: Estimate
    metrics: dict[str, Estimate]


@dataclasses.dataclass(frozen=True)
class Report:
    """Policies on one scenario set. `rollouts` holds the numbers per scenario, by policy."""

    scenarios: ScenarioSet
    baseline: str
    rows: tuple[Row, ...]
    rollouts: dict[str, Rollout]

    def table(self) -> str:
        """A title line and two Markdown tables, scores and the task's metrics, aligned to be read as plain text too."""
        names = list(self.rows[0].metrics)[:METRICS_SHOWN]
        labels = [f"{row.policy} (baseline)" if row.policy == self.baseline else row.policy for row in self.rows]
        head = ["policy", "score", "IQM", "normalised", "minus baseline", "success"]
        body = [
            [
                label,
                interval(row.score),
                interval(row.iqm, bounds=False),
                interval(row.normalised),
                "" if row.policy == self.baseline else interval(row.difference, sign=True),
                f"{100 * row.success.value:.1f} %",
            ]
            for label, row in zip(labels, self.rows, strict=True)
        ]
        metrics = [
            [label, *(interval(row.metrics[name]) for name in names)]
            for label, row in zip(labels, self.rows, strict=True)
        ]
        chosen = self.scenarios
        title = (
            f"{chosen.env_id}, scene {chosen.scene.label}, level {chosen.level}: "
            f"{len(chosen)} held-out scenarios (seed {chosen.seed}), mean [95 % interval]"
        )
        return f"{title}\n\n{markdown(head, body)}\n\n{markdown(['policy', *names], metrics)}\n\n{LEGEND}"

    def as_dict(self) -> dict[str, Any]:
        """The whole report in JSON's types; an undefined number is None."""
        chosen = self.scenarios
        return plain(
            {
                "env": chosen.env_id,
                "scene": chosen.scene.as_dict(),
                "level": chosen.level,
                "scenarios": len(chosen),
                "seed": chosen.seed,
                "max_episode_steps": chosen.limit,
                "baseline": self.baseline,
                "policies": {
                    row.policy: {
                        **{
                            field.name: getattr(row, field.name)._asdict()
                            for field in dataclasses.fields(row)
                            if field.name not in ("policy", "metrics")
                        },
                        "metrics": {name: value._asdict() for name, value in row.metrics.items()},
                    }
                    for row in self.rows
                },
                "versions": versions(),
            }
        )

    def to_json(self, path: str) -> None:
        """Write `as_dict()`, all or nothing.

        Raises:
            OSError: the folder is missing or cannot be written.
        """
        write_json(path, self.as_dict())


def versions() -> dict[str, str]:
    """What the numbers were made with."""
    return {
        "vr_envs": vr_envs.__version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "numba": numba.__version__,
        "gymnasium": gymnasium.__version__,
    }


def _row(name: str, run: Rollout, nothing: Rollout, baseline: Rollout) -> Row:
    return Row(
        policy=name,
        score=estimate(run.scores),
        iqm=bootstrap(iqm, run.scores),
        normalised=normalised(run.scores, nothing.scores, baseline.scores),
        difference=difference(run.scores, baseline.scores),
        success=estimate(run.metrics[SUCCESS]),
        length=estimate(run.lengths),
        metrics={key: estimate(values) for key, values in run.metrics.items() if key != SUCCESS},
    )


def choose(policies: Mapping[str, Policy], names: list[str] | None) -> list[str]:
    """`names` once each, or all if None.

    Raises:
        ValueError: no name at all, or an unknown one; it lists the policies.
    """
    chosen = list(policies) if names is None else list(dict.fromkeys(names))
    for name in chosen or [""]:
        if name not in policies:
            raise ValueError(f"there is no policy {name!r} in this scene; choose among {', '.join(policies)}")
    return chosen


def evaluate_ladder(
    env_id: str,
    scene: str | Mapping[str, Any] | None = None,
    level: str = "nominal",
    n: int = 200,
    seed: int = 0,
    extra: dict[str, Policy] | None = None,
    names: list[str] | None = None,
    progress: bool = False,
) -> Report:
    """Roll the ladder of policies out on one held-out scenario set.

    Args:
        env_id: a registered id; prefix and version may be left out.
        scene: preset or overrides, as for `gym.make`.
        level: "nominal", "light" or "severe".
        n: number of scenarios, at least 2.
        seed: which held-out set.
        extra: more policies, by name, such as trained agents; shown last.
        names: show these policies only, those of `extra` as well; do-nothing and the baseline are run in any case,
            for the scale.
        progress: show a progress bar on stderr, where that is a terminal.

    Raises:
        ValueError: unknown id, scene, level or policy, or a name in `extra` that the ladder already has.
    """
    scenarios = scenario_set(env_id, scene, level, n, seed)
    policies = ladder(scenarios.task, scenarios.scene)
    for name, policy in (extra or {}).items():
        if name in policies:
            raise ValueError(f"policy name {name!r} is taken; taken: {', '.join(policies)}")
        policies[name] = policy
    shown = choose(policies, names)
    baseline = baseline_of(scenarios.task)
    needed = [name for name in policies if name in {*shown, NOTHING, baseline}]
    runs = {}
    with tqdm(total=len(needed) * scenarios.limit, unit="step", disable=None if progress else True) as bar:
        for name in needed:
            bar.set_description(f"{name}, {level}")
            runs[name] = rollout(policies[name], scenarios, bar.update)
    rows = tuple(_row(name, runs[name], runs[NOTHING], runs[baseline]) for name in shown)
    return Report(scenarios, baseline, rows, {name: runs[name] for name in shown})
