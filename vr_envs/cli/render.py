"""`vr-envs render`: an animated picture of one episode."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from vr_envs.cli.common import UserError, add_command, add_scene, check_writable, positive, scene_of, user_input, whole

SUFFIXES = (".gif", ".mp4", ".png")
FRAMES_PER_SECOND = 30.0
SLOWEST = 10.0


def add(commands: Any) -> None:
    """Declare the arguments."""
    parser = add_command(
        commands,
        "render",
        "draw one episode of a policy that needs no training",
        "  vr-envs render BallOnBar-v0\n"
        "  vr-envs render Autopilot-v0 --policy random --scenario 7 --out flight.mp4\n"
        "  vr-envs render TerrainRide-v0 --scene lecture --seconds 2 --out ride.png",
    )
    parser.add_argument("id", help="an environment id; prefix and version may be left out")
    parser.add_argument("--policy", metavar="NAME", help="default: the source documents' law")
    add_scene(parser)
    parser.add_argument(
        "--scenario", type=whole(0), metavar="KEY", help="an episode key; default: the first held-out scenario"
    )
    parser.add_argument("--out", metavar="FILE", help=".gif, .mp4 or .png (the last picture); default <system>.gif")
    parser.add_argument("--seconds", type=positive, help="simulated seconds at most; default: the whole episode")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Write the picture."""
    from vr_envs.controllers.ladder import baseline_of, ladder
    from vr_envs.envs.registry import limit_of, task_of
    from vr_envs.envs.scene import resolve
    from vr_envs.evaluation.report import choose
    from vr_envs.evaluation.scenarios import scenario_keys

    with user_input():
        task, limit = task_of(arguments.id), limit_of(arguments.id)
        scene = resolve(task, scene_of(arguments.scene))
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
        _write(out, task, scene, policies[name], key, steps)
    except ImportError as error:
        raise UserError(f'pictures need more packages: pip install "vr_envs[render]" ({error})') from error
    print(out)


def pace(dt: float) -> tuple[int, float]:
    """Control intervals per picture and pictures per second: real time, but never below 10 pictures per second."""
    stride = max(1, round(1.0 / (FRAMES_PER_SECOND * dt)))
    return stride, max(SLOWEST, 1.0 / (stride * dt))


def _write(out: str, task: Any, scene: Any, policy: Any, key: int, steps: int) -> None:
    import numpy as np
    from tqdm import tqdm

    from vr_envs.envs.base import World
    from vr_envs.render import painter, write_animation

    world = World(task, scene.as_dict(), 1)
    observations = np.empty((1, world.widths[0]), np.float32)
    live = np.ones(1, np.bool_)
    world.reset(np.zeros(1, np.intp), np.array([key], np.uint64), observations)
    policy.reset(1)
    artist = painter(task.name, world.scene, "rgb_array")
    stride, fps = pace(task.dt(scene))
    frames = [artist.draw(world.states[0])]
    for step in tqdm(range(1, steps + 1), unit="step", disable=None):
        actions = world.actions(policy(observations), (1, world.widths[1]))
        observations, _, terminated, _ = world.step(actions, live, steps)
        last = bool(terminated[0]) or step == steps
        if last or step % stride == 0:
            frames.append(artist.draw(world.states[0]))
        if last:
            break
    artist.close()
    if out.endswith(".png"):
        from imageio.v3 import imwrite

        imwrite(out, frames[-1])
    else:
        write_animation(out, frames, fps)
