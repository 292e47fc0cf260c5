"""`vr-envs render`: an animated picture of one episode."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from vr_envs.cli.common import (
    UserError,
    add_command,
    add_engine,
    add_scene,
    check_writable,
    positive,
    scene_of,
    user_input,
    whole,
)


def add(commands: Any) -> None:
    """Declare the arguments."""
    parser = add_command(
        commands,
        "render",
        "draw one episode of a policy that needs no training",
        "  vr-envs render BallOnBar-v0\n"
        "  vr-envs render BallOnBar-v0 --seconds 1 --between 40 --out impacts.mp4\n"
        "  vr-envs render Autopilot-v1 --policy random --scenario 7 --out flight.mp4\n"
        "  vr-envs render TerrainRide-v0 --scene lecture --seconds 2 --out ride.png",
    )
    parser.add_argument("id", help="an environment id; prefix and version may be left out")
    parser.add_argument("--policy", metavar="NAME", help="default: the source documents' law")
    add_scene(parser)
    add_engine(parser)
    parser.add_argument(
        "--scenario", type=whole(0), metavar="KEY", help="an episode key; default: the first held-out scenario"
    )
    parser.add_argument("--out", metavar="FILE", help=".gif, .mp4 or .png (the last picture); default <system>.gif")
    parser.add_argument("--seconds", type=positive, help="simulated seconds at most; default: the whole episode")
    parser.add_argument(
        "--between",
        type=whole(1),
        default=1,
        metavar="N",
        help="pictures per control interval, where the system has such: slow motion",
    )
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Write the picture."""
    from tqdm import tqdm

    from vr_envs.controllers.ladder import baseline_of, ladder
    from vr_envs.envs.registry import limit_of, task_of
    from vr_envs.envs.scene import resolve
    from vr_envs.evaluation.report import choose
    from vr_envs.evaluation.rollout import episode
    from vr_envs.evaluation.scenarios import scenario_keys
    from vr_envs.render.animation import SUFFIXES
    from vr_envs.render.film import pace, pictures

    with user_input():
        task, limit = task_of(arguments.id), limit_of(arguments.id)
        scene = resolve(task, scene_of(arguments.scene), arguments.engine)
        policies = ladder(task, scene)
        name = choose(policies, [arguments.policy or baseline_of(task)])[0]
    key = int(scenario_keys(1)[0]) if arguments.scenario is None else arguments.scenario
    if key >= 2**64:
        raise UserError(f"--scenario {key}; give a whole number below 2^64")
    out = arguments.out or f"{task.name}.gif"
    if Path(out).suffix not in SUFFIXES:
        raise UserError(f"--out {out}; the name ends in one of {', '.join(SUFFIXES)}")
    check_writable(out)
    steps = limit if arguments.seconds is None else min(limit, max(1, round(arguments.seconds / task.dt(scene))))
    try:
        from vr_envs.render import painter, write_animation

        with user_input():
            artist = painter(task.name, scene, "rgb_array")
        if arguments.between > 1 and not hasattr(artist, "frames"):
            raise UserError(f"--between {arguments.between}: {task.name} has no pictures between its control intervals")
        states = tqdm(episode(policies[name], task, scene, key, steps), total=steps + 1, unit="step", disable=None)
        stride, fps = pace(task.dt(scene), arguments.between)
        write_animation(out, pictures(artist, states, stride, arguments.between), fps)
        artist.close()
    except ImportError as error:
        raise UserError(str(error)) from error
    print(out)
