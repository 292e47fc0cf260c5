"""Undulating terrain under a wheel: three sines.

Heights are in m, up; distances ahead in m. The kernels read and write `key`, `wave_cos` and `wave_sin` (3 each; the
sines' phases at the wheel) of a state record. Roads are in `road`.
"""

from __future__ import annotations

import dataclasses
import math

from vr_envs.models.jit import kernel
from vr_envs.models.noise import uniform
from vr_envs.models.record import quantity

WAVES = 3
_GOLDEN = 0.5 * (1.0 + math.sqrt(5.0))

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
