"""All of `vr-envs bench accuracy`: the systems, and one report of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from vr_envs.bench.accuracy import account, autopilot, ball_on_bar, terrain_ride
from vr_envs.bench.accuracy.account import System
from vr_envs.bench.accuracy.picture import picture
from vr_envs.bench.report import Report

SYSTEMS: dict[str, Callable[[bool, bool], System]] = {
    "ball_on_bar": ball_on_bar.system,
    "autopilot": autopilot.system,
    "terrain_ride": terrain_ride.system,
}
"""Name -> function of (quick, progress) that carries out all runs of the system."""


def measure(names: Sequence[str] = (), quick: bool = False, progress: bool = True) -> Report:
    """Carry out the runs of the systems `names`, by default of all, and report them.

    Raises:
        ValueError: there is no such system.
    """
    for name in names:
        if name not in SYSTEMS:
            raise ValueError(f"there is no system {name!r}; choose among {', '.join(SYSTEMS)}")
    report = Report("accuracy", "Run time against error")
    for name in dict.fromkeys(names or SYSTEMS):
        system = SYSTEMS[name](quick, progress)
        report.sentences += account.sentences(system)
        report.tables += [account.target_table(system), account.points_table(system)]
        report.numbers[name] = account.numbers(system)
        report.figures[name] = picture(system)
    return report
