"""`vr-envs bench speed`."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from vr_envs.cli.common import names, user_input, whole

if TYPE_CHECKING:
    from vr_envs.bench.report import Report

SUMMARY = "steps per second: one environment, batches, threads, NumPy, JAX, training"
EXAMPLES = "  vr-envs bench speed\n  vr-envs bench speed --quick --id TerrainRide --rows 64,1024 --out /tmp/bench"
ROWS = [1, 64, 1024, 4096]


def _counts(text: str) -> list[int]:
    return sorted({whole(1)(part) for part in names(text)}) or ROWS


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what only this benchmark knows."""
    parser.add_argument("--id", action="append", metavar="ID", help="environment (may be repeated; default: all)")
    parser.add_argument("--rows", type=_counts, default=ROWS, metavar="N,...", help="rows; default 1,64,1024,4096")
    parser.add_argument("--repeats", type=whole(1), metavar="N", help="timings of everything; default 5, quick 3")


def measure(arguments: argparse.Namespace) -> Report:
    """Measure and report."""
    from vr_envs.bench.speed import training
    from vr_envs.bench.speed.account import account
    from vr_envs.bench.speed.contestants import cases_of
    from vr_envs.bench.speed.goals import goals
    from vr_envs.bench.speed.measure import JAX_LEFT_OUT, JAX_MISSING, has_jax
    from vr_envs.bench.speed.measure import measure as measured_of
    from vr_envs.bench.speed.picture import picture

    quick = arguments.quick
    with user_input():
        cases = cases_of(arguments.id)
    repeats = arguments.repeats or (3 if quick else 5)
    jax = has_jax() and not quick
    measured = measured_of(cases, arguments.rows, repeats, 0.02 if quick else 0.06, jax, progress=True)
    ids = list(dict.fromkeys(case.env_id for case in cases))
    left_out = [] if jax else [JAX_LEFT_OUT if quick else JAX_MISSING]
    trainings = []
    if (reason := training.missing()) is None:
        trainings = training.trainings(ids[:1] if quick else ids, 4096 if quick else 16_384)
    else:
        left_out.append(reason)
    found = goals(cases, measured)
    report = account(cases, arguments.rows, measured, found, trainings, left_out)
    report.figures["rows"] = picture(cases, measured)
    return report
