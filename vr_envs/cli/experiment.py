"""`vr-envs experiment`: the figures and tables of the source documents, run again."""

from __future__ import annotations

import argparse
import difflib
import os
import sys
from pathlib import Path
from typing import Any

from vr_envs.cli.common import UserError, add_command, whole


def add(commands: Any) -> None:
    """Declare the arguments."""
    parser = add_command(
        commands,
        "experiment",
        "run the figures and tables of the source documents again: picture, CSV, and expected against found",
        "  vr-envs experiment --list\n"
        "  vr-envs experiment period-one\n"
        "  vr-envs experiment --all --jobs 2 --out runs/experiments",
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help="one or more of those that --list shows")
    parser.add_argument("--all", action="store_true", help="all of them")
    parser.add_argument("--list", action="store_true", help="list them and run none")
    parser.add_argument(
        "--out",
        default="runs/experiments",
        metavar="FOLDER",
        help="for NAME.png, NAME.json and NAME-*.csv; default runs/experiments",
    )
    parser.add_argument("--jobs", type=whole(1), default=1, metavar="N", help="processes at a time; default 1")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Run, write and print."""
    from vr_envs.experiments.catalogue import EXPERIMENTS

    if arguments.list:
        print(overview())
        return
    for name in arguments.names:
        if name not in EXPERIMENTS:
            close = difflib.get_close_matches(name, EXPERIMENTS, n=1)
            hint = f"did you mean {close[0]!r}? " if close else ""
            raise UserError(f"there is no experiment {name!r}; {hint}choose among {', '.join(EXPERIMENTS)}")
    if bool(arguments.names) == arguments.all:
        raise UserError("give names of experiments (see --list), or --all")
    names = list(EXPERIMENTS) if arguments.all else list(dict.fromkeys(arguments.names))
    folder = Path(arguments.out)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(f"cannot make the folder {folder}: {error.strerror}; give another one with --out") from error
    if not os.access(folder, os.W_OK):
        raise UserError(f"cannot write to {folder}: permission denied; give another folder with --out")
    from tqdm import tqdm

    from vr_envs.experiments.runner import run_all, summary
    from vr_envs.render.extras import extra

    try:
        extra("matplotlib.figure")
    except ImportError as error:
        raise UserError(str(error)) from error
    agreed, total = 0, 0
    for name, findings in run_all(names, folder, arguments.jobs):
        tqdm.write(summary(name, findings) + "\n")  # between the progress bars
        sys.stdout.flush()
        agreed += sum(finding.agrees for finding in findings)
        total += len(findings)
    print(f"{agreed} of {total} findings agree; pictures and tables in {folder}")


def overview() -> str:
    """One line per experiment."""
    from vr_envs.evaluation.table import markdown
    from vr_envs.experiments.catalogue import EXPERIMENTS

    body = [[e.name, e.figure, e.title] for e in EXPERIMENTS.values()]
    return markdown(["name", "source", "what"], body, left=range(3))
