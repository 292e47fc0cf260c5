"""Impact of a ball on a massive surface (Wang and Mason 1992; central impact, so normal and tangent decouple).

Velocities are relative to the bar's material at the contact point, in the surface's normal and tangent.
"""

from __future__ import annotations

import math

from vr_envs.models.jit import kernel
from vr_envs.models.phasor import cos_sin


@kernel
def softened(restitution, normal, softening):
    """Restitution at the approach velocity `normal` (m/s): alpha (1 + |normal| / speed)^-exponent."""
    if softening is None:
        return restitution
    else:
        return restitution * (1.0 + abs(normal) / softening.speed) ** -softening.exponent


@kernel
def collide(normal, tangent, surface_spin, restitution, loss, spin, friction):
    """Velocities after an impact.

    Args:
        normal: approach velocity along the outward normal, m/s, negative.
        tangent: tangential velocity of the ball's centre, m/s.
        surface_spin: R (spin - bar rate), m/s, the velocity that the spin takes from the contact slip.
        restitution: alpha in [0, 1]: normal velocity is reversed and multiplied by alpha.
        loss: c in [0, 1]: part of the tangential velocity lost; used when `spin` is None.
        spin: None, or a record with `inertia_ratio` I/(m R^2) of a ball that grips: the impulse stops the slip.
        friction: None, or a record: the tangential impulse reverses the slip times `restitution`, but is at most
            `coefficient` times the normal impulse (Coulomb).

    Returns:
        (normal, tangent, surface_spin) after the impact.
    """
    if spin is None:
        slip, share = tangent, loss
    else:
        slip, share = tangent - surface_spin, spin.inertia_ratio / (1.0 + spin.inertia_ratio)  # 2/7: a solid sphere
    if friction is None:
        stopped = slip
    else:
        stopped = (1.0 + friction.restitution) * slip
        largest = friction.coefficient * (1.0 + restitution) * abs(normal)
        if share * abs(stopped) > largest:
            stopped = math.copysign(largest / share, slip)
    if spin is not None:
        surface_spin += (1.0 - share) * stopped
    return -restitution * normal, tangent - share * stopped, surface_spin


@kernel
def collide_rough(normal, tangent, surface_spin, restitution, loss, spin, friction, deviation):
    """`collide` on a surface whose normal deviates by an angle (rad) from the smooth one.

    A grazing ball that the deviated surface would not stop, or would throw into the smooth one, meets the
    smooth surface instead: the ball always leaves.
    """
    cos, sin = cos_sin(deviation)
    n, t = normal * cos + tangent * sin, tangent * cos - normal * sin
    if n < 0.0:
        n, t, rolled = collide(n, t, surface_spin, restitution, loss, spin, friction)
        out = n * cos - t * sin
        if out > 0.0:
            return out, t * cos + n * sin, rolled
    return collide(normal, tangent, surface_spin, restitution, loss, spin, friction)
