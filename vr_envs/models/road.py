"""Road under a wheel, piecewise linear by definition: roughness of an ISO 8608 class, and what lies on it.

Heights are in m, up; distances along the road in m, ahead. The road is the polygon of its knots, and a knot depends on
the episode's key and its own number alone. The kernels read and write the fields of `RoadState` and read the `key`.

Roughness: below the cut-off n_c of `road_density` the road is white noise through a first-order filter,

    dr/dx + 2 pi n_c r = sqrt(2) pi n0 sqrt(Gd(n0)) xi(x),    E[xi(x) xi(x')] = delta(x - x'),

whose samples at equally spaced knots are exactly  r' = phi r + sd sqrt(1 - phi^2) N(0, 1). (Where a source has
2 pi n0 sqrt(Gd(n0)) there, its noise has a one-sided density of 1; with E[xi xi'] = delta that road has twice the
density.)

With a wheel of finite radius the knots are those of its centre's path. The road behind the first knot, on which such a
wheel rests too, is level.
"""

from __future__ import annotations

import dataclasses
import math

from vr_envs.models.jit import kernel
from vr_envs.models.lane_records import lane, lane_count
from vr_envs.models.lanes import any_lane, to_float, to_int, where
from vr_envs.models.noise import normal_pair, uniform
from vr_envs.models.record import quantity
from vr_envs.models.road_features import bump_height, obstacle_height, profile_height
from vr_envs.models.road_options import RAW, REFERENCE_NUMBER, RING
from vr_envs.models.wheel_envelope import centre_height, wheel_reach

# Counters of an episode's key, one range for each use; the pairs of knots use those below _DENSITY. See the phases of
# an undulation and the bumps for the others.
_DENSITY, _START = 1 << 40, 1 << 43


@dataclasses.dataclass(frozen=True)
class RoadState:
    """Fields of a state record that has a road."""

    knot: int = quantity(0, "", "road knot behind the wheel", low=0)
    to_knot: float = quantity(0.0, "m", "distance to the next knot", low=0.0, high=10.0)
    roughness: float = quantity(0.0, "m", "roughness of the last knot drawn")
    roughness_sd: float = quantity(0.0, "m", "its standard deviation in this episode")
    knots: float = quantity(0.0, "m", "ring of road knots", shape=(RING,))
    raw: float = quantity(0.0, "m", "ring of knots of the bare profile, with a wheel of finite radius", shape=(RAW,))


@dataclasses.dataclass(frozen=True)
class RoadAlone(RoadState):
    """A record of a road without a vehicle."""

    key: int = quantity(0, "", "episode key", kind="key")


@kernel
def roughness_deviation(density, cutoff):
    """Standard deviation [m] of the roughness with the density Gd(n0) [m^3] and the cut-off [cycle/m]."""
    return REFERENCE_NUMBER * math.sqrt(0.5 * math.pi * density / cutoff)


@kernel
def _put_knot(state, due, k, normal, road, profile, bumps, obstacle, wheel):
    """Draw knot k of the profile from a standard normal number, in the records that `due` holds for."""
    before = state.roughness
    height = road.memory * before + road.innovation * state.roughness_sd * normal
    state.roughness = where(due, height, before)
    distance = to_float(k) * road.knot_spacing
    if profile is not None:
        height += profile_height(distance, profile)
    if bumps is not None:
        height += bump_height(state.key, distance, bumps)
    if obstacle is not None:
        height += obstacle_height(distance, obstacle)
    for i in range(lane_count(state)):
        if lane(due, i):
            record, number = lane(state, i), lane(k, i)
            if wheel is None:
                record.knots[number & (RING - 1)] = lane(height, i)
            else:
                record.raw[number & (RAW - 1)] = lane(height, i)


@kernel
def _draw_pair(state, due, pair, road, profile, bumps, obstacle, wheel):
    """Draw the knots 2 pair and 2 pair + 1 of the profile, in the records that `due` holds for.

    A wheel of finite radius, which is for plain records alone, follows as far as it can.
    """
    first, second = normal_pair(state.key, pair)
    _put_knot(state, due, 2 * pair, first, road, profile, bumps, obstacle, wheel)
    _put_knot(state, due, 2 * pair + 1, second, road, profile, bumps, obstacle, wheel)
    if wheel is not None:
        reach = wheel_reach(road, wheel)
        if 2 * pair >= reach:
            for k in range(2 * pair - reach, 2 * pair - reach + 2):
                state.knots[k & (RING - 1)] = centre_height(state.raw, k, reach, road.knot_spacing, wheel.radius)


@kernel
def start_road(state, road, profile, bumps, obstacle, wheel):
    """Draw the roughness of the episode and fill the ring; the wheel stands on knot 0."""
    density = road.density * 2.0 ** (road.spread * (2.0 * uniform(state.key, _DENSITY) - 1.0))
    state.roughness_sd = roughness_deviation(density, road.cutoff)
    state.roughness = state.roughness_sd * normal_pair(state.key, _START // 2)[0]
    state.knot = 0
    state.to_knot = road.knot_spacing
    _draw_pair(state, True, 0, road, profile, bumps, obstacle, wheel)
    ahead = RING
    if wheel is not None:
        reach = wheel_reach(road, wheel)
        for k in range(RAW - reach, RAW):
            state.raw[k] = state.raw[0]
        ahead += reach
    for pair in range(1, ahead // 2):
        _draw_pair(state, True, pair, road, profile, bumps, obstacle, wheel)


@kernel
def slope_of_road(state, road):
    """Slope (height over distance) of the segment on which the wheel is."""
    k = state.knot
    rise = state.knots[(k + 1) & (RING - 1)] - state.knots[k & (RING - 1)]
    return rise * (1.0 / road.knot_spacing)


@kernel
def pass_knot(state, passes, road, profile, bumps, obstacle, wheel):
    """Where `passes` holds the wheel has come to the next knot; every second time the slots behind it get new knots."""
    knot = state.knot + to_int(passes)
    state.knot = knot
    state.to_knot = where(passes, road.knot_spacing, state.to_knot)
    due = passes & ((knot & 1) == 0)
    if any_lane(due):
        newest = knot + (RING - 2)
        if wheel is not None:
            newest += wheel_reach(road, wheel)
        _draw_pair(state, due, newest >> 1, road, profile, bumps, obstacle, wheel)


@kernel
def place_on_road(state, road):
    """Where the wheel is, in knot spacings from the knot behind it."""
    return 1.0 - state.to_knot / road.knot_spacing


@kernel
def road_height(state, place):
    """Height of the road `place` >= 0 knot spacings from the knot behind the wheel, at most RING - 3."""
    whole = to_int(place)
    k = state.knot + whole
    left, right = state.knots[k & (RING - 1)], state.knots[(k + 1) & (RING - 1)]
    return left + (right - left) * (place - to_float(whole))


@kernel
def draw_road(state, heights, road, profile, bumps, obstacle, wheel):
    """Start the road of the key in `state` and write the heights (n,) of its first n knots, n >= 1."""
    start_road(state, road, profile, bumps, obstacle, wheel)
    heights[0] = state.knots[0]
    for k in range(1, heights.shape[0]):
        pass_knot(state, True, road, profile, bumps, obstacle, wheel)
        heights[k] = state.knots[k & (RING - 1)]
