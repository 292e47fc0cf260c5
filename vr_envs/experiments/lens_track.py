"""A ball that bounces on one of Bell's lenses, as the camera with the mirror saw it, and what its track shows."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from vr_envs.experiments.lens_orbit import from_apex, lens_strength, period_one_start, travel_frequency
from vr_envs.experiments.lens_simulation import Run, simulate
from vr_envs.experiments.vision_rig import Rig, locate
from vr_envs.models.ball_on_lens import Params, plano_concave
from vr_envs.models.ball_options import Spin
from vr_envs.models.lens_flight import surface_height

RATE = 2000.0 / 3.0  # Hz, images of the ball per second: 2000 Hz over three regions (Bell, section III)
FOCAL_LENGTHS = (0.15, 0.20)  # m, of Bell's lenses
FREQUENCIES = (20.0, 30.0)  # Hz
LONG = 0.008  # m, the larger half axis of the ellipse on which the ball travels


@dataclasses.dataclass(frozen=True)
class Track:
    """A `run`, and at `times` (n,) s the ball's true and `seen` places, (n, 3), m."""

    run: Run
    times: np.ndarray
    true: np.ndarray
    seen: np.ndarray


def scene(focal_length: float, frequency: float) -> Params:
    """One of Bell's lenses (m) at a frequency (Hz): plano-concave BK7 glass, radius of curvature f (n - 1)."""
    return from_apex(Params(frequency=frequency, curvature=plano_concave(focal_length)))


def elliptic(params: Params, size: float, cycles: int, spin: Spin | None = None) -> Run:
    """A run that starts on an ellipse with half axes `size` and half of it, m."""
    speed = math.pi * size * travel_frequency(params, spin)
    return simulate(params, period_one_start(params, x=size, v=speed), cycles, spin)


def tracked(run: Run, rig: Rig, key: int) -> Track:
    """The run as the camera saw it: calibrated with noise, both images of the ball exposed together."""
    times = np.arange(int(float(run.end["cycles"]) * run.params.period * RATE)) / RATE
    true = run.position(times)
    views = tuple(calibration.view for calibration in rig.calibrated(key))
    seen = locate((views[0], views[1]), rig.ball_images(true, 0, key + 2), rig.ball_images(true, 1, key + 3))
    return Track(run, times, true, seen[:, :3])


def line_frequency(times: np.ndarray, places: np.ndarray) -> float:
    """Frequency (Hz) of the highest line in the power spectrum of columns of `places` (n, k), sampled evenly."""
    size = 1 << 18
    window = np.hanning(len(times))[:, None]
    power = np.sum(np.abs(np.fft.rfft(window * (places - places.mean(axis=0)), size, axis=0)) ** 2, axis=1)
    top = int(np.argmax(power))
    low, mid, high = np.log(power[top - 1 : top + 2])
    return (top + 0.5 * (low - high) / (low - 2.0 * mid + high)) / (size * (times[1] - times[0]))


def recursion(run: Run) -> tuple[float, float]:
    """Size and angle (rad) of the pair of eigenvalues in x'' = 2 size cos(angle) x' - size^2 x over the impacts."""
    first, middle, last = (
        np.concatenate([run.impacts[name][k : len(run.cycle) - 2 + k] for name in "xy"]) for k in range(3)
    )
    (trace, minus), *_ = np.linalg.lstsq(np.column_stack([middle, first]), last, rcond=None)
    return math.sqrt(-minus), math.acos(0.5 * trace / math.sqrt(-minus))


def invariant(run: Run) -> np.ndarray:
    """What a frictionless ball keeps to first order, at impacts 1, 2, ...: beta r^2 - beta r . d + d^2, m^2.

    r is the place and d the step from the last impact, T u; the form that the linear map leaves as it is.
    """
    beta = lens_strength(run.params)
    place = np.column_stack([run.impacts["x"], run.impacts["y"]])
    step, here = np.diff(place, axis=0), place[1:]
    return np.sum(beta * here**2 - beta * here * step + step**2, axis=1)


def adjusted(params: Params, places: np.ndarray) -> np.ndarray:
    """Heights (n,) of places (n, 3) less that of the lens under them: Bell's height adjustment."""
    distances = np.hypot(places[:, 0], places[:, 1])
    return places[:, 2] - np.array([surface_height(d, params.path_curvature) for d in distances])


def true_apexes(run: Run) -> np.ndarray:
    """(n, 3) highest points of the flights that the impacts begin, m."""
    i, up = run.impacts, run.impacts["w"] / run.params.gravity
    return np.column_stack([i["x"] + i["u"] * up, i["y"] + i["v"] * up, i["z"] + 0.5 * i["w"] * up])


def fitted_apexes(track: Track, heights: np.ndarray) -> tuple[np.ndarray, float]:
    """Highest points (m) of parabolas through `heights`, one for each flight between two impacts.

    The samples next to an impact are left out, because they may be of either flight.

    Returns:
        (n - 1,) the highest points, and the mean factor by which their standard deviation is below that of a sample.
    """
    apexes, factors = [], []
    for start, stop in zip(track.run.times[:-1], track.run.times[1:], strict=True):
        rows = (track.times > start + 1.0 / RATE) & (track.times < stop - 1.0 / RATE)
        t = (track.times[rows] - 0.5 * (start + stop)) / (stop - start)
        basis = np.vander(t, 3)
        (a, b, c), *_ = np.linalg.lstsq(basis, heights[rows], rcond=None)
        apexes.append(c - 0.25 * b * b / a)
        top = np.array([0.25 * b * b / (a * a), -0.5 * b / a, 1.0])  # derivative of the highest point by a, b, c
        factors.append(math.sqrt(top @ np.linalg.solve(basis.T @ basis, top)))
    return np.array(apexes), float(np.mean(factors))
