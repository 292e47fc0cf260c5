"""`vr-envs bench`: measurements of the environments themselves."""

from __future__ import annotations

import argparse
import dataclasses
from typing import Any

from vr_envs.cli.common import add_command, check_writable, names, user_input, whole


def _counts(text: str) -> list[int]:
    return [whole(1)(part) for part in names(text)]


def add(commands: Any) -> None:
    """Declare the arguments."""
    parser = add_command(commands, "bench", "measure the environments", "  vr-envs bench speed")
    kinds = parser.add_subparsers(metavar="WHAT", required=True)
    speed = add_command(
        kinds,
        "speed",
        "environment steps per CPU second of one core, by number of rows",
        "  vr-envs bench speed\n  vr-envs bench speed --id BallOnBar-v0 --rows 1,4096 --json speed.json",
    )
    speed.add_argument("--id", action="append", metavar="ID", help="may be given again; default: every id")
    speed.add_argument("--rows", type=_counts, default=[1, 64, 1024], metavar="N,N", help="default 1,64,1024")
    speed.add_argument("--repeats", type=whole(1), default=5, metavar="N", help="timings of about 0.5 s; default 5")
    speed.add_argument("--json", metavar="FILE", help="also write the numbers")
    speed.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Measure, print and store."""
    from vr_envs.bench.speed import compare
    from vr_envs.envs.registry import ids, task_of
    from vr_envs.evaluation.files import write_json
    from vr_envs.evaluation.report import versions
    from vr_envs.evaluation.table import markdown

    check_writable(arguments.json)
    chosen = arguments.id or ids()
    with user_input():
        for env_id in chosen:
            task_of(env_id)
    speeds = compare(chosen, arguments.rows, arguments.repeats, progress=True)
    used = versions()
    body = [
        [
            s.env_id,
            s.actions,
            str(s.rows),
            *(f"{rate:,.0f}" for rate in (s.minimum, s.median, s.maximum)),
            "-" if s.impacts_per_step is None else f"{s.impacts_per_step:.2f}",
        ]
        for s in speeds
    ]
    print(
        f"Environment steps per CPU second (time.process_time), one core, {arguments.repeats} repeats; "
        f"{', '.join(f'{name} {used[name]}' for name in ('python', 'numpy', 'numba'))}\n"
    )
    print(markdown(["id", "actions", "rows", "minimum", "median", "maximum", "impacts/step"], body, left=(0, 1)))
    if arguments.json:
        with user_input():
            write_json(arguments.json, {"speeds": [dataclasses.asdict(s) for s in speeds], "versions": used})
