"""The bar's motion in a base cycle, and the flight of a ball to its first contact with it, over all rows at once.

The contact is the first root of the gap g = z - z_bar + (x - x_bar) tan(tilt), by steps that no root can lie in: as
long as bounds of g'' and g''' allow.
"""

from __future__ import annotations

from typing import Any

import numpy as np

_RESOLUTION = 1e-16  # s: a step that is shorter has reached the root
_STEPS = 1000  # of a search, at most
_SAME = 1e-10  # part of a blend
_CLEAR = 1e-4  # s: a ball that the bar leaves behind is not looked at before
_PART = 0.25  # of the rows: when so many have finished they are no longer computed


class Bar:
    """The bar of each row in one base cycle: it goes from the motion `old` to `new`, phasors (3, 2, n) in m, rad, m."""

    def __init__(self, params: Any, old: Any, new: Any) -> None:
        """`params`: of the ball on a bar."""
        self.params, self.old, self.new, self.change = params, old, new, new - old
        self.omega = np.array([[1.0], [1.0], [2.0]]) * params.omega
        self.blend = params.blend * params.period

    def of(self, rows: Any) -> Bar:
        """The bar of some rows."""
        return Bar(self.params, self.old[..., rows], self.new[..., rows])

    def at(self, time: Any) -> tuple[Any, Any, Any]:
        """x, tilt and z, (3, n), and their first and second derivatives, at the times (n,) from the cycle's start."""
        c, s = np.cos(self.params.omega * time), np.sin(self.params.omega * time)
        cos, sin = np.stack([c, c, c * c - s * s]), np.stack([s, s, 2.0 * s * c])
        u = time / self.blend
        blending = u < 1.0 - _SAME
        u = np.where(blending, u, 1.0)
        s0 = u * u * (3.0 - 2.0 * u)
        s1 = 6.0 * u * (1.0 - u) / self.blend
        s2 = np.where(blending, (6.0 - 12.0 * u) / self.blend**2, 0.0)
        a, b = (self.change[:, i] for i in (0, 1))
        along, across = a * cos + b * sin, self.omega * (b * cos - a * sin)
        a, b = self.old[:, 0] + s0 * a, self.old[:, 1] + s0 * b
        value = a * cos + b * sin
        rate = self.omega * (b * cos - a * sin) + s1 * along
        return value, rate, 2.0 * s1 * across + s2 * along - self.omega**2 * value

    def bounds(self, time: Any) -> tuple[Any, Any, Any, Any]:
        """Of |x|, |tilt| and |z|, (3, n), and of three derivatives, from the times (n,) to the cycle's end."""
        w, blending = self.omega, time < self.blend
        size = np.hypot(self.new[:, 0], self.new[:, 1])
        change = np.where(blending, np.hypot(self.change[:, 0], self.change[:, 1]), 0.0)
        size = np.where(blending, np.maximum(size, np.hypot(self.old[:, 0], self.old[:, 1])), size)
        s1, s2, s3 = 1.5 / self.blend, 6.0 / self.blend**2, 12.0 / self.blend**3
        return (
            size,
            w * size + s1 * change,
            w * w * size + (2.0 * s1 * w + s2) * change,
            w**3 * size + (3.0 * s1 * w * w + 3.0 * s2 * w + s3) * change,
        )


def _limits(bar: Bar, time: Any, away: Any, u: Any, remaining: Any) -> tuple[Any, Any, Any]:
    """Bounds of |g''| and |g'''| over the rest of a flight, and the height (m) above which nothing touches the bar."""
    (x, t, z), (x_1, t_1, _), (x_2, t_2, z_2), (x_3, t_3, z_3) = bar.bounds(time)
    tan = np.tan(t)
    sec2 = 1.0 + tan * tan
    reach, speed = abs(away) + abs(u) * remaining + 2.0 * x, abs(u) + x_1
    turn, turning = t_1 * sec2, (t_2 + 2.0 * t_1 * t_1 * tan) * sec2
    rate = (t_3 + 6.0 * t_1 * t_2 * tan + 2.0 * t_1**3 * (sec2 + 2.0 * tan * tan)) * sec2
    second = bar.params.gravity + z_2 + x_2 * tan + 2.0 * speed * turn + reach * turning
    third = z_3 + x_3 * tan + 3.0 * (x_2 * turn + speed * turning) + reach * rate
    return second, third, z + reach * tan


def _free(value: Any, slope: Any, curvature: Any) -> Any:
    """Where value + slope h - curvature h^2 / 2 becomes 0."""
    root = np.sqrt(slope * slope + 2.0 * curvature * value)
    return np.where(slope > 0.0, (slope + root) / curvature, 2.0 * value / (root - slope))


def _step(value: Any, slope: Any, second: Any, curvature: Any, jerk: Any) -> Any:
    """A time within which g, with these values and bounds of |g''| and |g'''|, has no root."""
    falling = second < 0.0
    ahead = np.where(slope < 0.0, -value / slope, _free(value, slope, -second))  # no root lies further
    step = _free(value, slope, np.where(falling, np.minimum(curvature, jerk * ahead - second), curvature))
    rising = 1.5 / jerk * (second + np.sqrt(second * second + 8.0 / 3.0 * jerk * slope))
    convex = np.where(slope >= 0.0, rising, np.minimum(second / jerk, ahead))
    return np.where(falling, step, np.maximum(step, convex))


@np.errstate(divide="ignore", invalid="ignore")
def fly(bar: Bar, begin: Any, x: Any, z: Any, u: Any, w: Any, opening: Any, released: Any) -> tuple[Any, Any]:
    """First contacts of balls in flight from the times `begin`: (whether before the cycle's end, durations).

    `opening`: rate of the gap of a ball that leaves the bar, 0 in flight; `released`: it leaves the bar at rest.
    """
    p, rows = bar.params, np.arange(begin.size)
    curvature, jerk, level = _limits(bar, begin, x - bar.at(begin)[0][0], u, p.period - begin)
    high = np.sqrt(np.maximum(0.0, w * w + 2.0 * p.gravity * (z - level)))
    from_above, below = (w - high) / p.gravity, (w + high) / p.gravity  # clear of the bar between these times
    columns = np.stack([begin, x, z, u, w, curvature, jerk, from_above, below])
    hit, duration = np.zeros(rows.size, np.bool_), p.period - begin
    ds = np.where(released, _CLEAR, 2.0 * opening / curvature)
    for _ in range(_STEPS):
        begin, x, z, u, w, curvature, jerk, from_above, below = columns
        ds = np.where((ds >= from_above) & (ds < below), below, ds)
        time = begin + ds
        gone = time >= p.period
        (xb, tilt, zb), (xb_1, turn, zb_1), (xb_2, tilt_2, zb_2) = bar.at(time)
        tan = np.tan(tilt)
        sec2 = 1.0 + tan * tan
        away, speed = x + u * ds - xb, u - xb_1
        value = z + (w - 0.5 * p.gravity * ds) * ds - zb + away * tan
        slope = w - p.gravity * ds - zb_1 + speed * tan + away * turn * sec2
        second = -p.gravity - zb_2 - xb_2 * tan
        second += (2.0 * speed * turn + away * (tilt_2 + 2.0 * turn * turn * tan)) * sec2
        step = _step(value, slope, second, curvature, jerk)
        met = ~gone & ((value <= 0.0) | (step < _RESOLUTION))
        hit[rows[met]], duration[rows[met]] = True, ds[met]
        done = gone | met
        count = np.count_nonzero(done)
        if count == done.size:
            break
        left = bar.blend * (1.0 - _SAME) - time
        step = np.where(left > 0.0, np.minimum(step, left + _SAME * bar.blend), step)  # there g'' jumps
        ds = np.where(done, ds, ds + step)
        if count > _PART * done.size:
            keep = np.flatnonzero(~done)
            bar, rows, ds, columns = bar.of(keep), rows[keep], ds[keep], columns[:, keep]
    return hit, duration
