"""Exponential, logarithm, sine and cosine, and powers without a branch: as fast on lanes as arithmetic is.

Each is within 1 ulp, denormal results included, where its docstring does not say otherwise. Reductions and polynomials
are fdlibm's (Sun Microsystems 1993), but for the exponential's, which is Taylor's; the rarely needed branches of fdlibm
are gone, and a table as the C library has it would be read one lane after the other.
"""

from __future__ import annotations

import math
import struct

from vr_envs.models.jit import kernel
from vr_envs.models.lanes import bits_of_float, float_of_bits, where

# Added to a number of modest size this rounds it to a whole one, which stands in the low bits of the sum.
_ROUND = 1.5 * 2.0**52
_ROUND_BITS = struct.unpack("<q", struct.pack("<d", _ROUND))[0]
_ONE_BITS = 1023 << 52
_MANTISSA = (1 << 52) - 1
_HIGH_26 = -1 << 27  # mask that leaves a float 26 significant bits, so that products of two of them are exact

# ln 2 in two parts; the first one has so few digits that its product with any binary exponent is exact
_LN2_HIGH, _LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
# pi/2 in four parts of which the first three have 33 bits
_HALF_PI_1, _HALF_PI_2, _HALF_PI_3, _HALF_PI_4 = (
    1.57079632673412561417e00, 6.07710050630396597660e-11, 2.02226624871116645580e-21, 8.47842766036889956997e-32,
)  # fmt: skip
_SQRT_HALF_BITS = 0x3FE6A09E00000000  # of about sqrt(1/2): the mantissas of `_split` begin there

_E2, _E3, _E4, _E5, _E6, _E7, _E8, _E9, _E10, _E11, _E12, _E13 = (1.0 / math.factorial(n) for n in range(2, 14))
_L1, _L2, _L3, _L4, _L5, _L6, _L7 = (
    6.666666666666735130e-01, 3.999999999940941908e-01, 2.857142874366239149e-01, 2.222219843214978396e-01,
    1.818357216161805012e-01, 1.531383769920937332e-01, 1.479819860511658591e-01,
)  # fmt: skip
_S1, _S2, _S3, _S4, _S5, _S6 = (
    -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04,
    2.75573137070700676789e-06, -2.50507602534068634195e-08, 1.58969099521155010221e-10,
)  # fmt: skip
_C1, _C2, _C3, _C4, _C5, _C6 = (
    4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05,
    -2.75573143513906633035e-07, 2.08757232129817482790e-09, -1.13596475577881948265e-11,
)  # fmt: skip


@kernel
def _power_of_two(k):
    """2^k for an integer -1022 <= k <= 1023."""
    return float_of_bits((k << 52) + _ONE_BITS)


@kernel
def _exp_of_sum(high, low):
    """e^(high + low), where `low`, if not None, is at most a few ulp of `high`."""
    # beyond these the result is infinite or zero; the scaling by powers of two stays in their range
    x = min(max(high, -750.0), 710.0)
    shifted = x * (1.0 / math.log(2.0)) + _ROUND
    n = shifted - _ROUND
    coarse, fine = x - n * _LN2_HIGH, n * _LN2_LOW
    if low is not None:
        fine -= low
    r = coarse - fine
    rest = (coarse - r) - fine
    r2 = r * r
    r4 = r2 * r2
    # in pairs, which do not wait for each other
    high_half = ((_E10 + r * _E11) + r2 * (_E12 + r * _E13)) * r4 + ((_E6 + r * _E7) + r2 * (_E8 + r * _E9))
    series = (_E2 + r * _E3) + r2 * (_E4 + r * _E5) + r4 * high_half
    y = 1.0 + (r + (rest + r2 * series))
    k = bits_of_float(shifted) - _ROUND_BITS
    half = k >> 1  # in two factors: 2^k itself may be out of range, and a denormal result is rounded once
    return y * _power_of_two(half) * _power_of_two(k - half)


@kernel
def exp(x):
    """e^x; infinity from 709.8 on, 0 below -745.2."""
    return _exp_of_sum(x, None)


@kernel
def _split(x):
    """(k, f) with x = 2^k (1 + f), x > 0, and 1 + f between sqrt(1/2) and sqrt(2)."""
    small = x < 2.0**-1022
    bits = bits_of_float(where(small, x * 2.0**54, x)) - _SQRT_HALF_BITS
    k = float_of_bits((bits >> 52) + _ROUND_BITS) - where(small, _ROUND + 54.0, _ROUND)
    return k, float_of_bits((bits & _MANTISSA) + _SQRT_HALF_BITS) - 1.0


@kernel
def _artanh_rest(s):
    """2 artanh(s) / s - 2 for |s| < 0.172; ln(1 + f) = 2 artanh(s) with s = f / (2 + f)."""
    z = s * s
    w = z * z
    return z * (_L1 + w * (_L3 + w * (_L5 + w * _L7))) + w * (_L2 + w * (_L4 + w * _L6))


@kernel
def log(x):
    """ln x for x > 0."""
    k, f = _split(x)
    s = f / (2.0 + f)
    half = 0.5 * f * f
    return k * _LN2_HIGH - ((half - (s * (half + _artanh_rest(s)) + k * _LN2_LOW)) - f)


@kernel
def _log_parts(x):
    """ln x, x > 0, as a sum of two numbers to about 60 bits, the second of the size of an ulp of the first or less."""
    k, f = _split(x)
    inverse = 1.0 / (2.0 + f)
    s = f * inverse
    s_high, sum_high = float_of_bits(bits_of_float(s) & _HIGH_26), float_of_bits(bits_of_float(2.0 + f) & _HIGH_26)
    s_low = ((f - s_high * sum_high) - s_high * (f - (sum_high - 2.0))) * inverse
    low = 2.0 * s_low + (s * _artanh_rest(s) + k * _LN2_LOW)
    whole, part = k * _LN2_HIGH, 2.0 * s_high
    high = whole + part
    low += (whole - high) + part  # exact: where k is not 0, `whole` is the larger one
    total = high + low
    return total, (high - total) + low


@kernel
def power(x, y):
    """x^y for x > 0: within 1 ulp where the result is between 1e-6 and 1e6, within 40 at the ends of the range."""
    high, low = _log_parts(x)
    y_high, log_high = float_of_bits(bits_of_float(y) & _HIGH_26), float_of_bits(bits_of_float(high) & _HIGH_26)
    y_low, log_low = y - y_high, high - log_high
    product = y * high
    error = ((y_high * log_high - product) + y_high * log_low + y_low * log_high) + y_low * log_low
    return _exp_of_sum(product, error + y * low)


@kernel
def cos_sin_near_quarter(r, tail, quarter):
    """Cosine and sine of (quarter of a turn) `quarter` + r + tail, |r| <= pi/4.

    `quarter` is a whole number, a float below 2^51; `tail` an error of r below its last digit, or None.
    """
    z = r * r
    w = z * z
    half = 0.5 * z
    whole = 1.0 - half
    sine_series = _S2 + z * (_S3 + z * _S4) + z * w * (_S5 + z * _S6)
    cosine_series = z * (_C1 + z * (_C2 + z * _C3)) + w * w * (_C4 + z * (_C5 + z * _C6))
    cube = z * r
    rest = (1.0 - whole) - half
    if tail is None:
        sine = r + cube * (_S1 + z * sine_series)
        cosine = whole + (rest + z * cosine_series)
    else:
        sine = r - ((z * (0.5 * tail - cube * sine_series) - tail) - cube * _S1)
        cosine = whole + (rest + (z * cosine_series - r * tail))
    k = bits_of_float(quarter + _ROUND)
    odd = (k & 1) != 0
    c, s = where(odd, sine, cosine), where(odd, cosine, sine)
    return where(((k + 1) & 2) != 0, -c, c), where((k & 2) != 0, -s, s)


@kernel
def cos_sin(angle):
    """Cosine and sine of an angle [rad] of at most 1.6e6."""
    quarter = (angle * (2.0 / math.pi) + _ROUND) - _ROUND
    # Cody and Waite: each product is exact, and what a difference loses is kept for the next one
    a = angle - quarter * _HALF_PI_1
    part = quarter * _HALF_PI_2
    b = a - part
    part = quarter * _HALF_PI_3 - ((a - b) - part)
    c = b - part
    part = quarter * _HALF_PI_4 - ((b - c) - part)
    r = c - part
    return cos_sin_near_quarter(r, (c - r) - part, quarter)
