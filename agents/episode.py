"""An animated picture of a trained agent's episode."""

from __future__ import annotations

from pathlib import Path

from tqdm import tqdm

from agents.config import Config
from vr_envs.controllers.policy import Policy
from vr_envs.envs.registry import limit_of, task_of
from vr_envs.envs.scene import resolve
from vr_envs.evaluation.rollout import episode
from vr_envs.evaluation.scenarios import scenario_keys
from vr_envs.render import painter, write_animation
from vr_envs.render.film import pace, pictures

SLOW_MOTION = 4  # pictures per control interval, where a system has pictures in between


def film(config: Config, policy: Policy, path: Path, show: bool = True) -> None:
    """Write the first held-out episode, as an animation in the format that the path's suffix names.

    Args:
        config: of the run.
        policy: acts.
        path: ends in .gif, .mp4 or .png (the last picture).
        show: whether to show a progress bar.

    Raises:
        ImportError: a library of the extra `render` is missing.
    """
    task, limit = task_of(config.env), limit_of(config.env)
    scene = resolve(task, config.scene)
    artist = painter(task.name, scene, "rgb_array")
    between = SLOW_MOTION if hasattr(artist, "frames") else 1
    stride, fps = pace(task.dt(scene), between)
    states = episode(policy, task, scene, int(scenario_keys(1)[0]), limit)
    shown = tqdm(states, desc=path.name, total=limit + 1, unit="step", disable=None if show else True)
    write_animation(path, pictures(artist, shown, stride, between), fps)
    artist.close()
