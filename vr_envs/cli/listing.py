"""`vr-envs list`: the environments, or everything about one."""

from __future__ import annotations

import argparse
import dataclasses
from typing import Any

from vr_envs.cli.common import add_command, add_scene, scene_of, user_input


def add(commands: Any) -> None:
    """Declare the arguments."""
    parser = add_command(
        commands,
        "list",
        "list the environments, or the scenes and channels of one",
        "  vr-envs list\n  vr-envs list BallOnBar-v0\n  vr-envs list TerrainRide-v0 --scene lecture",
    )
    parser.add_argument("id", nargs="?", help="an environment id; prefix and version may be left out")
    add_scene(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Print what was asked for."""
    print(overview() if arguments.id is None else details(arguments.id, scene_of(arguments.scene)))


def overview() -> str:
    """One line per id."""
    from vr_envs.envs.registry import ids, limit_of, task_of
    from vr_envs.envs.world import World
    from vr_envs.evaluation.table import markdown

    body = []
    for env_id in ids():
        task = task_of(env_id)
        world = World(task, None, 1)
        scenes = ", ".join(f"{s} (default)" if s == task.default_scene else s for s in task.scenes)
        body.append([env_id, scenes, str(limit_of(env_id)), f"{task.dt(world.scene):.4g}", *map(str, world.widths)])
    return markdown(["id", "scenes", "steps", "interval [s]", "observation", "action"], body, left=(0, 1))


def details(env_id: str, scene: Any) -> str:
    """The parameters of every scene of one id, and the channels in one of them."""
    from vr_envs.envs.registry import limit_of, spec_of, task_of
    from vr_envs.envs.scene import resolve
    from vr_envs.evaluation.table import markdown

    with user_input():
        task, limit = task_of(env_id), limit_of(env_id)
        chosen = resolve(task, scene)
    scenes = {name: resolve(task, name) for name in task.scenes}
    if isinstance(scene, dict):
        scenes["yours"] = chosen
    rows = _fields(task.params, [s.params for s in scenes.values()])
    for option, cls in task.additions.items():
        rows += _fields(cls, [s.added[option] for s in scenes.values()], f"{option}.")
    channels = {"observation": task.observation_channels(chosen), "action": task.action_channels(chosen)}
    blocks = [
        f"{spec_of(env_id).id}: {limit} steps of {task.dt(chosen):.4g} s; levels {', '.join(task.levels)}; "
        f"engines {', '.join(task.engine_names)}; observations {', '.join(task.observation_names)}",
        "Parameters by scene (in brackets: the option is absent, this is what it has where it is added)",
        markdown(
            ["parameter", *scenes, "unit", "allowed", "meaning"],
            rows,
            left=(0, *range(len(scenes) + 1, len(scenes) + 4)),
        ),
    ]
    for kind, listed in channels.items():
        body = [[str(k), c.name, f"[{c.low:g}, {c.high:g}]", c.unit or "1", c.doc] for k, c in enumerate(listed)]
        blocks += [
            f"{kind.capitalize()} channels in scene {chosen.label}",
            markdown(["", "channel", "range", "unit", "meaning"], body, left=range(5)),
        ]
    return "\n\n".join(blocks)


def _fields(cls: type, instances: list[Any], prefix: str = "") -> list[list[str]]:
    rows = []
    if not dataclasses.fields(cls):  # there, or not
        present = ["null" if i is None else "true" for i in instances]
        rows.append([prefix.rstrip("."), *present, "", "true, null", (cls.__doc__ or "").partition("\n")[0]])
    for field in dataclasses.fields(cls):
        meta = field.metadata
        values = [f"({_value(field.default)})" if i is None else _value(getattr(i, field.name)) for i in instances]
        bounded = meta["low"] > float("-inf") or meta["high"] < float("inf")
        allowed = ", ".join(meta["choices"] or ()) or (f"[{meta['low']:g}, {meta['high']:g}]" if bounded else "")
        rows.append([prefix + field.name, *values, meta["unit"], allowed, meta["doc"]])
    return rows


def _value(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
