"""The ladder of policies that need no training: from doing nothing to the strongest analytic law of a system.

The laws of a system are in `vr_envs.controllers.<task name>`: `LAWS` maps a policy's name to its class, `BASELINE`
names the law of the source documents. Their tuned gains are data, in `tuned/<task name>.json`; `vr-envs tune`
writes them.
"""

from __future__ import annotations

import importlib
import json
from pathlib import Path
from typing import Any

import numpy as np

from vr_envs.controllers.policy import Constant, Policy, Random
from vr_envs.envs.scene import Scene
from vr_envs.envs.task import Task

TUNED = Path(__file__).parent / "tuned"
NOTHING, RANDOM, CONSTANT = "do-nothing", "random", "best-constant"
UNTUNED = "-untuned"  # what follows the name of the documents' law with its default gains


def baseline_of(task: Task) -> str:
    """The name of the source documents' law among the policies of `task`."""
    return importlib.import_module(f"vr_envs.controllers.{task.name}").BASELINE


def laws_of(task: Task, scene: Scene | None = None) -> dict[str, Any]:
    """The analytic laws of `task`: name -> class, called with (scene, **gains).

    With a `scene` only those that make sense in it: a law may have a `serves(scene)` that says so.
    """
    laws = importlib.import_module(f"vr_envs.controllers.{task.name}").LAWS
    if scene is None:
        return laws
    return {name: law for name, law in laws.items() if not hasattr(law, "serves") or law.serves(scene)}


def tuned_file(task: Task) -> Path:
    """Where the tuned gains of `task` are."""
    return TUNED / f"{task.name}.json"


def tuned_of(task: Task) -> dict[str, dict[str, dict[str, Any]]]:
    """What was tuned for `task`: scene name -> policy name -> {"gains": ..., and how they were found}."""
    path = tuned_file(task)
    return json.loads(path.read_text()) if path.exists() else {}


def gains_of(task: Task, scene: Scene) -> dict[str, dict[str, float]]:
    """Policy name -> tuned gains, for the preset on which `scene` is based; what was not tuned is absent."""
    return {name: entry["gains"] for name, entry in tuned_of(task).get(scene.name, {}).items()}


def constant(task: Task, scene: Scene, gains: dict[str, float]) -> Constant:
    """The constant action with the given value for each action channel, by name; each in [-1, 1]."""
    return Constant(np.array([gains[c.name] for c in task.action_channels(scene)]))


def ladder(task: Task, scene: Scene) -> dict[str, Policy]:
    """Every policy of `task` that needs no training, by name, weakest first.

    A law has the gains tuned for the preset on which `scene` is based, or else its defaults. Where the documents' law
    was tuned, it is there with its defaults too, so that what tuning is worth can be seen. The best constant action is
    present only where one was found for the action channels of this scene.
    """
    gains = gains_of(task, scene)
    channels = [c.name for c in task.action_channels(scene)]
    policies: dict[str, Policy] = {
        NOTHING: Constant(np.zeros(len(channels))),
        RANDOM: Random(len(channels)),
    }
    if list(gains.get(CONSTANT, ())) == channels:
        policies[CONSTANT] = constant(task, scene, gains[CONSTANT])
    for name, law in laws_of(task, scene).items():
        if name in gains and name == baseline_of(task):
            policies[name + UNTUNED] = law(scene)
        policies[name] = law(scene, **gains.get(name, {}))
    return policies
