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

from vr_envs.models.ball_on_bar import LOGGED, State, interval
from vr_envs.models.ball_options import OPTIONS
from vr_envs.models.jit import kernel
from vr_envs.models.record import dtype_of

LEFT_OUT = ("scatter", "frequencies", "ramp", "sensing", "camera", "textbook")
"""Options without which the map is considered: it would be random, another one in each cycle, or sampled.

A sensor leaves the map as it is.
"""

STEP = 1e-2  # of the coarsest difference, in units of `CycleMap.scales`
HALVINGS = 12  # of that step, until no perturbed ball has another number of impacts
SIZES = np.array([1.0, 0.5, 0.25])  # of the three differences, relative to the coarsest
NEWTON_STEPS = 40
RESIDUAL = 1e-12  # of a periodic orbit, in units of `CycleMap.scales`
NEUTRAL = 1e-10  # singular values of I - A below this, relative to the largest, belong to a neutral direction
MOST_IMPACTS = 8  # of a cycle that are kept


def smooth(options: Sequence[np.void | None]) -> tuple[np.void | None, ...]:
    """`options` (records in the order of `OPTIONS`) without those that have no differentiable map of one cycle."""
    return tuple(None if name in LEFT_OUT else o for name, o in zip(OPTIONS, options, strict=True))


@kernel
def _images(states, motions, until, params, options, logs):
    """Move ball i to the time `until` (s) of a cycle in which its bar goes to the motion in row i; log in `logs[i]`."""
    for i in range(states.shape[0]):
        new = (motions[i, 0], motions[i, 1], motions[i, 2], motions[i, 3], motions[i, 4], motions[i, 5])
        interval(states[i], new, params, *options, logs[i], until)


@dataclasses.dataclass(frozen=True)
class Linearised:
    """The map at one point and its derivatives, SI units; n coordinates of the ball.

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
    """A periodic orbit: the state `ball` (n,) at the start of every cycle, the bar's motion (6,), the map at them.

    `growth`: ln|multiplier| / (2 pi) of the horizontal mode that grows fastest, the rate gamma of exp(gamma t) over the
    base angular frequency omega (Bell, Fig 4.1): positive at a source, negative at a sink.
    """

    ball: np.ndarray
    motion: np.ndarray
    map: Linearised
    growth: float


class CycleMap:
    """The map of the ball over one base cycle, for one bar and ball.

    `coordinates`: names of the state's coordinates. `scales` (n + 12,): natural units of the state and of the two
    motions; lengths are g/(2 omega)^2, velocities g/(2 omega), tilts 1/4.
    """

    def __init__(self, params: np.void, options: Sequence[np.void | None], state: type = State) -> None:
        """`params`: record of `Params` (`hold` does not matter); `options`: a record or None for each of `OPTIONS`.

        `state` is the record class of the ball, `State` or one derived from it whose kernels are compiled already.

        Raises:
            ValueError: an option with which there is no differentiable map of one cycle.
        """
        for name, option in zip(OPTIONS, options, strict=True):
            if name in LEFT_OUT and option is not None:
                raise ValueError(
                    f"no differentiable map of one cycle with the option {name!r}; give None (see `smooth`)"
                )
        self.params = params.copy()
        self.params["hold"] = 1.0
        self.options, self.record = tuple(options), dtype_of(state)
        spins = self.options[list(OPTIONS).index("spin")] is not None
        self.coordinates = ("x", "u", "z", "w", "spin") if spins else ("x", "u", "z", "w")
        self.horizontal = np.array([name not in ("z", "w") for name in self.coordinates])
        speed = float(params["gravity"] / (2.0 * params["omega"]))
        length = speed / (2.0 * float(params["omega"]))
        ball = [length if name in ("x", "z") else speed for name in self.coordinates]
        motion = [length, length, 0.25, 0.25, length, length]
        self.scales = np.array([*ball, *motion, *motion])

    def run(self, points: np.ndarray, until: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Images (k, n) of points (k, n + 12), NaN where the ball does not fly; impacts (k,); logs (k, capacity, .)."""
        n = len(self.coordinates)
        states = np.zeros(len(points), self.record)
        for name, column in zip(self.coordinates, points.T[:n], strict=True):
            states[name] = column
        states["motion"] = points[:, n : n + 6]
        logs = np.zeros((len(points), MOST_IMPACTS, len(LOGGED)))
        _images(states, np.ascontiguousarray(points[:, n + 6 :]), until, self.params, self.options, logs)
        images = np.stack([states[name] for name in self.coordinates], axis=1)
        images[(states["lost"] + states["fault"] + states["resting"]) > 0] = np.nan
        return images, states["impacts"], logs

    def derivative(self, ball: np.ndarray, old: np.ndarray, new: np.ndarray, until: float | None = None) -> Linearised:
        """The map and its derivatives at the state `ball` (n,), from the motion `old` (6,) to `new` (6,).

        `until`: time (s) in the cycle to which the map goes; None is its end.

        Raises:
            ValueError: the ball rests, is lost, or meets the bar at the start or end of the time, where the number
                of impacts changes and the map has no derivative.
        """
        n, end = len(self.coordinates), float(self.params["period"]) if until is None else until
        point = np.concatenate([ball, old, new])
        images, impacts, logs = self.run(point[None], end)
        if not np.isfinite(images).all():
            raise ValueError("the ball comes to rest on the bar or leaves it within the cycle: there is no derivative")
        step = STEP
        for _ in range(HALVINGS):
            sides = [sign * size * step * np.diag(self.scales) for size in SIZES for sign in (1.0, -1.0)]
            found, counts, _ = self.run(point + np.concatenate(sides), end)
            if (counts == impacts[0]).all() and np.isfinite(found).all():
                break
            step *= 0.5
        else:
            raise ValueError("the ball meets the bar at the start of the cycle: the map has no derivative there")
        pairs = found.reshape(len(SIZES), 2, len(point), n)
        d = (pairs[:, 0] - pairs[:, 1]) / (2.0 * step * SIZES[:, None, None] * self.scales[:, None])
        first = (4.0 * d[1:] - d[:-1]) / 3.0
        second = (16.0 * first[1] - first[0]) / 15.0
        natural = self.scales[:, None] / self.scales[:n]
        truncation = np.abs(second - first[1]) * natural
        rounding = np.finfo(float).eps * np.abs(images[0] / self.scales[:n]).max() / (SIZES[-1] * step)
        return Linearised(
            image=images[0],
            state=second.T[:, :n],
            old=second.T[:, n : n + 6],
            new=second.T[:, n + 6 :],
            error=float(max(truncation.max(), rounding)),
            times=logs[0, : min(impacts[0], MOST_IMPACTS), 0].copy(),
        )

    def period_one(self, motion: np.ndarray, m: int = 1, half: int = 0) -> np.ndarray:
        """The closed form of period one for a bar that moves up and down only: the state (n,) at the section.

        Impacts happen at the phase phi of z's sine with cos(phi) = m pi g (1 - alpha)/(1 + alpha)/Acc, the launch
        velocity is m g/2 times the period of z (Luck and Mehta 1993). The ball is at x = 0, at rest along x.

        Args:
            motion: the bar's, (6,).
            m: cycles of z in one flight: 1, two impacts in a base cycle, or 2, one impact.
            half: with m = 2, the impact is in the first (0) or second (1) half of the base cycle.

        Raises:
            ValueError: the peak acceleration is too small for the orbit to exist.
        """
        p = self.params
        w, gravity, alpha = 2.0 * float(p["omega"]), float(p["gravity"]), float(p["restitution"])
        size = math.hypot(motion[4], motion[5])
        needed = m * math.pi * gravity * (1.0 - alpha) / (1.0 + alpha)
        if size <= 0.0 or size * w * w < needed:
            raise ValueError(
                f"peak acceleration of z is {size * w * w:.4g} m/s^2; period one with m = {m} needs at least "
                f"{needed:.4g} m/s^2 at restitution {alpha:g}"
            )
        phase = math.acos(needed / (size * w * w))
        period = 2.0 * math.pi / w
        since = (0.5 * math.pi - phase - math.atan2(motion[5], motion[4])) / w % period
        if m == 2 and half == 0:
            since += period
        launch = 0.5 * m * gravity * period
        ball = np.zeros(len(self.coordinates))
        ball[2] = size * math.sin(phase) + (launch - 0.5 * gravity * since) * since
        ball[3] = launch - gravity * since
        return ball

    def _newton(self, ball: np.ndarray, motion: np.ndarray, until: float, mirror: np.ndarray) -> np.ndarray:
        """The state that comes back, mirrored by the signs `mirror`, at the time `until`."""
        n = len(ball)
        scales, step = self.scales[:n], np.zeros(n)
        for _ in range(NEWTON_STEPS):
            at = self.derivative(ball, motion, motion, until)
            residual = (mirror * at.image - ball) / scales
            matrix = np.eye(n) - mirror[:, None] * at.state * scales / scales[:, None]
            step = np.linalg.lstsq(matrix, residual, rcond=NEUTRAL)[0]
            ball = ball + step * scales
            if np.abs(step).max() < RESIDUAL:
                return ball
        raise ValueError(
            f"no periodic orbit near period one: after {NEWTON_STEPS} Newton steps the state still moves by "
            f"{np.abs(step).max():.1e} of its natural units; take a smaller motion"
        )

    def orbit(self, motion: np.ndarray, m: int = 1, half: int = 0) -> Orbit:
        """The period-one orbit of a constant motion (6,), by Newton from `period_one`, which has the arguments.

        With m = 1 the orbit repeats after half a base cycle as its own mirror image, as the bar does; Newton on that
        map is well conditioned even where the ball's place on the bar is neutral. With m = 2 it is the point nearest
        to the start along a neutral direction.

        Raises:
            ValueError: there is none, Newton does not find it, or what it finds is not period one.
        """
        motion = np.asarray(motion, float)
        period, signs = float(self.params["period"]), np.where(self.horizontal, -1.0, 1.0)
        start = self.period_one(motion, m, half)
        ball = self._newton(start, motion, 0.5 * m * period, signs if m == 1 else np.abs(signs))
        at = self.derivative(ball, motion, motion)
        flights = np.diff(np.append(at.times, at.times[:1] + period))
        off = np.abs((at.image - ball) / self.scales[: len(ball)]).max()
        if len(flights) * m != 2 or np.ptp(flights) > 1e-6 * period or off > 1e3 * RESIDUAL:
            raise ValueError(f"the orbit found is not period one: impacts {at.times} s after the start of the cycle")
        return Orbit(ball, motion, at, self._growth(at.state))

    def _growth(self, state: np.ndarray) -> float:
        """`Orbit.growth`: a mode is horizontal where x, u and spin take more part in it than z and w.

        Participation is the product of a mode's right and left eigenvector, which does not depend on units.
        """
        multipliers, modes = np.linalg.eig(state / self.scales[: len(state), None] * self.scales[: len(state)])
        part = np.abs(modes * np.linalg.pinv(modes).T)
        horizontal = part[self.horizontal].sum(axis=0) > part[~self.horizontal].sum(axis=0)
        return float(np.log(np.abs(multipliers[horizontal]).max()) / (2.0 * math.pi))
