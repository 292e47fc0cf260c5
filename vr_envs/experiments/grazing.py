"""First contacts of a million grazing launches: the model's certified search, and Bell's sampled one, against brackets.

A ball leaves a bar that moves up and down only, at a random phase, a little faster than the bar: it soon grazes the
crest, or just clears it. A first contact that a search finds late, by more than rounding explains, has been missed: the
ball went through the bar. One that it finds early is false. What is right is `contact_search.py`.

Rounding: the gap is a difference of terms whose sizes add up to `scale`, so it is known to some machine epsilons of
it, `ROUNDING` in all; over its rate that is a time. A launch whose gap has a minimum nearer to zero than that cannot be
decided in double precision, it is `ambiguous`, and counted apart.
"""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

import numpy as np

from vr_envs.experiments.bounce import launches, z_omega
from vr_envs.experiments.contact_search import CONTACT, first_contacts
from vr_envs.experiments.experiment import Finding, Outcome, Progress
from vr_envs.experiments.look import BALL, BAR, FORMULA, FOUND, label, plain_log, shared_legend
from vr_envs.models.ball_on_bar import Params
from vr_envs.models.ball_options import Textbook
from vr_envs.models.bar import Piece, bounds, frame_at
from vr_envs.models.flight import AIRBORNE, flight
from vr_envs.models.jit import kernel
from vr_envs.models.record import pack
from vr_envs.models.root import UNDECIDED

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LAUNCHES, CHUNK = 1_000_000, 20_000
ACCELERATIONS = (5.0, 100.0)  # m/s^2, peak
SPEEDS = (1e-4, 1.0)  # m/s, of the ball over the bar
TICKS = ((5.0, 10.0, 20.0, 50.0, 100.0), (1e-4, 1e-3, 1e-2, 0.1, 1.0))  # of the two axes of the picture
SAMPLES = (8, 16, 32, 64)  # per period of z
SEARCHES = ("exact", *(f"textbook {n}" for n in SAMPLES))
BAR_AND_BALL = Params()
BINS = 20
ROUNDING = 16.0  # machine epsilons of the terms' sizes


@dataclasses.dataclass(frozen=True)
class Grazes:
    """Launches and what became of them; n of them, and one row of the arrays (searches, n) per name in `SEARCHES`."""

    accelerations: np.ndarray  # (n,) m/s^2
    speeds: np.ndarray  # (n,) m/s
    ambiguous: np.ndarray  # (n,) bool
    late: np.ndarray  # (searches, n) bool: missed
    early: np.ndarray  # (searches, n) bool: false
    error: np.ndarray  # (searches, n) s, of the time of contact
    rounding: np.ndarray  # (searches, n) error of the gap there, machine epsilons of `CONTACT.scale`


@kernel
def contacts_found(motions, heights, velocities, params, textbook, times):
    """Times (n,) of first contact that the model's `flight` finds, nan where its search does not end.

    As in the model, a flight that outlasts a base cycle goes on in the next with time at zero again.
    """
    for i in range(motions.shape[0]):
        m = motions[i]
        motion = (m[0], m[1], m[2], m[3], m[4], m[5])
        piece = Piece(params.omega, 0.0, 0.0, motion, motion, None, (0.0, 0.0, 0.0), None)
        limits, frame, period = bounds(piece), frame_at(piece, 0.0), params.period
        z, w, cycle = heights[i], velocities[i], 0
        while True:
            hit, ds = flight(
                piece, limits, 0.0, 0.0, frame, period, 0.0, z, 0.0, w, params.gravity, AIRBORNE, None, textbook
            )
            if hit or ds == UNDECIDED:
                break
            z += (w - 0.5 * params.gravity * period) * period
            w -= params.gravity * period
            cycle += 1
        times[i] = cycle * period + ds if hit else math.nan


def graze(count: int, seed: int) -> Grazes:
    """Launch `count` balls and find their first contacts by every search.

    Raises:
        ArithmeticError: a search did not end.
    """
    rng = np.random.default_rng(seed)
    accelerations, speeds = (
        np.exp(rng.uniform(math.log(low), math.log(high), count)) for low, high in (ACCELERATIONS, SPEEDS)
    )
    motions, states = launches(BAR_AND_BALL, accelerations, rng.uniform(0.0, 2.0 * math.pi, count), speeds)
    truth = np.zeros(count, CONTACT)
    first_contacts(motions, states["w"], BAR_AND_BALL.gravity, z_omega(BAR_AND_BALL), truth)
    epsilon = np.finfo(float).eps
    blur = ROUNDING * epsilon * truth["scale"]
    times = np.empty((len(SEARCHES), count))
    for row, textbook in zip(times, (None, *(pack(Textbook(n)) for n in SAMPLES)), strict=True):
        contacts_found(motions, states["z"], states["w"], pack(BAR_AND_BALL), textbook, row)
    if np.isnan(times).any():
        raise ArithmeticError(f"{np.isnan(times).sum()} searches for a contact did not end")
    error = times - truth["time"]
    allowed = blur / np.abs(truth["slope"])
    return Grazes(
        accelerations,
        speeds,
        truth["closest"] <= blur,
        error > allowed,
        error < -allowed,
        error,
        np.abs(error * truth["slope"]) / (epsilon * truth["scale"]),
    )


def grazing(progress: Progress) -> Outcome:
    """All launches, chunk by chunk."""
    edges = np.geomspace(*ACCELERATIONS, BINS + 1), np.geomspace(*SPEEDS, BINS + 1)
    total, missed = np.zeros((2, BINS), int), np.zeros((2, len(SEARCHES), BINS), int)
    ambiguous, early, below = 0, np.zeros(len(SEARCHES), int), np.zeros(len(SEARCHES), int)
    worst, rounding = np.zeros(len(SEARCHES)), np.zeros(len(SEARCHES))
    for seed in progress(range(LAUNCHES // CHUNK), desc="launches"):
        found = graze(CHUNK, seed)
        decided = ~found.ambiguous
        ambiguous += int(found.ambiguous.sum())
        early += (found.early & decided).sum(1)
        below += (found.late & decided & (found.accelerations < BAR_AND_BALL.gravity)).sum(1)
        worst = np.maximum(worst, np.where(decided, np.abs(found.error), 0.0).max(1))
        near = decided & ~found.late & ~found.early
        rounding = np.maximum(rounding, np.where(near, found.rounding, 0.0).max(1))
        for k, values in enumerate((found.accelerations, found.speeds)):
            total[k] += np.histogram(values[decided], edges[k])[0]
            for j, late in enumerate(found.late):
                missed[k, j] += np.histogram(values[decided & late], edges[k])[0]
    misses = missed[0].sum(1)
    columns = {
        "search": np.array(SEARCHES),
        "launches": np.full(len(SEARCHES), LAUNCHES),
        "ambiguous": np.full(len(SEARCHES), ambiguous),
        "missed": misses,
        "false": early,
        "largest_time_error_s": worst,
        "largest_rounding_of_the_gap_eps": rounding,
    }
    tables = {"searches": columns}
    for name, unit, edge, all_, parts in zip(
        ("acceleration", "speed"), ("m/s^2", "m/s"), edges, total, missed, strict=True
    ):
        tables[name] = {f"{name}_from_{unit}": edge[:-1], f"{name}_to_{unit}": edge[1:], "launches": all_} | {
            f"missed_{search.replace(' ', '_')}": part for search, part in zip(SEARCHES, parts, strict=True)
        }
    shares = missed / np.maximum(total, 1)[:, None]
    return Outcome(
        _findings(misses, early, below, ambiguous, worst, rounding), tables, lambda f: _draw(f, edges, shares)
    )


def _findings(
    misses: np.ndarray, early: np.ndarray, below: np.ndarray, ambiguous: int, worst: np.ndarray, rounding: np.ndarray
) -> tuple[Finding, ...]:
    return (
        Finding(
            f"exact search, {LAUNCHES:,} launches at {ACCELERATIONS[0]:g} to {ACCELERATIONS[1]:g} m/s^2",
            "no first contact missed, none false",
            f"{misses[0]} missed, {early[0]} false; largest time error {worst[0]:.1e} s",
            bool(misses[0] == 0 and early[0] == 0),
        ),
        Finding(
            "its rounding of the gap",
            f"below {ROUNDING:g} machine epsilons of its terms",
            f"at most {rounding[0]:.1f}; {ambiguous} launches graze within that, and are not counted",
            bool(rounding[0] < ROUNDING),
        ),
        Finding(
            f"Bell's search, {', '.join(map(str, SAMPLES))} samples a period",
            "misses contacts, fewer with more samples",
            ", ".join(f"{n} ({n / LAUNCHES:.2%})" for n in misses[1:]) + f" missed; late by up to {worst[1]:.2g} s",
            bool((misses[1:] > 0).all() and (np.diff(misses[1:]) < 0).all()),
        ),
        Finding(
            "Bell's search below the acceleration of gravity",
            "none missed: the gap is concave, so it has one root",
            f"{below[1:].sum()} missed",
            bool((below == 0).all()),
        ),
    )


def _draw(figure: Figure, edges: tuple[np.ndarray, np.ndarray], shares: np.ndarray) -> None:
    """Missed share per bin of acceleration and of speed, percent."""
    figure.set_size_inches(9.0, 4.5)
    for k, (axes, x) in enumerate(
        zip(figure.subplots(1, 2, sharey=True), ("peak acceleration (m/s²)", "speed over the bar (m/s)"), strict=True)
    ):
        for share, search, colour in zip(
            shares[k][::-1], SEARCHES[::-1], (FOUND, BALL, BAR, "0.45", FORMULA), strict=True
        ):
            axes.stairs(100.0 * share, edges[k], color=colour, label=search if k == 0 else None)
        plain_log(axes, "x", TICKS[k])
        axes.set_yscale("symlog", linthresh=1e-3)
        label(axes, "", x, "first contacts missed (%)" if k == 0 else "")
        if k == 0:
            shared_legend(figure, *axes.get_legend_handles_labels())
