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
    parser = add_command(commands, "bench", "measure the environments", "  vr-envs bench speed\n  vr-envs bench impact")
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
    speed.set_defaults(run=run_speed)
    impact = add_command(
        kinds,
        "impact",
        "CPU time per impact of the ball, what each option adds to it, and what an absent option costs",
        "  vr-envs bench impact --json impact.json",
    )
    impact.add_argument("--repeats", type=whole(1), default=9, metavar="N", help="timings of about 0.2 s; default 9")
    impact.add_argument("--json", metavar="FILE", help="also write the numbers")
    impact.set_defaults(run=run_impact)


def run_impact(arguments: argparse.Namespace) -> None:
    """Measure impacts, print and store."""
    from vr_envs.bench.impact import Cost, option_costs, pruning_costs, scene_costs
    from vr_envs.evaluation.files import write_json
    from vr_envs.evaluation.report import versions
    from vr_envs.evaluation.table import markdown

    check_writable(arguments.json)
    used = versions()
    print(
        f"CPU time (time.process_time) per impact, one core, {arguments.repeats} repeats: median (minimum to maximum); "
        f"{', '.join(f'{name} {used[name]}' for name in ('python', 'numpy', 'numba'))}"
    )
    measured: dict[str, list[Cost]] = {}
    for name, title, compared, costs in (
        ("scenes", "scene", "", scene_costs),
        ("options", "option added to a tilting bar", "time over that without", option_costs),
        ("pruning", "scene without options", "time over a kernel that never had any", pruning_costs),
    ):
        measured[name] = costs(arguments.repeats, progress=True)
        head = [title, "ns per impact", "impacts/cycle", *([compared] if compared else [])]
        body = []
        for cost in measured[name]:
            ns, ratio = cost.nanoseconds, cost.ratio
            row = [
                cost.name,
                f"{ns.median:.0f} ({ns.minimum:.0f} to {ns.maximum:.0f})",
                f"{cost.impacts_per_cycle:.2f}",
            ]
            if compared:
                row.append("-" if ratio is None else f"{ratio.median:.3f} ({ratio.minimum:.3f} to {ratio.maximum:.3f})")
            body.append(row)
        print(f"\n{markdown(head, body)}", flush=True)
    if arguments.json:
        numbers = {name: [dataclasses.asdict(cost) for cost in costs] for name, costs in measured.items()}
        with user_input():
            write_json(arguments.json, numbers | {"repeats": arguments.repeats, "versions": used})


def run_speed(arguments: argparse.Namespace) -> None:
    """Measure steps, print and store."""
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
