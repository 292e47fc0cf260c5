"""Counter-based random numbers: pure functions of (key, counter), so that a saved record replays exactly.

The generator is the finaliser of SplitMix64 (Steele, Lea, Flood 2014) applied to key + counter * golden gamma:
draw number `counter` of the SplitMix64 sequence that starts at `key`.
"""

from __future__ import annotations

import math

import numpy as np

from vr_envs.models.jit import kernel

_GAMMA = np.uint64(0x9E3779B97F4A7C15)
_MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX_2 = np.uint64(0x94D049BB133111EB)
_S30, _S27, _S31, _S12 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(12)


@kernel
def bits(key: int, counter: int) -> int:
    """64 random bits for the unsigned 64-bit `key` and the integer `counter` >= 0."""
    z = np.uint64(key) + (np.uint64(counter) + np.uint64(1)) * _GAMMA
    z = (z ^ (z >> _S30)) * _MIX_1
    z = (z ^ (z >> _S27)) * _MIX_2
    return z ^ (z >> _S31)


@kernel
def uniform(key: int, counter: int) -> float:
    """Uniform in the open interval (0, 1), symmetric about 1/2, at odd multiples of 2^-53."""
    return (float(bits(key, counter) >> _S12) + 0.5) * 2.0**-52


@kernel
def normal_pair(key: int, counter: int) -> tuple[float, float]:
    """Two independent standard normal numbers (Box and Muller); uses the counters 2 counter and 2 counter + 1."""
    radius = math.sqrt(-2.0 * math.log(uniform(key, 2 * counter)))
    angle = 2.0 * math.pi * uniform(key, 2 * counter + 1)
    return radius * math.cos(angle), radius * math.sin(angle)
