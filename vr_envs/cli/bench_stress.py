"""`vr-envs bench stress`."""

from __future__ import annotations

import argparse
import time
from typing import TYPE_CHECKING

from vr_envs.cli.common import UserError, extra, names, user_input, whole

if TYPE_CHECKING:
    from vr_envs.bench.report import Report

SUMMARY = "try to break the environments: every regime, the ends of every range; exit code 1 if something did"
EXAMPLES = """  vr-envs bench stress
  vr-envs bench stress --quick --out /tmp/bench
  vr-envs bench stress --trial ball-grazing,ride-kerbs
  vr-envs bench stress --trial ball-grazing --seed 17"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what only this benchmark knows."""
    parser.add_argument("--trial", type=names, metavar="NAME,...", help="only these trials; default all")
    parser.add_argument("--seed", type=whole(0), metavar="N", help="only case N of one trial, such as one that failed")


def measure(arguments: argparse.Namespace) -> Report:
    """Measure and report."""
    if not hasattr(time, "CLOCK_THREAD_CPUTIME_ID"):
        raise UserError(
            "steps are timed with the clock of a thread's CPU time, which this system lacks; use a POSIX one"
        )
    with extra("bench"):
        from vr_envs.bench.stress.measure import QUICK, all_tried, report
        from vr_envs.bench.stress.trial import named
        from vr_envs.bench.stress.trials import TRIALS

    chosen = arguments.trial or list(TRIALS)
    with user_input():
        for name in chosen:
            named(TRIALS, name)
    if arguments.seed is not None and len(chosen) != 1:
        raise UserError(f"--seed {arguments.seed} is a case of one trial; name it with --trial")
    return report(all_tried(chosen, QUICK if arguments.quick else 1.0, arguments.seed, progress=True))
