"""`vr-envs bench`: measurements of the environments themselves."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vr_envs.cli import bench_accuracy, bench_features, bench_speed, bench_stress
from vr_envs.cli.common import UserError, add_command, user_input

if TYPE_CHECKING:
    from vr_envs.bench.report import Report

KINDS = {"accuracy": bench_accuracy, "speed": bench_speed, "stress": bench_stress, "features": bench_features}
"""Name -> module with `SUMMARY`, `EXAMPLES`, `add_arguments(parser)` and `measure(arguments) -> Report`."""


def add(commands: Any) -> None:
    """Declare the arguments."""
    examples = "\n".join(f"  vr-envs bench {name}" for name in KINDS)
    parser = add_command(commands, "bench", "measure run time, error, stability and the cost of features", examples)
    kinds = parser.add_subparsers(metavar="WHAT", required=True)
    for name, module in KINDS.items():
        kind = add_command(kinds, name, module.SUMMARY, module.EXAMPLES)
        kind.add_argument(
            "--out", default="runs/bench", metavar="FOLDER", help="for JSON, Markdown and PNG; default runs/bench"
        )
        kind.add_argument("--quick", action="store_true", help="a look: a fraction of the work, wider spreads")
        module.add_arguments(kind)
        kind.set_defaults(run=_runner(module.measure))


def _runner(measure: Callable[[argparse.Namespace], Report]) -> Callable[[argparse.Namespace], None]:
    def run(arguments: argparse.Namespace) -> None:
        folder = Path(arguments.out)
        if folder.exists() and not folder.is_dir():
            raise UserError(f"--out {folder} is a file; give a folder")
        with user_input():
            folder.mkdir(parents=True, exist_ok=True)  # before long work, not after it
        report = measure(arguments)
        print(report.text(detail=False))
        with user_input():
            for path in report.write(folder):
                print(f"wrote {path}")
        if report.failed:
            raise SystemExit(1)

    return run
