"""The command line: `python -m agents train | evaluate | speed`."""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
from pathlib import Path
from typing import Any

from agents.config import Config, load, parse
from vr_envs.cli.common import add_engine, whole


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m agents", description="Train and judge learning agents.")
    commands = parser.add_subparsers(dest="command", required=True)

    train = commands.add_parser(
        "train",
        help="train an agent as a configuration says, then judge it",
        description="Train an agent; leave a run folder with policy, learning curve, results and a picture.",
    )
    train.add_argument("config", type=Path, help="YAML file, such as configs/ball_on_bar/ppo.yaml")
    train.add_argument("--scene", help="preset's name, or overrides as JSON; in place of the file's")
    train.add_argument("--seed", type=int, help="in place of the file's")
    train.add_argument("--timesteps", type=int, help="in place of the file's")
    train.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="any other key of the file")
    train.add_argument("--out", type=Path, help="run folder to make (default: one under runs/ that names the run)")
    train.add_argument("--no-evaluate", action="store_true", help="leave out results and picture")

    evaluate = commands.add_parser(
        "evaluate",
        help="judge a trained agent beside the other policies",
        description="Run a trained agent and the other policies on the same held-out scenarios; print a table.",
    )
    evaluate.add_argument("run", type=Path, metavar="RUN_DIR", help="folder that train made")
    evaluate.add_argument("--level", default="nominal", help="strength of the disturbances (default: %(default)s)")
    add_engine(evaluate)
    evaluate.add_argument("--json", type=Path, help="write the results to this file too")

    speed = commands.add_parser(
        "speed",
        help="where the time of a training goes, as JSON",
        description="Train briefly on scalar environments and on native batches; print the CPU seconds as JSON.",
    )
    speed.add_argument("env", nargs="+", metavar="ID", help="environments, each in its default scene")
    speed.add_argument(
        "--timesteps", type=whole(1), default=20_000, help="of each training, in whole rollouts (default: %(default)s)"
    )

    for command in (train, evaluate):
        command.add_argument(
            "--scenarios", type=whole(2), default=200, metavar="N", help="held-out scenarios (default: %(default)s)"
        )
        command.add_argument("--quiet", action="store_true", help="no progress bars")
    return parser


def _overrides(arguments: argparse.Namespace) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for item in arguments.set:
        key, equals, text = item.partition("=")
        if not equals:
            raise ValueError(f"--set {item}: give KEY=VALUE")
        values[key] = parse(text, f"--set {key}")
    for key in ("seed", "timesteps"):
        if getattr(arguments, key) is not None:
            values[key] = getattr(arguments, key)
    if arguments.scene is not None:
        values["scene"] = parse(arguments.scene, "--scene")
    return values


def _train(config: Config, arguments: argparse.Namespace) -> int:
    from agents.episode import film
    from agents.train import PICTURE, RESULTS, TABLE, draw_curve, evaluate, load_run, train
    from vr_envs.evaluation.files import write_bytes

    show = not arguments.quiet
    print(f"{config.env}: preparing (kernels are compiled on the first run)", flush=True)
    folder, learned = train(config, arguments.out, show)
    speed = learned.timesteps / learned.elapsed_s
    print(
        f"trained {learned.timesteps} steps (whole rollouts) in {learned.elapsed_s:.1f} s, {speed:.0f} steps/s",
        flush=True,
    )
    baseline = None
    if not arguments.no_evaluate and not learned.interrupted:
        report = evaluate(folder, scenarios=arguments.scenarios, show=show)
        report.to_json(str(folder / RESULTS))
        write_bytes(folder / TABLE, (report.table() + "\n").encode())
        print(f"\n{report.table()}\n", flush=True)
        baseline = next((r.policy, r.score.value) for r in report.rows if r.policy == report.baseline)
        run_config, policy = load_run(folder)
        film(run_config, policy, folder / PICTURE, show)
    draw_curve(folder, config, baseline)
    print(f"Written to {folder}/:")
    for path in sorted(folder.iterdir()):
        print(f"  {path.name}")
    return 130 if learned.interrupted else 0


def _evaluate(arguments: argparse.Namespace) -> int:
    from agents.train import evaluate

    report = evaluate(
        arguments.run, arguments.level, arguments.scenarios, show=not arguments.quiet, engine=arguments.engine
    )
    print(report.table())
    if arguments.json is not None:
        report.to_json(str(arguments.json))
    return 0


def _speed(arguments: argparse.Namespace) -> int:
    from agents.speed import compare

    found = [training for env in arguments.env for training in compare(env, arguments.timesteps)]
    print(json.dumps([dataclasses.asdict(training) for training in found], indent=1))
    return 0


def main(arguments: list[str] | None = None) -> int:
    """Run a command; returns the exit status. An error of the user's is one line on stderr and status 2."""
    given = _parser().parse_args(arguments)
    try:
        if given.command == "train":
            return _train(load(given.config, _overrides(given)), given)
        return _speed(given) if given.command == "speed" else _evaluate(given)
    except (ValueError, OSError) as error:
        print(f"python -m agents {given.command}: error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print(f"python -m agents {given.command}: interrupted", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
