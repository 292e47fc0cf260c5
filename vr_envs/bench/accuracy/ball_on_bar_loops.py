"""Compiled loops over an episode of the ball: the exact model, and what equal steps make of the same equations.

The steps are the fair opponent: as compiled as the exact model, with the exact parabola and the exact motion of the bar
at the end of each step. A ball below the surface then has had its impact
- `AT_END`: at the end of the step, put back on the surface there (what game engines do, without their solver): a fixed
  step;
- `CHORD`: where the straight line between the gaps at the step's ends is zero; the step is split there;
- `ROOT`: where the gap is zero, to rounding; the step is split there.
The last two are event-driven methods, without a guarantee that no contact is missed between two steps.
An impact that the ball leaves by less than it falls in a few steps puts it on the bar. The bar's motion is written here
from its definition, apart from the exact model's.
"""

from __future__ import annotations

import math

import numpy as np

from vr_envs.models.ball_on_bar import advance
from vr_envs.models.jit import kernel

AT_END, CHORD, ROOT = 0, 1, 2
FEW = 4.0  # steps
MOST = 64  # impacts in one step
KEPT = 1000  # impacts of one base cycle in the exact model's log
SEARCH = 100  # steps of a search for a root
EPSILON = 2.0**-53


@kernel
def exact(states, actions, params, options, log, impacts, ends, repeats):
    """The exact model over the episode, `repeats` times; returns the number of impacts. Columns as in `Track`."""
    first = states.copy()
    count = 0
    for _ in range(repeats):
        states[0] = first[0]
        state = states[0]
        count = 0
        for k in range(len(actions)):
            before = state.impacts
            advance(state, actions[k], params, *options, log)
            for i in range(before, state.impacts):
                row = log[i % len(log)]
                impacts[count % len(impacts)] = float(k), row[0], row[3]
                count += 1
            state.steps += 1
            ends[k] = state.x, state.z, state.u, state.w
    states[0] = first[0]
    return count


@kernel
def phasors(old, new, s, blend):
    """The six phasors at time s of the cycle, and their rates: from `old` to `new` by u^2 (3 - 2u), u = s / blend."""
    if s >= blend:
        return new, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    u = s / blend
    a, b = u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u) / blend
    o, n = old, new
    d = (n[0] - o[0], n[1] - o[1], n[2] - o[2], n[3] - o[3], n[4] - o[4], n[5] - o[5])
    return (
        (o[0] + a * d[0], o[1] + a * d[1], o[2] + a * d[2], o[3] + a * d[3], o[4] + a * d[4], o[5] + a * d[5]),
        (b * d[0], b * d[1], b * d[2], b * d[3], b * d[4], b * d[5]),
    )


@kernel
def bar(old, new, s, omega, blend):
    """x, tilt and z of the bar (m, rad, m) and their rates, at time s of the cycle in which it goes to `new`."""
    p, r = phasors(old, new, s, blend)
    c, n = math.cos(omega * s), math.sin(omega * s)
    c2, n2 = c * c - n * n, 2.0 * c * n
    return (
        p[0] * c + p[1] * n,
        p[2] * c + p[3] * n,
        p[4] * c2 + p[5] * n2,
        r[0] * c + r[1] * n + omega * (p[1] * c - p[0] * n),
        r[2] * c + r[3] * n + omega * (p[3] * c - p[2] * n),
        r[4] * c2 + r[5] * n2 + 2.0 * omega * (p[5] * c2 - p[4] * n2),
    )


@kernel
def gap(old, new, s, omega, blend, x, z):
    """Distance of the ball from the surface along the bar's normal, at time s of the cycle."""
    bx, tilt, bz, _, _, _ = bar(old, new, s, omega, blend)
    if tilt == 0.0:
        return z - bz
    return (x - bx) * math.sin(tilt) + (z - bz) * math.cos(tilt)


@kernel
def collided(old, new, s, omega, blend, x, z, u, w, restitution, loss, least):
    """The ball on the surface after an impact: x, z, u, w, approach velocity, whether it rests.

    It rests, that is moves with the bar along the normal, if it would leave at less than `least`.
    """
    bx, tilt, bz, vx, turn, vz = bar(old, new, s, omega, blend)
    sin, cos = math.sin(tilt), math.cos(tilt)
    under = (x - bx) * sin + (z - bz) * cos
    x, z = x - under * sin, z - under * cos
    ru, rw = u - vx - turn * (z - bz), w - vz + turn * (x - bx)
    normal, tangent = ru * sin + rw * cos, ru * cos - rw * sin
    if normal >= 0.0:
        return x, z, u, w, normal, False
    rests = -restitution * normal < least
    dn = -normal if rests else -(1.0 + restitution) * normal
    dt = -loss * tangent
    return x, z, u + dn * sin + dt * cos, w + dn * cos - dt * sin, normal, rests


@kernel
def located(old, new, s, ds, omega, blend, x, z, u, w, gravity, bounced, before, after):
    """Time after s at which the gap, `before` at s and `after` < 0 at s + ds, is zero, to rounding.

    A ball that has just `bounced` begins on the surface: its first bracket is where a parabola would be half over.
    """
    low, high, g_low, g_high = 0.0, ds, before, after
    if bounced:
        g_low = -1.0
        low = ds
        for _ in range(SEARCH):
            low *= 0.5
            g_low = gap(old, new, s + low, omega, blend, x + u * low, z + (w - 0.5 * gravity * low) * low)
            if g_low > 0.0:
                break
            high, g_high = low, g_low
        if g_low <= 0.0:
            return high
    for k in range(SEARCH):
        # the Illinois rule, and a bisection now and then
        middle = low + (high - low) * g_low / (g_low - g_high) if k % 8 != 7 else 0.5 * (low + high)
        value = gap(old, new, s + middle, omega, blend, x + u * middle, z + (w - 0.5 * gravity * middle) * middle)
        if value == 0.0:
            return middle
        if value > 0.0:
            if high - middle <= 2.0 * EPSILON * (s + high):
                return middle
            g_high *= 0.5
            low, g_low = middle, value
        else:
            if middle - low <= 2.0 * EPSILON * (s + high):
                return middle
            g_low *= 0.5
            high, g_high = middle, value
    return high


@kernel
def fixed_step(start, motions, params, steps, location, slowest, impacts, ends, repeats):
    """The episode in `steps` equal steps a base cycle, `repeats` times; returns the number of impacts.

    Args:
        start: x, z, u, w.
        motions: see `Episode.motions`.
        params: record.
        steps: a base cycle.
        location: `AT_END`, `CHORD` or `ROOT`.
        slowest: m/s, impacts that are slower are not listed.
        impacts, ends: as in `Track`; filled.
        repeats: how often.
    """
    omega, gravity, period = params.omega, params.gravity, params.period
    blend, h = params.blend * period, period / steps
    least = FEW * gravity * h
    count = 0
    for _ in range(repeats):
        count = 0
        x, z, u, w = start
        for k in range(len(ends)):
            m, n = motions[k], motions[k + 1]
            old, new = (m[0], m[1], m[2], m[3], m[4], m[5]), (n[0], n[1], n[2], n[3], n[4], n[5])
            before, bounced = gap(old, new, 0.0, omega, blend, x, z), False
            for j in range(steps):
                s, end = j * h, (j + 1) * h
                for _ in range(MOST):
                    ds = end - s
                    nx, nz = x + u * ds, z + (w - 0.5 * gravity * ds) * ds
                    after = gap(old, new, end, omega, blend, nx, nz)
                    if after >= 0.0:
                        x, z, w = nx, nz, w - gravity * ds
                        before, bounced = after, False
                        break
                    if location == ROOT and (before > 0.0 or bounced):
                        ds = located(old, new, s, ds, omega, blend, x, z, u, w, gravity, bounced, before, after)
                    elif location == CHORD and before > 0.0 and not bounced:
                        ds *= before / (before - after)
                    s = min(s + ds, end)
                    x, z, w = x + u * ds, z + (w - 0.5 * gravity * ds) * ds, w - gravity * ds
                    x, z, u, w, normal, rests = collided(
                        old, new, s, omega, blend, x, z, u, w, params.restitution, params.tangential_loss, least
                    )
                    before, bounced = 0.0, not rests
                    if normal < -slowest:
                        impacts[count % len(impacts)] = float(k), s, normal
                        count += 1
                    if s >= end:
                        break
            ends[k] = x, z, u, w
    return count


@kernel
def bar_track(motions, params, steps):
    """Place (x, z) and tilt of the bar at the ends of `steps` equal steps a base cycle, from the start on.

    For simulators that are told where the bar is: shape (cycles * steps + 1, 3).
    """
    omega, period = params.omega, params.period
    cycles = len(motions) - 1
    track = np.empty((cycles * steps + 1, 3))
    for k in range(cycles):
        m, n = motions[k], motions[k + 1]
        old, new = (m[0], m[1], m[2], m[3], m[4], m[5]), (n[0], n[1], n[2], n[3], n[4], n[5])
        for j in range(steps + 1):
            x, tilt, z, _, _, _ = bar(old, new, j * period / steps, omega, params.blend * period)
            track[k * steps + j] = x, z, tilt
    return track
