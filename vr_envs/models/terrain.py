"""Undulating terrain under a wheel: three sines.

Heights are in m, up; distances ahead in m. The kernels read and write `key`, `wave_cos` and `wave_sin` (3 each; the
sines' phases at the wheel) of a state record. Roads are in `road`.
"""

from __future__ import annotations

import dataclasses
import math

from vr_envs.models.jit import kernel
from vr_envs.models.noise import uniform
from vr_envs.models.phasor import cos_sin
from vr_envs.models.record import quantity

WAVES = 3
_GOLDEN = 0.5 * (1.0 + math.sqrt(5.0))
_SHORTER = tuple(_GOLDEN**i for i in range(WAVES))
_LOWER = tuple(_GOLDEN**-i for i in range(WAVES))

_PHASE = 1 << 41  # first counter of the phases' draws


@dataclasses.dataclass(frozen=True)
class Undulation:
    """Three sines, smooth: each next one is shorter and lower by the golden ratio, so they never repeat together."""

    amplitude: float = quantity(0.04, "m", "amplitude of the longest sine", low=0.0, high=1.0)
    wavelength: float = quantity(40.0, "m", "its wavelength", low=1.0, high=1e4)


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
    return undulation.amplitude * _LOWER[i], 2.0 * math.pi / undulation.wavelength * _SHORTER[i]


@kernel
def undulation_ahead(state, distance, undulation):
    """Height of the sines at `distance` ahead of the wheel."""
    height = 0.0
    for i in range(WAVES):
        amplitude, number = wave(i, undulation)
        cosine, sine = cos_sin(number * distance)
        height += amplitude * (state.wave_sin[i] * cosine + state.wave_cos[i] * sine)
    return height


@kernel
def roll_undulation(state, distance, undulation):
    """Move the wheel ahead by `distance` on the sines."""
    for i in range(WAVES):
        _, number = wave(i, undulation)
        cosine, sine = cos_sin(number * distance)
        c, s = state.wave_cos[i], state.wave_sin[i]
        state.wave_cos[i], state.wave_sin[i] = c * cosine - s * sine, s * cosine + c * sine
