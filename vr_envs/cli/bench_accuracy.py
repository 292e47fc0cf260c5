"""`vr-envs bench accuracy`."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vr_envs.bench.report import Report

SUMMARY = "accuracy"
EXAMPLES = "  vr-envs bench accuracy\n  vr-envs bench accuracy --quick --out /tmp/bench"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what only this benchmark knows."""


def measure(arguments: argparse.Namespace) -> Report:
    """Measure and report."""
    raise NotImplementedError
