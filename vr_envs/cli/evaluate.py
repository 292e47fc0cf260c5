"""`vr-envs evaluate`: the policies that need no training, on held-out scenarios."""

from __future__ import annotations

import argparse
from typing import Any

from vr_envs.cli.common import add_command, add_engine, add_scene, check_writable, names, scene_of, user_input, whole


def add(commands: Any) -> None:
    """Declare the arguments."""
    parser = add_command(
        commands,
        "evaluate",
        "roll the policies that need no training out on held-out scenarios",
        "  vr-envs evaluate BallOnBar-v0\n"
        "  vr-envs evaluate Autopilot-v1 --scene lecture --level all --json autopilot.json\n"
        "  vr-envs evaluate TerrainRide-v0 --policies do-nothing,random --scenarios 500\n"
        "  vr-envs evaluate BallOnBar-v0 --engine rigid_body --scenarios 20",
    )
    parser.add_argument("id", help="an environment id; prefix and version may be left out")
    add_scene(parser)
    add_engine(parser)
    parser.add_argument("--level", default="nominal", help="nominal (default), light, severe, or all")
    parser.add_argument("--policies", type=names, metavar="A,B", help="only these; default all")
    parser.add_argument("--scenarios", type=whole(2), default=200, metavar="N", help="default 200")
    parser.add_argument("--seed", type=whole(0), default=0, help="which held-out set; default 0")
    parser.add_argument("--json", metavar="FILE", help="also write a list of reports, one per level")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Print one table per level."""
    from vr_envs.controllers.ladder import ladder
    from vr_envs.envs.registry import task_of
    from vr_envs.envs.scene import resolve
    from vr_envs.evaluation.files import write_json
    from vr_envs.evaluation.report import choose, evaluate_ladder
    from vr_envs.evaluation.scenarios import scenario_set

    check_writable(arguments.json)
    with user_input():
        task = task_of(arguments.id)
        scene = resolve(task, scene_of(arguments.scene), arguments.engine).as_dict()
        levels = list(task.levels) if arguments.level == "all" else [arguments.level]
        sets = [scenario_set(arguments.id, scene, level, arguments.scenarios, arguments.seed) for level in levels]
        choose(ladder(task, sets[0].scene), arguments.policies)
    reports = []
    for level in levels:
        report = evaluate_ladder(
            arguments.id,
            scene,
            level,
            arguments.scenarios,
            arguments.seed,
            names=arguments.policies,
            progress=True,
        )
        print(("\n" if reports else "") + report.table(), flush=True)
        reports.append(report.as_dict())
    if arguments.json:
        with user_input():
            write_json(arguments.json, reports)
