"""First-order gusts: w' = -w / T + white noise, standard deviation sigma, T = L / V (Dryden's longitudinal form).

The discretisation is exact: the end value given the start value, and the integral given both ends, are
Gaussian, and their means and variances are known. Source of the form: MIL-F-8785C, u component,
Phi(W) = sigma^2 (2 L / pi) / (1 + (L W)^2).
"""

from __future__ import annotations

import math

from vr_envs.models.jit import kernel

# below this half-interval (in units of T) the difference q - tanh q is taken from a Pade approximant of tanh
_SMALL = 0.5
SCALE_LENGTH = 533.4  # m, above 2000 ft (MIL-F-8785C)


@kernel
def gust_after(gust: float, decay: float, sigma: float, deviate: float) -> float:
    """End value of a gust: `decay` = exp(-interval / T), `deviate` a standard normal number."""
    return decay * gust + sigma * math.sqrt(1.0 - decay * decay) * deviate


@kernel
def gust_integral(
    before: float, after: float, interval: float, time: float, decay: float, sigma: float, deviate: float
) -> float:
    """Integral of a gust over an `interval` whose two ends are known (the Ornstein-Uhlenbeck bridge).

    Mean T tanh(q) (before + after), variance 4 sigma^2 T^2 (q - tanh q) with q = interval / (2 T);
    `time` = T [s], `decay` = exp(-interval / T), `deviate` a standard normal number.
    """
    tanh_q = (1.0 - decay) / (1.0 + decay)
    spread = 2.0 * sigma * math.sqrt(excess_over_tanh(0.5 * interval / time, tanh_q))
    return time * (tanh_q * (before + after) + spread * deviate)


@kernel
def excess_over_tanh(q: float, tanh_q: float) -> float:
    """The difference q - tanh q for q >= 0."""
    if q > _SMALL:
        return q - tanh_q
    s = q * q  # Pade (7, 6) of tanh; relative error of the difference below 3e-15
    numerator = q * s * (45045.0 + s * (2772.0 + s * 27.0))
    return numerator / (135135.0 + s * (62370.0 + s * (3150.0 + s * 28.0)))
