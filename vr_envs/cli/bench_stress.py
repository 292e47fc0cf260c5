"""`vr-envs bench stress`."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vr_envs.bench.report import Report

SUMMARY = "stress"
EXAMPLES = "  vr-envs bench stress\n  vr-envs bench stress --quick --out /tmp/bench"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what only this benchmark knows."""


def measure(arguments: argparse.Namespace) -> Report:
    """Measure and report."""
    raise NotImplementedError
