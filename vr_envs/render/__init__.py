"""Pictures of the systems; pygame and imageio are imported when a picture is drawn or written."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from vr_envs.render.animation import write_animation

if TYPE_CHECKING:
    from vr_envs.envs.scene import Scene
    from vr_envs.render.base import Painter

__all__ = ["TASKS", "painter", "write_animation"]

TASKS = ("ball_on_bar", "autopilot", "terrain_ride")


def painter(task_name: str, scene: Scene, render_mode: str) -> Painter:
    """The painter of a task's states, in "rgb_array" or "human" mode.

    Raises:
        ValueError: a task without pictures, or another mode.
        ImportError: pygame-ce or matplotlib (for its font) is missing; it says what to install.
    """
    if task_name not in TASKS:
        raise ValueError(f"there are no pictures of {task_name!r}; there are some of {', '.join(TASKS)}")
    return import_module(f"vr_envs.render.{task_name}").PAINTER(scene, render_mode)
