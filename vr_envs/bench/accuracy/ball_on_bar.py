"""The ball on the bar: run time against error."""

from __future__ import annotations

from vr_envs.bench.accuracy.account import System


def system(quick: bool, progress: bool) -> System:
    """Carry out all runs."""
    raise NotImplementedError
