"""The command line `vr-envs`; `python -m vr_envs` is the same."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

import vr_envs
from vr_envs.cli import bench, evaluate, experiment, listing, render, tune
from vr_envs.cli.common import UserError


def parser() -> argparse.ArgumentParser:
    """All arguments of all subcommands."""
    top = argparse.ArgumentParser(prog="vr-envs", description=vr_envs.__doc__)
    top.add_argument("--version", action="version", version=vr_envs.__version__)
    commands = top.add_subparsers(metavar="COMMAND", dest="command", required=True)
    for command in (listing, evaluate, render, tune, bench, experiment):
        command.add(commands)
    return top


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code: 0, 2 for an error of the user, 130 when interrupted."""
    arguments = parser().parse_args(argv)
    try:
        arguments.run(arguments)
    except UserError as error:
        print(f"vr-envs {arguments.command}: error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
