"""Tune the gains of a law, or the best constant action: CMA-ES on training-side scenarios.

CMA-ES: Hansen and Ostermeier (2001), package `cma`. The search runs in coordinates scaled to [0, 1], a gain whose
positive range spans a decade or more logarithmically. The first run starts from the defaults, the next ones from the
best of some random points, until the budget is used. The defaults and the best and the mean point of each run then
meet on fresh training-side scenarios, and the winner there is taken. Held-out scenarios are never seen.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from tqdm import tqdm

from vr_envs.controllers.ladder import CONSTANT, constant, gains_of, ladder, laws_of, tuned_file, tuned_of
from vr_envs.controllers.policy import Constant, Policy
from vr_envs.envs.scene import Scene
from vr_envs.envs.task import Task
from vr_envs.evaluation.files import write_json
from vr_envs.evaluation.rollout import rollout
from vr_envs.evaluation.scenarios import ScenarioSet, scenario_set

Gains = dict[str, float]
DECADE = 10.0
# a CMA-ES run gets at most this part of the budget; one that converges early leaves more to the next
RUNS = 2
SHORTEST = 12


@dataclasses.dataclass(frozen=True)
class Candidate:
    """A policy with free gains: `ranges` maps a gain's name to (low, high, default), `build` makes the policy."""

    ranges: dict[str, tuple[float, float, float]]
    build: Callable[[Gains], Policy]

    def gains(self, unit: np.ndarray) -> Gains:
        """Gains at a point of the unit cube."""
        found = {}
        for u, (name, (low, high, _)) in zip(np.clip(unit, 0.0, 1.0), self.ranges.items(), strict=True):
            value = low * (high / low) ** u if _logarithmic(low, high) else low + u * (high - low)
            found[name] = float(min(high, max(low, value)))
        return found

    def unit(self, gains: Gains) -> np.ndarray:
        """The point of the unit cube at which the gains are these."""
        return np.array(
            [
                math.log(gains[name] / low) / math.log(high / low)
                if _logarithmic(low, high)
                else (gains[name] - low) / (high - low)
                for name, (low, high, _) in self.ranges.items()
            ]
        )

    def default(self) -> np.ndarray:
        """The defaults as a point of the unit cube."""
        return self.unit({name: default for name, (_, _, default) in self.ranges.items()})


def _logarithmic(low: float, high: float) -> bool:
    return low > 0.0 and high >= DECADE * low


def candidates(task: Task, scene: Scene) -> dict[str, Candidate]:
    """What can be tuned in `scene`: every law with a gain in its `TUNABLE`, and last the constant action."""
    found = {
        name: Candidate(law.TUNABLE, lambda gains, law=law: law(scene, **gains))
        for name, law in laws_of(task, scene).items()
        if law.TUNABLE
    }
    channels = {c.name: (-1.0, 1.0, 0.0) for c in task.action_channels(scene)}
    found[CONSTANT] = Candidate(channels, lambda gains: constant(task, scene, gains))
    return found


def _constant_laws(task: Task, scene: Scene) -> list[np.ndarray]:
    """The actions of the laws that are constants, as points of the unit cube: the best constant is no worse."""
    policies = [policy for name, policy in ladder(task, scene).items() if name in laws_of(task)]
    return [(policy.action + 1.0) / 2.0 for policy in policies if isinstance(policy, Constant)]


def _search(
    score: Callable[[np.ndarray], float], origin: np.ndarray, budget: int, seed: int, width: float
) -> tuple[list[np.ndarray], int]:
    """One CMA-ES run of about `budget` evaluations that maximises `score`.

    Returns its best point and its last mean, and how many evaluations it took.

    CMA-ES needs two dimensions: a single gain gets an idle companion.
    """
    import cma

    k = len(origin)
    start = np.full(max(k, 2), 0.5)
    start[:k] = origin
    options = {"bounds": [0.0, 1.0], "seed": seed, "verbose": -9, "maxfevals": budget}
    run = cma.CMAEvolutionStrategy(start, width, options)
    while not run.stop():
        points = run.ask()
        run.tell(points, [-score(point[:k]) for point in points])
    result = run.result
    return [np.asarray(result.xbest)[:k], np.asarray(result.xfavorite)[:k]], int(result.evaluations)


def tune_policy(
    candidate: Candidate,
    train: ScenarioSet,
    check: ScenarioSet,
    evaluations: int,
    seed: int,
    known: Sequence[np.ndarray] = (),
    bar: Any = None,
) -> dict[str, Any]:
    """The best gains found, with the scores that chose them.

    Args:
        candidate: what to tune.
        train: scenarios of the search.
        check: fresh scenarios on which the finalists meet.
        evaluations: rollouts of the search; a CMA-ES generation that has begun is finished.
        seed: of the random points and of CMA-ES.
        known: points of the unit cube that are good already; they join the random ones and the finalists.
        bar: a tqdm bar to move on by one per rollout of the search, or None.
    """

    def score_on(scenarios: ScenarioSet, unit: np.ndarray) -> float:
        return float(rollout(candidate.build(candidate.gains(unit)), scenarios).scores.mean())

    def score(unit: np.ndarray) -> float:
        if bar is not None:
            bar.update()
        return score_on(train, unit)

    origin = candidate.default()
    points = [*known, *np.random.default_rng(seed).uniform(size=(max(2, evaluations // 6), len(origin)))]
    ranked = [points[k] for k in np.argsort([-score(point) for point in points], kind="stable")]
    finalists = [origin, *known]
    left = evaluations - len(points)
    share = left // RUNS
    for start, width in [(origin, 0.2), *((point, 0.3) for point in ranked)]:
        if left < SHORTEST:
            break
        found, used = _search(score, start, min(share, left), seed + len(finalists), width)
        finalists += found
        left -= used
    checked = [score_on(check, point) for point in finalists]
    winner = int(np.argmax(checked))
    return {
        "gains": candidate.gains(finalists[winner]),
        "training_score": score_on(train, finalists[winner]),
        "check_score": checked[winner],
        "default_check_score": checked[0],
    }


def choose_tunable(tunable: dict[str, Candidate], names: list[str] | None) -> list[str]:
    """`names`, or all if None.

    Raises:
        ValueError: a policy that is unknown or has no gains.
    """
    chosen = list(tunable) if names is None else names
    for name in chosen:
        if name not in tunable:
            raise ValueError(f"{name!r} has nothing to tune; choose among {', '.join(tunable)}")
    return chosen


def tune(
    env_id: str,
    scene: str | None = None,
    policies: list[str] | None = None,
    evaluations: int = 1000,
    scenarios: int = 128,
    seed: int = 0,
    progress: bool = False,
) -> dict[str, dict[str, Any]]:
    """Tune policies in a preset; each is stored in the task's tuned file when it is done. Returns what was stored.

    Gains that are stored already are a starting point and a finalist, so a short search does not make them worse.

    Args:
        env_id: a registered id.
        scene: a preset's name; None is the default preset.
        policies: names; None is all that can be tuned.
        evaluations: rollouts of the search per policy.
        scenarios: training-side scenarios per rollout; the finalists meet on four times as many others.
        seed: of the search and of the training-side scenarios.
        progress: show a progress bar on stderr, where that is a terminal.

    Raises:
        ValueError: unknown id, scene or policy.
        OSError: the tuned file cannot be written.
    """
    train = scenario_set(env_id, scene, n=scenarios, seed=2 * seed, side="training")
    check = scenario_set(env_id, scene, n=4 * scenarios, seed=2 * seed + 1, side="training")
    task, name = train.task, train.scene.name
    tunable = candidates(task, train.scene)
    chosen = choose_tunable(tunable, policies)
    found = {}
    with tqdm(total=len(chosen) * evaluations, unit="rollout", disable=None if progress else True) as bar:
        for policy in sorted(chosen, key=list(tunable).index):
            bar.set_description(policy)
            known = _constant_laws(task, train.scene) if policy == CONSTANT else []
            stored = gains_of(task, train.scene).get(policy)
            if stored is not None and stored.keys() == tunable[policy].ranges.keys():
                known.append(tunable[policy].unit(stored))
            found[policy] = {
                **tune_policy(tunable[policy], train, check, evaluations, seed, known, bar),
                "seed": seed,
                "evaluations": evaluations,
                "scenarios": scenarios,
                "command": (
                    f"vr-envs tune {train.env_id} --scene {name} --policy {policy} "
                    f"--evaluations {evaluations} --scenarios {scenarios} --seed {seed}"
                ),
            }
            _store(task, name, policy, found[policy])
    return found


def _store(task: Task, scene: str, policy: str, entry: dict[str, Any]) -> None:
    stored = tuned_of(task)
    stored[scene] = {**stored.get(scene, {}), policy: entry}
    tuned_file(task).parent.mkdir(exist_ok=True)
    write_json(tuned_file(task), stored)
