"""A flight plan: demanded altitude, airspeed and heading at given times, from a scene or a CSV file."""

from __future__ import annotations

import dataclasses

from vr_envs.models.record import quantity

WAYPOINTS = 64


@dataclasses.dataclass(frozen=True)
class Plan:
    """Option, in place of random demands: those of a flight plan, which change at given times.

    The flight starts on the first waypoint, whose time is 0.
    """

    time: tuple[float, ...] = quantity(
        (0.0,), "s", "when the demands of each waypoint begin", low=0.0, high=1e6, shape=(WAYPOINTS,)
    )
    altitude: tuple[float, ...] = quantity((3000.0,), "m", "demanded altitude", low=0.0, high=2e4, shape=(WAYPOINTS,))
    airspeed: tuple[float, ...] = quantity(
        (120.0,), "m/s", "demanded airspeed", low=0.0, high=600.0, shape=(WAYPOINTS,)
    )
    heading: tuple[float, ...] = quantity((0.0,), "rad", "demanded heading", low=-7.0, high=7.0, shape=(WAYPOINTS,))
