"""`vr-envs tune`: gains of the analytic laws, by search on training-side scenarios."""

from __future__ import annotations

import argparse
from typing import Any

from vr_envs.cli.common import UserError, add_command, user_input, whole


def add(commands: Any) -> None:
    """Declare the arguments."""
    parser = add_command(
        commands,
        "tune",
        "search better gains for the analytic laws and the best constant action, and store them with the package",
        "  vr-envs tune BallOnBar-v0\n"
        "  vr-envs tune Autopilot-v1 --scene lecture --policy best-constant --evaluations 400",
    )
    parser.add_argument("id", help="an environment id; prefix and version may be left out")
    parser.add_argument("--scene", metavar="NAME", help="a preset; default: the environment's default scene")
    parser.add_argument("--policy", metavar="NAME", help="only this one; default: all that have gains")
    parser.add_argument(
        "--evaluations", type=whole(30), default=1000, metavar="N", help="rollouts per policy; default 1000"
    )
    parser.add_argument("--scenarios", type=whole(2), default=128, metavar="N", help="per rollout; default 128")
    parser.add_argument("--seed", type=whole(0), default=0, help="of the search and its scenarios; default 0")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Tune, store, and print what was found."""
    from vr_envs.cli.common import check_writable
    from vr_envs.controllers.ladder import tuned_file
    from vr_envs.envs.registry import task_of
    from vr_envs.evaluation.scenarios import scenario_set
    from vr_envs.evaluation.tuning import candidates, choose_tunable, tune

    policies = None if arguments.policy is None else [arguments.policy]
    with user_input():
        task = task_of(arguments.id)
        choose_tunable(candidates(task, scenario_set(arguments.id, arguments.scene).scene), policies)
    check_writable(str(tuned_file(task)))
    try:
        found = tune(
            arguments.id,
            arguments.scene,
            policies,
            arguments.evaluations,
            arguments.scenarios,
            arguments.seed,
            progress=True,
        )
    except ImportError as error:
        raise UserError(f"tuning needs cma: pip install '.[tune]' in a clone of the project ({error})") from error
    for policy, entry in found.items():
        gains = ", ".join(f"{name} {value:.4g}" for name, value in entry["gains"].items())
        print(f"{policy}: {entry['default_check_score']:.4f} -> {entry['check_score']:.4f} with {gains}")
    print(f"written to {tuned_file(task)}")
