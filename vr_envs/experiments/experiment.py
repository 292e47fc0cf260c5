"""What an experiment is and what it hands back. The list of all experiments is `catalogue.py`."""

from __future__ import annotations

import dataclasses
import importlib
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Progress(Protocol):
    """Wraps a loop to show how far it is, as `tqdm.tqdm` does."""

    def __call__(self, items: Iterable[Any], *, desc: str) -> Iterable[Any]:
        """The items, with a progress bar named `desc`."""
        ...


@dataclasses.dataclass(frozen=True)
class Finding:
    """One line of "expected against found"; `agrees` says whether the two agree within what `expected` says."""

    what: str
    expected: str
    found: str
    agrees: bool


@dataclasses.dataclass(frozen=True)
class Outcome:
    """What an experiment found.

    `findings`: what was expected and what came out. `tables`: name -> column name with unit -> values of equal
    length; each is written as a CSV. `draw`: draws the picture that stands beside the source's figure.
    """

    findings: tuple[Finding, ...]
    tables: Mapping[str, Mapping[str, np.ndarray]]
    draw: Callable[[Figure], None]


@dataclasses.dataclass(frozen=True)
class Experiment:
    """An experiment by name: `figure` of the source document, and "module:function" that runs it, imported late."""

    name: str
    figure: str
    title: str
    function: str

    def run(self, progress: Progress) -> Outcome:
        """Run it; nothing is written."""
        module, function = self.function.split(":")
        return getattr(importlib.import_module(f"vr_envs.experiments.{module}"), function)(progress)
