"""What the subcommands share: arguments, and errors that are the user's to mend."""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any


class UserError(Exception):
    """Told in one line, without a traceback; exit code 2."""


@contextmanager
def user_input() -> Iterator[None]:
    """Within it, a value or file that is refused is the user's error."""
    try:
        yield
    except (ValueError, OSError) as error:
        raise UserError(" ".join(str(error).split())) from error


@contextmanager
def extra(name: str) -> Iterator[None]:
    """Within it, what cannot be imported belongs to an extra of the package that the user has not installed."""
    try:
        yield
    except ImportError as error:
        raise UserError(f"{error}; this needs pip install '.[{name}]' in a clone of the project") from error


def add_command(commands: Any, name: str, summary: str, examples: str) -> argparse.ArgumentParser:
    """A subcommand whose help ends with examples."""
    return commands.add_parser(
        name,
        help=summary,
        description=summary,
        epilog=f"examples:\n{examples}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )


def add_scene(parser: argparse.ArgumentParser) -> None:
    """The argument --scene."""
    parser.add_argument(
        "--scene", metavar="NAME|JSON", help='a preset, or overrides such as \'{"base": "bell", "restitution": 0.8}\''
    )


def add_engine(parser: argparse.ArgumentParser) -> None:
    """The argument --engine."""
    parser.add_argument(
        "--engine", metavar="NAME", help="exact, or another engine of the system; default: the scene's, usually exact"
    )


def scene_of(text: str | None) -> str | Mapping[str, Any] | None:
    """A scene as it stands on the command line."""
    if text is None or not text.lstrip().startswith("{"):
        return text
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        raise UserError(f"--scene is not JSON: {error}; it reads {text}") from error


def whole(low: int) -> Any:
    """An argument type: a whole number of at least `low`."""

    def parse(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            value = low - 1
        if value < low:
            raise argparse.ArgumentTypeError(f"{text!r}; give a whole number of at least {low}")
        return value

    return parse


def positive(text: str) -> float:
    """An argument type: a finite number above zero."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text!r}; give a number above 0")
    return value


def names(text: str) -> list[str]:
    """An argument type: names separated by commas."""
    return [name for name in (part.strip() for part in text.split(",")) if name]


def check_writable(path: str | None) -> None:
    """Refuse, before long work, a file that could not be written after it."""
    if path is None:
        return
    target = Path(path)
    folder = target.parent
    if target.is_dir():
        raise UserError(f"{path} is a folder; give a file")
    if not folder.is_dir():
        raise UserError(f"cannot write {path}: there is no folder {folder}")
    if not os.access(folder, os.W_OK) or (target.exists() and not os.access(target, os.W_OK)):
        raise UserError(f"cannot write {path}: permission denied")
