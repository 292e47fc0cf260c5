"""Packages that only pictures need, imported by name when they are used."""

from __future__ import annotations

from importlib import import_module
from typing import Any


def extra(module: str) -> Any:
    """Import `module`.

    Raises:
        ImportError: it is missing; the message says what to install.
    """
    try:
        return import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        raise ImportError(f"pictures need {package}: pip install '.[render]' in a clone of the project") from error
