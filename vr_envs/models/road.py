"""Road under a wheel, piecewise linear by definition: ISO 8608 roughness, a measured profile, bumps and obstacles.

Heights are in m, up; distances along the road in m, ahead. The kernels read and write the fields of `RoadState` and
read the `key` of the episode.

ISO 8608: the one-sided displacement density is Gd(n) = Gd(n0) (n/n0)^-2 with n0 = 0.1 cycle/m; class A has the
geometric mean Gd(n0) = 16e-6 m^3 and each further class four times that. Below the cut-off n_c the density is flat:
the road is white noise through a first-order filter,  dr/dx + 2 pi n_c r = sqrt(2) pi n0 sqrt(Gd(n0)) xi(x),  whose
samples at equally spaced knots are exactly  r' = phi r + sd sqrt(1 - phi^2) N(0, 1).
"""

from __future__ import annotations

import dataclasses
import math

from vr_envs.models.jit import kernel
from vr_envs.models.noise import normal_pair, uniform
from vr_envs.models.record import quantity

RING = 64  # knots kept, a power of two; at least the next RING - 3 are ahead of the wheel

RAW = 64  # knots of the bare profile kept for a wheel of finite radius, a power of two

# Counters of an episode's key, one range for each use; the pairs of knots use those below _DENSITY.
_DENSITY, _BUMP, _START = 1 << 40, 1 << 42, 1 << 43


@dataclasses.dataclass(frozen=True)
class RoadState:
    """Fields of a state record that has a road."""

    knot: int = quantity(0, "", "road knot behind the wheel", low=0)
    to_knot: float = quantity(0.0, "m", "distance to the next knot", low=0.0, high=10.0)
    roughness: float = quantity(0.0, "m", "roughness of the last knot drawn")
    roughness_sd: float = quantity(0.0, "m", "its standard deviation in this episode")
    knots: float = quantity(0.0, "m", "ring of road knots", shape=(RING,))
    raw: float = quantity(0.0, "m", "ring of knots of the bare profile, with a wheel of finite radius", shape=(RAW,))


@kernel
def bump_height(key, distance, bumps):
    """Height of the bump or dip at `distance` from the start of the road."""
    place = math.floor(distance / bumps.stretch)
    counter = _BUMP + 3 * int(place)
    # the whole bump lies within its stretch
    free = bumps.stretch - 2.0 * bumps.longest
    away = abs(distance - place * bumps.stretch - bumps.longest - free * uniform(key, counter))
    if away >= bumps.longest:
        return 0.0
    half = bumps.shortest + (bumps.longest - bumps.shortest) * uniform(key, counter + 1)
    side = 2.0 * uniform(key, counter + 2) - 1.0
    height = bumps.low + (bumps.high - bumps.low) * abs(side)
    return math.copysign(height, side) * max(0.0, 1.0 - away / half)


@kernel
def _put_knot(state, k, normal, road, profile, bumps, obstacle, wheel):
    """Draw knot k into the ring from a standard normal number."""
    state.roughness = road.memory * state.roughness + road.innovation * state.roughness_sd * normal
    height = state.roughness
    if bumps is not None:
        height += bump_height(state.key, k * road.knot_spacing, bumps)
    state.knots[k & (RING - 1)] = height


@kernel
def _draw_pair(state, pair, road, profile, bumps, obstacle, wheel):
    """Draw the knots 2 pair and 2 pair + 1 into the ring."""
    first, second = normal_pair(state.key, pair)
    _put_knot(state, 2 * pair, first, road, profile, bumps, obstacle, wheel)
    _put_knot(state, 2 * pair + 1, second, road, profile, bumps, obstacle, wheel)


@kernel
def start_road(state, road, profile, bumps, obstacle, wheel):
    """Draw the roughness of the episode and fill the ring; the wheel stands on knot 0."""
    density = road.density * 2.0 ** (road.spread * (2.0 * uniform(state.key, _DENSITY) - 1.0))
    state.roughness_sd = 0.1 * math.sqrt(0.5 * math.pi * density / road.cutoff)
    state.roughness = state.roughness_sd * normal_pair(state.key, _START // 2)[0]
    state.knot = 0
    state.to_knot = road.knot_spacing
    for pair in range(RING // 2):
        _draw_pair(state, pair, road, profile, bumps, obstacle, wheel)


@kernel
def slope_of_road(state, road):
    """Slope (height over distance) of the segment on which the wheel is."""
    k = state.knot
    return (state.knots[(k + 1) & (RING - 1)] - state.knots[k & (RING - 1)]) / road.knot_spacing


@kernel
def pass_knot(state, road, profile, bumps, obstacle, wheel):
    """The wheel has come to the next knot; at every second one the two slots behind it get new knots."""
    state.knot += 1
    state.to_knot = road.knot_spacing
    if state.knot & 1 == 0:
        _draw_pair(state, state.knot // 2 + RING // 2 - 1, road, profile, bumps, obstacle, wheel)


@kernel
def place_on_road(state, road):
    """Where the wheel is, in knot spacings from the knot behind it."""
    return 1.0 - state.to_knot / road.knot_spacing


@kernel
def road_height(state, place):
    """Height of the road `place` >= 0 knot spacings from the knot behind the wheel, at most RING - 3."""
    whole = int(place)
    k = state.knot + whole
    left, right = state.knots[k & (RING - 1)], state.knots[(k + 1) & (RING - 1)]
    return left + (right - left) * (place - whole)
