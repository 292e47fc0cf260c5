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
def bits(key: int, counter: int) -> np.uint64:
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
def cos_sin_turns(turns: float) -> tuple[float, float]:
    """Cosine and sine of 2 pi `turns`, 0 <= turns <= 1, to 1 ulp, without branches.

    fdlibm's polynomials (Sun Microsystems 1993) on the nearest quarter turn: a library's branches on the size of a
    random angle are mispredicted and cost more than the polynomials.
    """
    quarter = math.floor(4.0 * turns + 0.5)
    r = (4.0 * turns - quarter) * (0.5 * math.pi)
    z = r * r
    sine = r + r * z * (
        -1.66666666666666324348e-01
        + z
        * (
            8.33333333332248946124e-03
            + z
            * (
                -1.98412698298579493134e-04
                + z * (2.75573137070700676789e-06 + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10))
            )
        )
    )
    cosine = (
        1.0
        - 0.5 * z
        + z
        * z
        * (
            4.16666666666666019037e-02
            + z
            * (
                -1.38888888888741095749e-03
                + z
                * (
                    2.48015872894767294178e-05
                    + z
                    * (-2.75573143513906633035e-07 + z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11))
                )
            )
        )
    )
    k = int(quarter)
    c, s = (sine, cosine) if k & 1 else (cosine, sine)
    return (-c if (k + 1) & 2 else c), (-s if k & 2 else s)


@kernel
def normal_pair(key: int, counter: int) -> tuple[float, float]:
    """Two independent standard normal numbers (Box and Muller); uses the counters 2 counter and 2 counter + 1."""
    radius = math.sqrt(-2.0 * math.log(uniform(key, 2 * counter)))
    cosine, sine = cos_sin_turns(uniform(key, 2 * counter + 1))
    return radius * cosine, radius * sine
