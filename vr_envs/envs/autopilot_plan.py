"""A flight plan: demanded altitude, airspeed and heading at given times, from a scene or a CSV file."""

from __future__ import annotations

import csv
import dataclasses
import math
from typing import Any, ClassVar

from vr_envs.envs.autopilot_demands import NEVER, demands_at
from vr_envs.models.autopilot import wrap
from vr_envs.models.clock import SAME
from vr_envs.models.jit import kernel
from vr_envs.models.record import quantity

WAYPOINTS = 64
COLUMNS = ("time_s", "altitude_m", "airspeed_m_s", "heading_deg")


@dataclasses.dataclass(frozen=True)
class Plan:
    """Option, in place of random demands: those of a flight plan, which change at given times.

    The flight starts in level flight on the first waypoint, whose time is 0. Airspeeds are as measured: equivalent ones
    with the option `atmosphere`. The scene takes the path of a CSV file in its place.
    """

    time: tuple[float, ...] = quantity(
        (0.0,), "s", "when the demands of each waypoint begin", low=0.0, high=1e6, shape=(WAYPOINTS,)
    )
    altitude: tuple[float, ...] = quantity((3000.0,), "m", "demanded altitude", low=0.0, high=2e4, shape=(WAYPOINTS,))
    airspeed: tuple[float, ...] = quantity(
        (120.0,), "m/s", "demanded airspeed", low=0.0, high=600.0, shape=(WAYPOINTS,)
    )
    heading: tuple[float, ...] = quantity((0.0,), "rad", "demanded heading", low=-7.0, high=7.0, shape=(WAYPOINTS,))
    ramp: bool = quantity(
        False, "", "demands go straight from waypoint to waypoint, the heading the short way, instead of stepping"
    )

    DERIVED: ClassVar[tuple[str, ...]] = ("count",)

    @property
    def count(self) -> float:
        """Number of waypoints."""
        return float(len(self.time))

    @staticmethod
    def read(path: str) -> dict[str, Any]:
        """The fields of a plan from a CSV file with a header row.

        The columns time_s, altitude_m, airspeed_m_s and heading_deg are found by name, others are left alone.

        Raises:
            ValueError: the file cannot be read, a column is missing, or a line has no number where one should be; it
                names the file, the line and the column.
        """
        try:
            with open(path, newline="", encoding="utf-8-sig") as file:
                reader = csv.reader(file)
                rows = [(reader.line_num, row) for row in reader if any(cell.strip() for cell in row)]
        except (OSError, UnicodeDecodeError, csv.Error) as error:
            raise ValueError(f"flight plan {path!r} cannot be read: {error}; give the path of a CSV file") from error
        header = [name.strip() for name in rows[0][1]] if rows else []
        for name in COLUMNS:
            if header.count(name) != 1:
                raise ValueError(
                    f"flight plan {path!r} has {header.count(name)} columns {name!r} in its first line; "
                    f"give a header with each of {', '.join(COLUMNS)} once"
                )
        columns = [[_number(path, line, header, row, name) for line, row in rows[1:]] for name in COLUMNS]
        if not columns[0]:
            raise ValueError(f"flight plan {path!r} has no waypoint; give at least one line below the header")
        headings = tuple(float(wrap(math.radians(degrees))) for degrees in columns[3])
        return {
            "time": tuple(columns[0]), "altitude": tuple(columns[1]), "airspeed": tuple(columns[2]), "heading": headings
        }  # fmt: skip


def _number(path: str, line: int, header: list[str], row: list[str], name: str) -> float:
    """The finite number of a line in the column `name`."""
    place = header.index(name)
    text = row[place].strip() if place < len(row) else ""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"flight plan {path!r}, line {line}: {name} = {text!r} is not a finite number; give one")
    return value


def check_plan(plan: Plan) -> None:
    """One value of each kind per waypoint; times from 0 on, strictly increasing.

    Raises:
        ValueError: otherwise.
    """
    for name in ("altitude", "airspeed", "heading"):
        if len(getattr(plan, name)) != len(plan.time):
            raise ValueError(
                f"plan.{name} has {len(getattr(plan, name))} numbers for {len(plan.time)} times; give as many"
            )
    if plan.time[0] != 0.0:
        raise ValueError(f"plan.time[0] = {plan.time[0]:g} is not allowed; the first waypoint must be at 0 s")
    for i in range(1, len(plan.time)):
        if plan.time[i] <= plan.time[i - 1]:
            raise ValueError(
                f"plan.time[{i}] = {plan.time[i]:g} is not allowed; it must be above plan.time[{i - 1}] = "
                f"{plan.time[i - 1]:g}"
            )


@kernel
def fly_leg(state, params, plan):  # type: ignore[no-untyped-def]
    """Take the demands of the waypoint `state.changes`, and of the way to the next one where the plan ramps.

    Waypoints whose time is over before the present control instant are passed over.
    """
    last = int(plan.count) - 1
    here = min(state.changes, last)
    time = state.steps * params.dt
    while here < last and plan.time[here + 1] < time + SAME:
        here += 1
    ahead = min(here + 1, last)
    state.changes = here + 1
    state.next_change = NEVER if here == last else plan.time[ahead]
    per_leg = 0.0
    if plan.ramp and here < last:
        per_leg = 1.0 / (plan.time[ahead] - plan.time[here])
    starts = (plan.altitude[here], plan.airspeed[here], plan.heading[here])
    changes = (
        plan.altitude[ahead] - plan.altitude[here],
        plan.airspeed[ahead] - plan.airspeed[here],
        wrap(plan.heading[ahead] - plan.heading[here]),
    )
    for channel in range(3):
        state.demand[channel] = starts[channel]
        state.demand_rate[channel] = changes[channel] * per_leg
        state.demand_target[channel] = starts[channel] + (changes[channel] if plan.ramp else 0.0)
    demands_at(state, time)
