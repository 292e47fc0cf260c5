"""A configuration becomes a run folder: the policy, and how good it is."""

from __future__ import annotations

import dataclasses
import time
from pathlib import Path

import numpy as np
from gymnasium.spaces import Box

from agents import curve
from agents.config import Config, dump, load
from agents.learn import Learned, learn, make_batch
from agents.policy import TrainedPolicy, save_policy
from vr_envs.controllers.ladder import ladder
from vr_envs.controllers.policy import Constant, Policy
from vr_envs.envs.registry import limit_of, spec_of, task_of
from vr_envs.envs.scene import Scene, resolve
from vr_envs.envs.task import Task
from vr_envs.envs.world import box
from vr_envs.evaluation.files import write_bytes
from vr_envs.evaluation.report import Report, evaluate_ladder

CONFIG, POLICY = "config.yaml", "policy.safetensors"
RESULTS, TABLE, PICTURE = "results.json", "results.md", "episode.mp4"


def resolved(config: Config) -> tuple[Config, Task, Scene]:
    """The configuration with its scene spelt out (a preset's name where that says it all), the task and the scene.

    Raises:
        ValueError: unknown id or scene.
    """
    task = task_of(config.env)
    scene = resolve(task, config.scene)
    plain = scene == resolve(task, scene.name)
    return dataclasses.replace(config, scene=scene.name if plain else scene.as_dict()), task, scene


def initial_action(config: Config, task: Task, scene: Scene) -> np.ndarray | None:
    """The action at which the policy's mean starts.

    Raises:
        ValueError: wrong number of entries, or a policy that the ladder lacks or that is not constant.
    """
    given, width = config.initial_action, len(task.action_channels(scene))
    if given is None:
        return None
    if not isinstance(given, str):
        if len(given) != width:
            raise ValueError(f"initial_action has {len(given)} entries; {task.name} has {width} actions")
        return np.array(given)
    constants = {name: p.action for name, p in ladder(task, scene).items() if isinstance(p, Constant)}
    if given not in constants:
        raise ValueError(f"initial_action = {given!r} is no constant policy here; choose one of {', '.join(constants)}")
    return constants[given]


def new_folder(out: Path | None, config: Config, scene: Scene) -> Path:
    """Make the run's folder: `out`, or one under runs/ that names the run.

    Raises:
        ValueError: it exists already, or cannot be made.
    """
    name = spec_of(config.env).name
    stamp = time.strftime("%Y%m%d-%H%M%S")
    folder = out or Path("runs") / f"{name}-{scene.name}-{config.algorithm}-{config.seed}-{stamp}"
    try:
        folder.mkdir(parents=True)
    except FileExistsError as error:
        raise ValueError(f"{folder} exists already; give another --out or remove it") from error
    except OSError as error:
        raise ValueError(f"{folder}: cannot be made ({error.strerror})") from error
    return folder


def train(config: Config, out: Path | None = None, show: bool = True) -> tuple[Path, Learned]:
    """Train as `config` says and leave policy, configuration, log and learning curve in a new folder.

    Args:
        config: of the run.
        out: the folder to make; None is one under runs/.
        show: whether to show a progress bar.

    Raises:
        ValueError: something in the configuration does not fit the environment, or the folder exists.
    """
    config, task, scene = resolved(config)
    action = initial_action(config, task, scene)
    batch = make_batch(config.env, config.scene, config.num_envs)
    folder = new_folder(out, config, scene)
    write_bytes(folder / CONFIG, dump(config).encode())
    learned = learn(config, batch, action, folder, show)
    facts = {
        "env": config.env,
        "scene": scene.as_dict(),
        "hidden": list(config.hidden),
        "activation": config.activation,
        "timesteps": learned.timesteps,
        "training_s": round(learned.elapsed_s, 3),
    }
    save_policy(learned.model.policy, folder / POLICY, facts)
    draw_curve(folder, config, None)
    return folder, learned


def draw_curve(folder: Path, config: Config, baseline: tuple[str, float] | None) -> Path:
    """Draw the learning curve of the run in `folder`, with a baseline's held-out score as a line."""
    spec = spec_of(config.env)
    scene = resolve(task_of(config.env), config.scene).name
    return curve.draw(folder, limit_of(config.env), f"{spec.id}, scene {scene}, {config.algorithm.upper()}", baseline)


def load_run(folder: Path) -> tuple[Config, TrainedPolicy]:
    """Configuration and policy of a run, checked against each other.

    Raises:
        ValueError: not the folder of a run, or its policy is for other spaces.
    """
    config = load(folder / CONFIG)
    task = task_of(config.env)
    scene = resolve(task, config.scene)
    spaces: tuple[Box, Box] = (box(task.observation_channels(scene)), box(task.action_channels(scene)))
    return config, TrainedPolicy(folder / POLICY, *spaces)


def evaluate(
    folder: Path,
    level: str = "nominal",
    scenarios: int = 200,
    seed: int = 0,
    show: bool = True,
    engine: str | None = None,
) -> Report:
    """The run's agent beside the ladder of policies on held-out scenarios; `engine` None is that of the training.

    Raises:
        ValueError: not the folder of a run, or an unknown level or engine.
    """
    config, policy = load_run(folder)
    extra: dict[str, Policy] = {config.algorithm: policy}
    scene = resolve(task_of(config.env), config.scene, engine).as_dict()
    return evaluate_ladder(config.env, scene, level, scenarios, seed, extra, progress=show)
