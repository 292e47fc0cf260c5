"""What a scene of the ball on a bar may add. An absent option is passed to the kernels as None and compiled away."""

from __future__ import annotations

import dataclasses

from vr_envs.models.camera import Camera
from vr_envs.models.record import quantity


@dataclasses.dataclass(frozen=True)
class Scatter:
    """Option: an imperfect ball and surface (Bell: "a great variation in the C.o.R. values")."""

    restitution: float = quantity(0.02, "", "standard deviation of alpha from impact to impact", low=0.0, high=0.3)
    normal: float = quantity(0.002, "rad", "standard deviation of the surface normal", low=0.0, high=0.1)


@dataclasses.dataclass(frozen=True)
class Spin:
    """Option: a ball that grips the bar, spins and rolls (Wang and Mason 1992). Replaces `tangential_loss`."""

    inertia_ratio: float = quantity(0.4, "", "I/(m R^2): 2/5 solid sphere, 2/3 hollow, 1/2 disc", low=0.0, high=1.0)
    radius: float = quantity(0.0025, "m", "radius R of the ball", low=1e-4, high=1.0)


@dataclasses.dataclass(frozen=True)
class Friction:
    """Option: the grip has a limit (Coulomb): beyond it the ball slides, in an impact and at rest."""

    coefficient: float = quantity(0.2, "", "tangential over normal impulse at most", low=0.0, high=10.0)
    restitution: float = quantity(
        0.0, "", "tangential restitution: part of the slip that a gripping impact reverses", low=0.0, high=1.0
    )


@dataclasses.dataclass(frozen=True)
class Softening:
    """Option: restitution falls with the impact speed v: alpha (1 + v/speed)^-exponent (Johnson: plastic, 1/4)."""

    speed: float = quantity(1.0, "m/s", "speed from which restitution falls", low=1e-3, high=1e3)
    exponent: float = quantity(0.25, "", "power of the fall", low=0.0, high=2.0)


@dataclasses.dataclass(frozen=True)
class Curve:
    """Option: a curved bar, z = curvature x^2/2 for the path of the ball's centre, in the bar's axes."""

    curvature: float = quantity(
        13.3,
        "1/m",
        "at the middle, positive is concave: 1/(R_s - R) for a ball of radius R on a surface of radius R_s "
        "(plano-concave lens of crown glass, focal length 15 cm: 77.6 - 2.5 mm)",
        low=-100.0,
        high=100.0,
    )


@dataclasses.dataclass(frozen=True)
class Frequencies:
    """Option: frequencies of their own for x, tilt and z, in multiples of the base frequency.

    An action still sets amplitudes, so peak accelerations grow with the square of these numbers.
    """

    x: float = quantity(1.0, "", "frequency of x over the base frequency", low=0.0, high=20.0)
    tilt: float = quantity(1.0, "", "frequency of the tilt over the base frequency", low=0.0, high=20.0)
    z: float = quantity(2.0, "", "frequency of z over the base frequency (2 without this option)", low=0.0, high=20.0)


@dataclasses.dataclass(frozen=True)
class Ramp:
    """Option: peak accelerations that grow slowly in time, on top of the motion asked for (Bell Fig 3.8)."""

    x_cos: float = quantity(0.0, "m/s^3", "growth of the cosine part of x", low=-10.0, high=10.0)
    x_sin: float = quantity(0.0, "m/s^3", "growth of the sine part of x", low=-10.0, high=10.0)
    tilt_cos: float = quantity(0.0, "rad/s^3", "growth of the cosine part of the tilt", low=-1000.0, high=1000.0)
    tilt_sin: float = quantity(0.0, "rad/s^3", "growth of the sine part of the tilt", low=-1000.0, high=1000.0)
    z_cos: float = quantity(0.018, "m/s^3", "growth of the cosine part of z", low=-10.0, high=10.0)
    z_sin: float = quantity(0.0, "m/s^3", "growth of the sine part of z", low=-10.0, high=10.0)


@dataclasses.dataclass(frozen=True)
class Sensing:
    """Option: the ball is observed late and with noise; the bar's motion is known."""

    position: float = quantity(1e-4, "m", "standard deviation of x and z", low=0.0, high=0.1)
    velocity: float = quantity(0.01, "m/s", "standard deviation of the velocities and the spin", low=0.0, high=10.0)
    delay: float = quantity(
        0.005, "s", "age of the observation; at most an interval, or a base cycle", low=0.0, high=2.0
    )


@dataclasses.dataclass(frozen=True)
class Textbook:
    """Option, and the engine of that name: contacts found as in Bell's simulator, by samples and a binary search."""

    samples: int = quantity(
        64, "", "samples of the gap per period of z, that is half a base cycle", low=2, high=100_000
    )


OPTIONS: dict[str, type] = {
    "scatter": Scatter,
    "spin": Spin,
    "friction": Friction,
    "softening": Softening,
    "curve": Curve,
    "frequencies": Frequencies,
    "ramp": Ramp,
    "sensing": Sensing,
    "camera": Camera,
    "textbook": Textbook,
}
"""All options, in the order in which kernels take their records."""
