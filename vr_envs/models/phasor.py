"""Arithmetic of phasors: c cos(angle) + s sin(angle), its derivatives and, for short times, its changes.

A *wave* is the pair (cosine, sine) of an angle.
"""

from __future__ import annotations

import math

from vr_envs.models.jit import kernel


@kernel
def cos_sin(angle):
    """Cosine and sine of an angle; small ones, as in a chatter or of a tilt, by Taylor's series to rounding."""
    if abs(angle) > 0.1:
        return math.cos(angle), math.sin(angle)
    q = angle * angle
    cos = 1.0 + q * (-1 / 2 + q * (1 / 24 + q * (-1 / 720 + q * (1 / 40320 - q * (1 / 3628800)))))
    sin = angle + angle * q * (-1 / 6 + q * (1 / 120 + q * (-1 / 5040 + q * (1 / 362880))))
    return cos, sin


@kernel
def angular(omega, frequencies):
    """Angular frequencies of x, tilt and z, rad/s: omega, omega and 2 omega, or their own multiples of omega."""
    if frequencies is None:
        return omega, omega, 2.0 * omega
    else:
        return frequencies.x * omega, frequencies.tilt * omega, frequencies.z * omega


@kernel
def waves_at(omega, s, frequencies, phase):
    """Waves of x, tilt and z at time s; `phase` are their angles at s = 0, used with frequencies of their own."""
    if frequencies is None:
        cos, sin = math.cos(omega * s), math.sin(omega * s)
        return (cos, sin), (cos, sin), (cos * cos - sin * sin, 2.0 * sin * cos)
    else:
        w = angular(omega, frequencies)
        a, b, c = w[0] * s + phase[0], w[1] * s + phase[1], w[2] * s + phase[2]
        return (math.cos(a), math.sin(a)), (math.cos(b), math.sin(b)), (math.cos(c), math.sin(c))


@kernel
def turned(wave, half):
    """A wave turned by twice the angle of the wave `half`: (end, change without cancellation, middle).

    cos(b) - cos(a) = -2 sin((a+b)/2) sin((b-a)/2).
    """
    c, s = wave
    ch, sh = half
    cm, sm = c * ch - s * sh, s * ch + c * sh
    return (cm * ch - sm * sh, sm * ch + cm * sh), (-2.0 * sm * sh, 2.0 * cm * sh), (cm, sm)


@kernel
def turned_waves(omega, waves, ds, frequencies):
    """The waves of x, tilt and z a time ds later, and their changes."""
    if frequencies is None:
        half = cos_sin(0.5 * omega * ds)
        end, change, middle = turned(waves[0], half)
        cm, sm = middle
        ch, sh = half
        s_2mid, c_2mid, s_2half = 2.0 * sm * cm, cm * cm - sm * sm, 2.0 * sh * ch
        end_2 = (end[0] * end[0] - end[1] * end[1], 2.0 * end[1] * end[0])
        return (end, end, end_2), (change, change, (-2.0 * s_2mid * s_2half, 2.0 * c_2mid * s_2half))
    else:
        w = angular(omega, frequencies)
        a, d_a, _ = turned(waves[0], cos_sin(0.5 * w[0] * ds))
        b, d_b, _ = turned(waves[1], cos_sin(0.5 * w[1] * ds))
        c, d_c, _ = turned(waves[2], cos_sin(0.5 * w[2] * ds))
        return (a, b, c), (d_a, d_b, d_c)


@kernel
def phasor(c, s, w, wave):
    """Value and three derivatives of c cos + s sin at an angular frequency w."""
    cos, sin = wave
    q0 = c * cos + s * sin
    q1 = w * (s * cos - c * sin)
    return q0, q1, -w * w * q0, -w * w * q1


@kernel
def plus_blend(base, change, s0, s1, s2, s3):
    """Leibniz rule for base + S change, values with three derivatives; `s0..s3` are S and its derivatives."""
    b0, b1, b2, b3 = base
    c0, c1, c2, c3 = change
    return (
        b0 + s0 * c0,
        b1 + s0 * c1 + s1 * c0,
        b2 + s0 * c2 + 2.0 * s1 * c1 + s2 * c0,
        b3 + s0 * c3 + 3.0 * s1 * c2 + 3.0 * s2 * c1 + s3 * c0,
    )


@kernel
def phasor_change(c, s, w, end, change):
    """Change of a phasor's value, and its first and second derivative at the end of the change."""
    cos, sin = end
    return c * change[0] + s * change[1], w * (s * cos - c * sin), -w * w * (c * cos + s * sin)


@kernel
def plus_blend_change(base, c, s, w, end, change, blend):
    """`phasor_change` of base + S times the phasor (c, s); `blend`: S, S', S'' at the end, and the change of S."""
    part = phasor_change(c, s, w, end, change)
    value = c * end[0] + s * end[1]
    s0, s1, s2, d_s = blend
    return (
        base[0] + s0 * part[0] + d_s * (value - part[0]),
        base[1] + s0 * part[1] + s1 * value,
        base[2] + s0 * part[2] + 2.0 * s1 * part[1] + s2 * value,
    )
