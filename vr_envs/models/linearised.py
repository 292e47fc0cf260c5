"""Derivative of the exact cycle map of the ball on a bar, and the periodic orbit of a constant motion of the bar.

The section is the start of a base cycle, with the ball in flight. The map takes the ball's state y = (x, u, z, w, and
spin where the ball has one) and two motions of the bar, the present one and the one it goes to, to the state one base
cycle later. It is exact to rounding, so central differences with two Richardson steps give its derivative to ten
digits. Period one is the motion with one impact in each cycle of z (Bell, sections III and IV): two in a base cycle.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from vr_envs.models.ball_on_bar import LOGGED, OPTIONS, State, cycle
from vr_envs.models.jit import kernel
from vr_envs.models.record import dtype_of

RANDOM = ("scatter",)
"""Options that make the map a random one: it has no derivative."""

PERIOD_ONE = 2  # impacts in a base cycle
STEP = 1e-2  # of the coarsest difference, in units of `CycleMap.scales`
HALVINGS = 12  # of that step, until no perturbed ball has another number of impacts
NEWTON_STEPS = 40
RESIDUAL = 1e-12  # of a periodic orbit, in units of `CycleMap.scales`
NEUTRAL = 1e-10  # singular values of I - A below this, relative to the largest, belong to a neutral direction


def smooth(options: Sequence[np.void | None]) -> tuple[np.void | None, ...]:
    """`options` (records in the order of `OPTIONS`) without those that are random."""
    return tuple(None if name in RANDOM else o for name, o in zip(OPTIONS, options, strict=True))


@kernel
def _images(states, motions, params, options, logs):
    """Move ball i by one base cycle while its bar goes to the motion in row i; its impacts go to `logs[i]`."""
    for i in range(states.shape[0]):
        new = (motions[i, 0], motions[i, 1], motions[i, 2], motions[i, 3], motions[i, 4], motions[i, 5])
        cycle(states[i], new, params, *options, logs[i])


@dataclasses.dataclass(frozen=True)
class Linearised:
    """The cycle map at one point and its derivatives, SI units; n coordinates of the ball.

    `image` (n,): the state one cycle later. `state` (n, n), `old` (n, 6), `new` (n, 6): its derivative with respect to
    the state, the present motion and the motion the bar goes to. `error`: estimated largest error of a derivative
    in the natural units of `CycleMap.scales`. `times` (k,): the impacts, s after the start of the cycle.
    """

    image: np.ndarray
    state: np.ndarray
    old: np.ndarray
    new: np.ndarray
    error: float
    times: np.ndarray


@dataclasses.dataclass(frozen=True)
class Orbit:
    """A periodic orbit: the state `ball` (n,) at the start of every cycle, and the map at it."""

    ball: np.ndarray
    motion: np.ndarray
    map: Linearised

    @property
    def constant(self) -> np.ndarray:
        """Derivative of the image with respect to a motion that was and stays: (n, 6)."""
        return self.map.old + self.map.new


class CycleMap:
    """The map of the ball over one base cycle, for one bar and ball.

    `coordinates`: names of the state's coordinates. `scales` (n + 12,): natural units of the state and of the two
    motions; lengths are g/(2 omega)^2, velocities g/(2 omega), tilts 1/4.
    """

    def __init__(self, params: np.void, options: Sequence[np.void | None]) -> None:
        """`params`: record of `Params`; `options`: a record or None for each of `OPTIONS`, without scatter.

        Raises:
            ValueError: an option makes the map random.
        """
        for name, option in zip(OPTIONS, options, strict=True):
            if name in RANDOM and option is not None:
                raise ValueError(f"the option {name!r} makes the cycle map random; give None for it (see `smooth`)")
        self.params, self.options = params, tuple(options)
        spins = self.options[list(OPTIONS).index("spin")] is not None
        self.coordinates = ("x", "u", "z", "w", "spin") if spins else ("x", "u", "z", "w")
        speed = float(params["gravity"] / (2.0 * params["omega"]))
        length = speed / (2.0 * float(params["omega"]))
        ball = [length if name in ("x", "z") else speed for name in self.coordinates]
        motion = [length, length, 0.25, 0.25, length, length]
        self.scales = np.array([*ball, *motion, *motion])

    def _run(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(images (k, n), impacts (k,), logs (k, PERIOD_ONE + 2, columns)) of points (k, n + 12); NaN where lost."""
        n = len(self.coordinates)
        states = np.zeros(len(points), dtype_of(State))
        for name, column in zip(self.coordinates, points.T[:n], strict=True):
            states[name] = column
        states["motion"] = points[:, n : n + 6]
        logs = np.zeros((len(points), PERIOD_ONE + 2, len(LOGGED)))
        _images(states, np.ascontiguousarray(points[:, n + 6 :]), self.params, self.options, logs)
        images = np.stack([states[name] for name in self.coordinates], axis=1)
        images[(states["lost"] + states["fault"] + states["resting"]) > 0] = np.nan
        return images, states["impacts"], logs

    def derivative(self, ball: np.ndarray, old: np.ndarray, new: np.ndarray) -> Linearised:
        """The map and its derivatives at the state `ball` (n,), from the motion `old` (6,) to `new` (6,).

        Raises:
            ValueError: the ball rests, is lost, or meets the bar at the start or end of the cycle, where the number
                of impacts in the cycle changes and the map has no derivative.
        """
        n = len(self.coordinates)
        point = np.concatenate([ball, old, new])
        images, impacts, logs = self._run(point[None])
        if not np.isfinite(images).all():
            raise ValueError("the ball comes to rest on the bar or leaves it within the cycle; no derivative exists")
        step = STEP
        for _ in range(HALVINGS):
            sides = np.concatenate(
                [sign * size * np.diag(step * self.scales) for size in (1.0, 0.5, 0.25) for sign in (1.0, -1.0)]
            )
            found, counts, _ = self._run(point + sides)
            if (counts == impacts[0]).all() and np.isfinite(found).all():
                break
            step *= 0.5
        else:
            raise ValueError("the ball meets the bar at the start of the cycle: the map has no derivative there")
        pairs = found.reshape(3, 2, len(point), n)
        size = step * self.scales[:, None] * np.array([1.0, 0.5, 0.25])[:, None, None]
        d = (pairs[:, 0] - pairs[:, 1]) / (2.0 * size)
        first = (4.0 * d[1:] - d[:-1]) / 3.0
        second = (16.0 * first[1] - first[0]) / 15.0
        error = np.abs(second - first[1]) * self.scales[:, None] / self.scales[:n]
        # differences of numbers that are exact to one rounding
        noise = 2.0**-52 * np.abs(images[0]).max() / (0.25 * step * self.scales.min())
        jacobian = second.T
        return Linearised(
            image=images[0],
            state=jacobian[:, :n],
            old=jacobian[:, n : n + 6],
            new=jacobian[:, n + 6 :],
            error=float(max(error.max(), noise)),
            times=logs[0, : impacts[0], 0].copy(),
        )

    def period_one(self, motion: np.ndarray) -> np.ndarray:
        """The closed form of period one for a bar that moves up and down only: the state (n,) at the section.

        Impacts happen at the phase phi of z's sine with cos(phi) = pi g (1 - alpha)/(1 + alpha)/Acc, the launch
        velocity is g/2 times the period of z (Luck and Mehta 1993). The ball is at x = 0, at rest along x.

        Raises:
            ValueError: the peak acceleration is too small for the orbit to exist.
        """
        p = self.params
        w, gravity, alpha = 2.0 * float(p["omega"]), float(p["gravity"]), float(p["restitution"])
        size = math.hypot(motion[4], motion[5])
        needed = math.pi * gravity * (1.0 - alpha) / (1.0 + alpha)
        if size <= 0.0 or size * w * w < needed:
            raise ValueError(
                f"peak acceleration of z is {size * w * w:.4g} m/s^2; period one needs at least {needed:.4g} m/s^2 "
                f"at restitution {alpha:g}"
            )
        phase = math.acos(needed / (size * w * w))
        period = 2.0 * math.pi / w
        since = math.fmod((0.5 * math.pi - phase - math.atan2(motion[5], motion[4])) / w + 2.0 * period, period)
        launch = 0.5 * gravity * period
        ball = np.zeros(len(self.coordinates))
        ball[2] = size * math.sin(phase) + (launch - 0.5 * gravity * since) * since
        ball[3] = launch - gravity * since
        return ball

    def orbit(self, motion: np.ndarray) -> Orbit:
        """The period-one orbit of a constant motion (6,), by Newton from the closed form of the vertical motion.

        Along a neutral direction (a flat bar does not care where the ball is) the point nearest to the start is taken.

        Raises:
            ValueError: there is none, Newton does not find it, or what it finds is not period one.
        """
        motion = np.asarray(motion, float)
        ball = self.period_one(motion)
        n = len(ball)
        scales = self.scales[:n]
        for _ in range(NEWTON_STEPS):
            at = self.derivative(ball, motion, motion)
            residual = (at.image - ball) / scales
            matrix = np.eye(n) - at.state * scales / scales[:, None]
            step = np.linalg.lstsq(matrix, residual, rcond=NEUTRAL)[0]
            if np.abs(residual).max() < RESIDUAL or np.abs(step).max() < RESIDUAL:
                break
            ball = ball + step * scales
        else:
            raise ValueError(
                f"no periodic orbit found near period one: residual {np.abs(residual).max():.1e} after "
                f"{NEWTON_STEPS} Newton steps; take a smaller motion"
            )
        half = 0.5 * float(self.params["period"])
        if len(at.times) != PERIOD_ONE or abs(at.times[1] - at.times[0] - half) > 1e-6 * half:
            raise ValueError(f"the orbit found is not period one: impacts {at.times} s after the start of the cycle")
        return Orbit(ball, motion, at)
