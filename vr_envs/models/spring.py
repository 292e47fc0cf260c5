"""Damped spring (the lecture's spring, equations 3.81 to 3.88): exact motion over any time.

About its equilibrium the mass obeys  x'' + gamma x' + w2 x = 0,  with gamma = c/m [1/s] and w2 = k/m [1/s^2]. With
q = (w2 - gamma^2/4) t^2 the solution is, in every regime and without a case for the critical one,

    x(t) = e^(-gamma t/2) [C x0 + S t (v0 + gamma x0/2)]
    v(t) = e^(-gamma t/2) [C v0 - S t (w2 x0 + gamma v0/2)],   C = cos(sqrt q),  S = sin(sqrt q)/sqrt(q),

where C and S are entire functions of q: cosh and sinh take over where q < 0.
"""

from __future__ import annotations

import math

from vr_envs.models.elementary import cos_sin, exp
from vr_envs.models.jit import kernel
from vr_envs.models.lanes import any_lane, where

# Within this |q| six terms of the series leave less than 2^-56, and no sine or exponential is needed.
_SERIES = 0.0625
_C1, _C2, _C3, _C4, _C5, _C6 = (1.0 / math.factorial(2 * n) for n in range(1, 7))
_S1, _S2, _S3, _S4, _S5, _S6 = (1.0 / math.factorial(2 * n + 1) for n in range(1, 7))


@kernel
def damped_cosine_sine(gamma: float, w2: float, t: float) -> tuple[float, float]:
    """(e^(-gamma t/2) C, e^(-gamma t/2) S) for t >= 0 [s], gamma >= 0 [1/s] and w2 >= 0 [1/s^2]; never overflows."""
    half = 0.5 * gamma * t
    q = w2 * t * t - half * half
    decay = exp(-half)
    cosine = decay * (1.0 - q * (_C1 - q * (_C2 - q * (_C3 - q * (_C4 - q * (_C5 - q * _C6))))))
    sine = decay * (1.0 - q * (_S1 - q * (_S2 - q * (_S3 - q * (_S4 - q * (_S5 - q * _S6))))))
    swinging = q >= _SERIES
    if any_lane(swinging):
        z = math.sqrt(abs(q))
        c, s = cos_sin(z)
        cosine, sine = where(swinging, decay * c, cosine), where(swinging, decay * s / z, sine)
    creeping = q <= -_SERIES
    if any_lane(creeping):
        z = math.sqrt(abs(q))
        # z - half without cancellation: the slow decay of a strongly damped spring
        slow, fast = 0.5 * exp(-w2 * t * t / (z + half)), exp(-2.0 * z)
        cosine, sine = where(creeping, slow * (1.0 + fast), cosine), where(creeping, slow * (1.0 - fast) / z, sine)
    return cosine, sine


@kernel
def free_motion(x: float, v: float, gamma: float, w2: float, t: float) -> tuple[float, float]:
    """Displacement from equilibrium [m] and velocity [m/s] after the time t >= 0 [s], from (x, v)."""
    cosine, sine = damped_cosine_sine(gamma, w2, t)
    sine *= t
    return (
        cosine * x + sine * (v + 0.5 * gamma * x),
        cosine * v - sine * (w2 * x + 0.5 * gamma * v),
    )


def damping_of_restitution(restitution: float, interval: float) -> float:
    """Damping gamma [1/s] of the lecture's factor k_d (3.88), which multiplies the velocity once per `interval` [s].

    k_d is no physical constant: e^(-gamma interval) = k_d holds at one interval only.
    """
    return -math.log(restitution) / interval
