"""Roads for tests: their records and knots."""

import numpy as np

from vr_envs.models.record import dtype_of, pack
from vr_envs.models.road import RoadAlone, draw_road


def fresh(key):
    state = np.zeros(1, dtype_of(RoadAlone))[0]
    state["key"] = key
    return state


def packed(*options):
    return tuple(None if option is None else pack(option) for option in options)


def knots(key, count, road, profile=None, bumps=None, obstacle=None, wheel=None):
    """Heights of the first knots."""
    heights = np.empty(count)
    draw_road(fresh(key), heights, *packed(road, profile, bumps, obstacle, wheel))
    return heights
