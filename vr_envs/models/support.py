"""The force that supports a ball on the moving bar, and the acceleration of one that rolls or slides on it.

With the bar's axes of `surface.py`, p the place along the bar, kappa the curvature and
E_x = c'' . e_x - g sin(tilt), E_z = c'' . e_z + g cos(tilt) the specific force at the bar's centre,
    M = E_z - kappa p E_x + kappa p'^2 - 2 tilt' p' (1 + kappa^2 p^2) - tilt'' p (1 + kappa^2 p^2/2)
        + kappa p^2 tilt'^2 / 2
is the normal force per mass times `steepness`; for a ball in flight that touches the bar it is minus the second
derivative of the gap. Along the surface, with sigma the steepness, k = I/(m R^2) and
    X = E_x + kappa p E_z + kappa^2 p p'^2 - kappa p^2 tilt''/2 - tilt'^2 p (1 + kappa^2 p^2/2),
a gripping ball has (1 + k) sigma^2 p'' = -(X + k kappa^2 p p'^2 + k R sigma tilt''), a sliding one
sigma^2 p'' = -(X + mu M sign(slip)). All follow from Newton's law in the turning axes.
"""

from __future__ import annotations

from typing import NamedTuple

from vr_envs.models.jit import kernel
from vr_envs.models.surface import steepness


class Forces(NamedTuple):
    """What acts on a ball on the bar at one instant: specific force in the bar's axes, and the turning of the bar."""

    along: float  # E_x, m/s^2
    across: float  # E_z
    turn: float  # tilt', rad/s
    turning: float  # tilt''


@kernel
def forces_at(frame, gravity):
    """The `Forces` of a frame."""
    x, tilt, z, cos, sin = frame.x, frame.tilt, frame.z, frame.cos, frame.sin
    return Forces(x[2] * cos - z[2] * sin - gravity * sin, x[2] * sin + z[2] * cos + gravity * cos, tilt[1], tilt[2])


@kernel
def normal_force(forces, d, rate, curve):
    """M in m/s^2."""
    along, across, turn, turning = forces
    if curve is None:
        return across - 2.0 * rate * turn - d * turning
    else:
        k = curve.curvature
        k2d2 = k * d * k * d
        force = across - 2.0 * rate * turn * (1.0 + k2d2) - d * turning * (1.0 + 0.5 * k2d2)
        return force + k * (rate * rate - d * along + 0.5 * d * d * turn * turn)


@kernel
def _needed(forces, d, rate, curve):
    """X in m/s^2."""
    along, across, turn, turning = forces
    if curve is None:
        return along - turn * turn * d
    else:
        k = curve.curvature
        kd = k * d
        needed = along - turn * turn * d * (1.0 + 0.5 * kd * kd)
        return needed + kd * (across + k * rate * rate - 0.5 * d * turning)


@kernel
def gripping(forces, d, rate, inertia_ratio, radius, curve):
    """p'' (m/s^2) of a ball that rolls without slip; of a frictionless one, or in flight, with inertia_ratio 0."""
    sigma = steepness(d, curve)
    twist = inertia_ratio * radius * sigma * forces.turning
    if curve is not None:
        twist += inertia_ratio * curve.curvature * curve.curvature * d * rate * rate
    return -(_needed(forces, d, rate, curve) + twist) / ((1.0 + inertia_ratio) * sigma * sigma)


@kernel
def sliding(forces, d, rate, direction, coefficient, curve):
    """p'' (m/s^2) of a ball that slides with a slip of the sign `direction`."""
    sigma = steepness(d, curve)
    drag = direction * coefficient * normal_force(forces, d, rate, curve)
    return -(_needed(forces, d, rate, curve) + drag) / (sigma * sigma)


@kernel
def grip_force(forces, d, rate, inertia_ratio, radius, sticks, curve):
    """Tangential force per mass times `steepness` that keeps a ball from slipping, or where it is if it `sticks`."""
    if sticks:
        return _needed(forces, d, 0.0, curve)
    pull = gripping(forces, d, rate, inertia_ratio, radius, curve)
    sigma = steepness(d, curve)
    bent = sigma * sigma * pull
    if curve is not None:
        bent += curve.curvature * curve.curvature * d * rate * rate
    return -inertia_ratio * (bent + sigma * radius * forces.turning)


@kernel
def support(frame, gravity, d, rate, pull, curve):
    """M (m/s^2) on a ball at d with d' = `rate` and d'' = `pull`, and its time derivative."""
    forces = forces_at(frame, gravity)
    along, across, turn, turning = forces
    x, tilt, z, cos, sin = frame.x, frame.tilt, frame.z, frame.cos, frame.sin
    slope = x[3] * sin + z[3] * cos + turn * along
    slope -= 2.0 * pull * turn + 3.0 * rate * turning + d * tilt[3]
    if curve is not None:
        k = curve.curvature
        k2 = k * k
        along_1 = x[3] * cos - z[3] * sin - turn * across
        slope += k * (2.0 * rate * pull - rate * along - d * along_1 + d * rate * turn * turn + d * d * turn * turning)
        slope -= 2.0 * k2 * d * (d * (rate * turning + pull * turn) + 2.0 * rate * rate * turn)
        slope -= 0.5 * k2 * d * d * (d * tilt[3] + 3.0 * rate * turning)
    return normal_force(forces, d, rate, curve), slope


@kernel
def flight_support(frame, gravity, d, tangent, curve):
    """Minus the second and third derivative of the gap, for a ball that touches the bar in free flight.

    `tangent`: its tangential velocity (m/s). On a curve no force turns its path, as it would that of a
    ball which the bar supports.
    """
    rate = tangent / steepness(d, curve)
    pull = gripping(forces_at(frame, gravity), d, rate, 0.0, 0.0, curve)
    force, slope = support(frame, gravity, d, rate, pull, curve)
    if curve is not None:
        bent = curve.curvature / steepness(d, curve)
        slope += 2.0 * bent * bent * d * rate * force
    return force, slope


@kernel
def pull_bound(limits, gravity, reach, rate, arm, curve):
    """Bound on |p''| of a ball in flight or rolling, within `reach` of the bar's centre; `arm` is k R."""
    x, t, z = limits
    force = gravity + x.d2 + z.d2
    if curve is None:
        return force + reach * t.d1 * t.d1 + arm * t.d2
    else:
        k = abs(curve.curvature)
        kp = k * reach
        pull = force * (1.0 + kp) + 0.5 * kp * reach * t.d2 + t.d1 * t.d1 * reach * (1.0 + 0.5 * kp * kp)
        return pull + arm * (1.0 + kp) * t.d2 + k * kp * rate * rate


@kernel
def support_curvature(limits, gravity, d, rate, pull, arm, curve):
    """Bound on |M''|; `d`, `rate` and `pull` bound |p|, |p'| and |p''|, `arm` is k R; for a stuck ball rate = pull = 0.

    Each term of M is differentiated twice and its factors bounded; p''' is the derivative of the law that a ball
    in flight or rolling obeys.
    """
    x, t, z = limits
    c2, c3, c4 = x.d2 + z.d2, x.d3 + z.d3, x.d4 + z.d4
    force_1 = c3 + t.d1 * c2 + gravity * t.d1
    force_2 = c4 + 2.0 * t.d1 * c3 + t.d2 * c2 + t.d1 * t.d1 * c2 + gravity * (t.d2 + t.d1 * t.d1)
    jerk = force_1 + rate * t.d1 * t.d1 + 2.0 * d * t.d1 * t.d2 + arm * t.d3
    if pull == 0.0:
        jerk = 0.0
    if curve is None:
        return (
            force_2 + 2.0 * (jerk * t.d1 + 2.0 * pull * t.d2 + rate * t.d3) + pull * t.d2 + 2.0 * rate * t.d3 + d * t.d4
        )
    else:
        k = abs(curve.curvature)
        force, kp = gravity + c2, k * d
        grown = 1.0 + kp * kp
        if pull > 0.0:
            turned = arm * (k * kp * rate * t.d2 + (1.0 + kp) * t.d3)
            jerk = force_1 * (1.0 + kp) + k * (rate * force + d * rate * t.d2 + 0.5 * d * d * t.d3) + turned
            jerk += (2.0 * t.d1 * t.d2 * d + t.d1 * t.d1 * rate) * (1.0 + 1.5 * kp * kp)
            jerk += k * k * rate * (3.0 * d * pull + rate * rate * grown * 2.0) + 2.0 * k * kp * rate * pull
        g1, g2 = 2.0 * k * kp * rate, 2.0 * k * k * (rate * rate + d * pull)
        spun = t.d3 * rate * grown + t.d1 * jerk * grown + t.d1 * rate * g2
        spun += 2.0 * (t.d2 * pull * grown + t.d2 * rate * g1 + t.d1 * pull * g1)
        arc = t.d4 * d * grown + t.d2 * pull * grown + 0.5 * t.d2 * d * g2
        arc += 2.0 * t.d3 * rate * grown + t.d3 * d * g1 + t.d2 * rate * g1
        bent = pull * force + 2.0 * rate * force_1 + d * force_2 + 2.0 * (pull * pull + rate * jerk)
        bent += (rate * rate + d * pull) * t.d1 * t.d1 + 4.0 * d * rate * t.d1 * t.d2
        bent += d * d * (t.d2 * t.d2 + t.d1 * t.d3)
        bent += 2.0 * k * ((rate * rate + d * pull) * force + d * rate * force_1)  # see `flight_support`
        return force_2 + 2.0 * spun + arc + k * bent
