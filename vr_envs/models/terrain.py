"""Terrain under a wheel: an undulation of three sines, and an ISO 8608 road that is piecewise linear by definition.

Heights are in m, up; distances along the road in m, ahead. The kernels read and write these fields of a state record:
`key`; `wave_cos`, `wave_sin` (3 each; the sines' phases at the wheel); `knots` (a ring of `RING` knot heights),
`knot` (index of the knot behind the wheel), `to_knot` (distance to the next one), `roughness`, `roughness_sd`.

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
WAVES = 3
_GOLDEN = 0.5 * (1.0 + math.sqrt(5.0))

# Counters of an episode's key, one range for each use; the pairs of knots use those below _DENSITY.
_DENSITY, _PHASE, _BUMP, _START = 1 << 40, 1 << 41, 1 << 42, 1 << 43


@dataclasses.dataclass(frozen=True)
class Undulation:
    """Three sines, smooth: each next one is shorter and lower by the golden ratio, so they never repeat together."""

    amplitude: float = quantity(0.04, "m", "amplitude of the longest sine", low=0.0, high=1.0)
    wavelength: float = quantity(40.0, "m", "its wavelength", low=1.0, high=1e4)


@dataclasses.dataclass(frozen=True)
class Road:
    """A road of an ISO 8608 class; the density of an episode is drawn about the class mean."""

    iso_class: str = quantity("C", "", "ISO 8608 class", choices=tuple("ABCDEFGH"))
    spread: float = quantity(1.0, "octave", "the density is its mean times 2^U(-spread, spread)", low=0.0, high=4.0)
    knot_spacing: float = quantity(0.2, "m", "distance between knots of the profile", low=0.01, high=10.0)
    cutoff: float = quantity(0.011, "cycle/m", "longest waves: the density is flat below", low=1e-4, high=0.1)

    DERIVED = ("density", "memory", "innovation")

    @property
    def density(self) -> float:
        """Gd(n0) [m^3], the geometric mean of the class."""
        return 16e-6 * 4.0 ** "ABCDEFGH".index(self.iso_class)

    @property
    def memory(self) -> float:
        """Correlation phi of neighbouring knots."""
        return math.exp(-2.0 * math.pi * self.cutoff * self.knot_spacing)

    @property
    def innovation(self) -> float:
        """sqrt(1 - phi^2)."""
        return math.sqrt(-math.expm1(-4.0 * math.pi * self.cutoff * self.knot_spacing))


@dataclasses.dataclass(frozen=True)
class Bumps:
    """Triangular bumps and dips on a road, one at a random place in each stretch, sampled at the road's knots."""

    stretch: float = quantity(40.0, "m", "length of road with one bump or dip", low=1.0, high=1e5)
    low: float = quantity(0.03, "m", "smallest height or depth", low=0.0, high=0.5)
    high: float = quantity(0.08, "m", "largest height or depth", low=0.0, high=0.5)
    shortest: float = quantity(1.0, "m", "smallest distance from foot to top", low=0.1, high=100.0)
    longest: float = quantity(3.0, "m", "largest distance from foot to top", low=0.1, high=100.0)


@kernel
def start_undulation(state):
    """Draw the phases of the sines."""
    for i in range(WAVES):
        phase = 2.0 * math.pi * uniform(state.key, _PHASE + i)
        state.wave_cos[i] = math.cos(phase)
        state.wave_sin[i] = math.sin(phase)


@kernel
def wave(i, undulation):
    """Amplitude [m] and wave number [rad/m] of sine i."""
    ratio = _GOLDEN**i
    return undulation.amplitude / ratio, 2.0 * math.pi * ratio / undulation.wavelength


@kernel
def undulation_ahead(state, distance, undulation):
    """Height of the sines at `distance` ahead of the wheel."""
    height = 0.0
    for i in range(WAVES):
        amplitude, number = wave(i, undulation)
        angle = number * distance
        height += amplitude * (state.wave_sin[i] * math.cos(angle) + state.wave_cos[i] * math.sin(angle))
    return height


@kernel
def roll_undulation(state, distance, undulation):
    """Move the wheel ahead by `distance` on the sines."""
    for i in range(WAVES):
        _, number = wave(i, undulation)
        cosine, sine = math.cos(number * distance), math.sin(number * distance)
        before = state.wave_cos[i]
        state.wave_cos[i] = before * cosine - state.wave_sin[i] * sine
        state.wave_sin[i] = state.wave_sin[i] * cosine + before * sine


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
def _put_knot(state, k, normal, road, bumps):
    """Draw knot k into the ring from a standard normal number."""
    state.roughness = road.memory * state.roughness + road.innovation * state.roughness_sd * normal
    height = state.roughness
    if bumps is not None:
        height += bump_height(state.key, k * road.knot_spacing, bumps)
    state.knots[k & (RING - 1)] = height


@kernel
def _draw_pair(state, pair, road, bumps):
    """Draw the knots 2 pair and 2 pair + 1 into the ring."""
    first, second = normal_pair(state.key, pair)
    _put_knot(state, 2 * pair, first, road, bumps)
    _put_knot(state, 2 * pair + 1, second, road, bumps)


@kernel
def start_road(state, road, bumps):
    """Draw the roughness of the episode and fill the ring; the wheel stands on knot 0."""
    density = road.density * 2.0 ** (road.spread * (2.0 * uniform(state.key, _DENSITY) - 1.0))
    state.roughness_sd = 0.1 * math.sqrt(0.5 * math.pi * density / road.cutoff)
    state.roughness = state.roughness_sd * normal_pair(state.key, _START // 2)[0]
    state.knot = 0
    state.to_knot = road.knot_spacing
    for pair in range(RING // 2):
        _draw_pair(state, pair, road, bumps)


@kernel
def slope_of_road(state, road):
    """Slope (height over distance) of the segment on which the wheel is."""
    k = state.knot
    return (state.knots[(k + 1) & (RING - 1)] - state.knots[k & (RING - 1)]) / road.knot_spacing


@kernel
def pass_knot(state, road, bumps):
    """The wheel has come to the next knot; at every second one the two slots behind it get new knots."""
    state.knot += 1
    state.to_knot = road.knot_spacing
    if state.knot & 1 == 0:
        _draw_pair(state, state.knot // 2 + RING // 2 - 1, road, bumps)


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
