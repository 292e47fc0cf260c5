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
        raise ImportError(f'pictures need {module.partition(".")[0]}: pip install "vr_envs[render]"') from error
