"""`vr-envs bench speed`."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vr_envs.bench.report import Report

SUMMARY = "speed"
EXAMPLES = "  vr-envs bench speed\n  vr-envs bench speed --quick --out /tmp/bench"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what only this benchmark knows."""


def measure(arguments: argparse.Namespace) -> Report:
    """Measure and report."""
    raise NotImplementedError
