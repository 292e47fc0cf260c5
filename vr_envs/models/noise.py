"""Counter-based random numbers: pure functions of (key, counter), so that a saved record replays exactly.

The generator is the finaliser of SplitMix64 (Steele, Lea, Flood 2014) applied to key + counter * golden gamma:
draw number `counter` of the SplitMix64 sequence that starts at `key`.
"""

from __future__ import annotations

import math

import numpy as np

from vr_envs.models.elementary import cos_sin_near_quarter, log
from vr_envs.models.jit import kernel
from vr_envs.models.lanes import float_of_bits, floor, to_int, to_key

_GAMMA = np.uint64(0x9E3779B97F4A7C15)
_MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX_2 = np.uint64(0x94D049BB133111EB)
_ONE, _BITS_OF_ONE = np.uint64(1), np.uint64(1023 << 52)
_S30, _S27, _S31, _S12 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(12)


@kernel
def bits(key: int, counter: int) -> np.uint64:
    """64 random bits for the unsigned 64-bit `key` and the integer `counter` >= 0."""
    z = to_key(key) + (to_key(counter) + _ONE) * _GAMMA
    z = (z ^ (z >> _S30)) * _MIX_1
    z = (z ^ (z >> _S27)) * _MIX_2
    return z ^ (z >> _S31)


@kernel
def uniform(key: int, counter: int) -> float:
    """Uniform in the open interval (0, 1), symmetric about 1/2, at odd multiples of 2^-53."""
    # as the digits of a number in [1, 2)
    return float_of_bits(to_int((bits(key, counter) >> _S12) | _BITS_OF_ONE)) - (1.0 - 2.0**-53)


@kernel
def cos_sin_turns(turns: float) -> tuple[float, float]:
    """Cosine and sine of 2 pi `turns`, 0 <= turns <= 1, to 1 ulp of 1."""
    quarter = floor(4.0 * turns + 0.5)
    return cos_sin_near_quarter((4.0 * turns - quarter) * (0.5 * math.pi), None, quarter)


@kernel
def normal_pair(key: int, counter: int) -> tuple[float, float]:
    """Two independent standard normal numbers (Box and Muller); uses the counters 2 counter and 2 counter + 1."""
    radius = math.sqrt(-2.0 * log(uniform(key, 2 * counter)))
    cosine, sine = cos_sin_turns(uniform(key, 2 * counter + 1))
    return radius * cosine, radius * sine
