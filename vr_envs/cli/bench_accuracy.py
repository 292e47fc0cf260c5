"""`vr-envs bench accuracy`."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from vr_envs.cli.common import extra

if TYPE_CHECKING:
    from vr_envs.bench.report import Report

SUMMARY = "run time against error of every engine and of what one would use instead"
EXAMPLES = """\
  vr-envs bench accuracy
  vr-envs bench accuracy --quick --out /tmp/bench
  vr-envs bench accuracy --system ball_on_bar"""
SYSTEMS = ("ball_on_bar", "autopilot", "terrain_ride")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what only this benchmark knows."""
    parser.add_argument(
        "--system", action="append", default=[], choices=SYSTEMS, help="one system alone; may be repeated; default all"
    )


def measure(arguments: argparse.Namespace) -> Report:
    """Measure and report."""
    with extra("bench"):
        from vr_envs.bench.accuracy.measure import measure as measured
    return measured(arguments.system, arguments.quick)
