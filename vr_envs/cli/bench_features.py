"""`vr-envs bench features`."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from vr_envs.cli.common import user_input

if TYPE_CHECKING:
    from vr_envs.bench.report import Report

SUMMARY = "what each option of a scene costs when it is on and when it is off, and what else is skipped; start-up"
EXAMPLES = (
    "  vr-envs bench features\n"
    "  vr-envs bench features --quick --out /tmp/bench\n"
    "  vr-envs bench features --id BallOnBar --id Autopilot"
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what only this benchmark knows."""
    parser.add_argument("--id", action="append", metavar="ID", help="may be given again; default: every id")


def measure(arguments: argparse.Namespace) -> Report:
    """Measure and report."""
    from vr_envs.bench.features.measure import QUICK, Effort, report
    from vr_envs.envs.registry import ids, task_of

    chosen = arguments.id or ids()
    with user_input():
        for env_id in chosen:
            task_of(env_id)
    return report(chosen, QUICK if arguments.quick else Effort(), progress=True)
