"""Equations 3.89 and 3.90 of the lecture: what its h stands for decides whether the step matters.

The recurrence  zeta' = zeta + v dt,  v' = k_d v - w2 (zeta' - h) dt  is linear. Over a sine r = Im(R e^{i W t}), with
z = e^{i W dt}, its steady motion is Im(H R e^{i W t}),

    A: h = r(t) - r(0)             H_A = w2 dt^2 z / ((z - 1)(z - k_d) + w2 dt^2 z) -> w2 / (w2 - W^2 + i gamma W)
    B: h = r(t) - r(t - dt)        H_B = H_A (1 - 1/z) -> i W dt H

where the limits are for dt -> 0: the first is the exact motion's, the second is nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vr_envs.experiments.experiment import Finding, Outcome, Progress
from vr_envs.experiments.look import BALL, BAR, FAINT, FORMULA, FOUND, label
from vr_envs.models.record import dtype_of, pack
from vr_envs.models.ride_options import Textbook
from vr_envs.models.terrain import WAVES, Undulation, start_undulation, undulation_ahead, wave
from vr_envs.models.terrain_ride import Params, State, advance, rest, suspension

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RATES = (30, 60, 120, 240, 480, 960)  # steps in a second
INTERVAL = 1.0 / 30.0  # s, between the samples: a whole number of every step
SETTLED, SAMPLES = 1800, 1800  # intervals; a start has faded by e^-26 after the first ones
KEY = 1
MID = np.zeros(2)  # damping and modulus at mid-range
SAME = 1e-9  # m, of heights that the formula and the recurrence give


class Ride(NamedTuple):
    """Heights of the mass (m, from where it rests) at the samples, and by the formula."""

    heights: np.ndarray
    formula: np.ndarray


def ridden(textbook: Textbook | None) -> tuple[Ride, np.ndarray]:
    """The ride over three sines by the recurrence, or exactly, and the height of the ground under it."""
    settings, undulation = Params(damping="absolute", dt=INTERVAL), pack(Undulation())
    params, state = pack(settings), np.zeros(1, dtype_of(State))[0]
    state["key"] = KEY
    start_undulation(state)
    rest(state, params, None)
    settings_record = None if textbook is None else pack(textbook)
    heights, ground, phases = np.empty(SAMPLES), np.empty(SAMPLES), np.empty((SAMPLES, WAVES), complex)
    for k in range(-SETTLED, SAMPLES):
        advance(state, MID, params, undulation, *(None,) * 9, settings_record, None)
        if k >= 0:
            ground[k] = undulation_ahead(state, 0.0, undulation)
            level = state["climb"] if textbook is not None and textbook.reading == "B" else ground[k]
            heights[k] = state["travel"] + level
            phases[k] = state["wave_cos"] + 1j * state["wave_sin"]
    gamma, w2, _ = suspension(state, params)
    shapes = [wave(i, undulation) for i in range(WAVES)]
    amplitudes, frequencies = np.array([a for a, _ in shapes]), settings.speed * np.array([n for _, n in shapes])
    response = transfer(frequencies, gamma, w2, textbook)
    return Ride(heights, np.imag(phases * (amplitudes * response)).sum(axis=1)), ground


def transfer(frequency: np.ndarray, gamma: float, w2: float, textbook: Textbook | None) -> np.ndarray:
    """Height of the mass over that of a sine of angular `frequency` (rad/s), in the steady ride."""
    if textbook is None:
        return w2 / (w2 - frequency**2 + 1j * gamma * frequency)
    dt = textbook.step
    z, k_d, stiff = np.exp(1j * frequency * dt), np.exp(-gamma * dt), w2 * dt**2
    response = stiff * z / ((z - 1.0) * (z - k_d) + stiff * z)
    return response * (1.0 - 1.0 / z) if textbook.reading == "B" else response


def readings(progress: Progress) -> Outcome:
    """Both readings at every step, and the exact ride."""
    exact, ground = ridden(None)
    size = float(exact.heights.std())
    found: dict[str, list[Ride]] = {"A": [], "B": []}
    for rate in progress(RATES, desc="steps"):
        for reading, rides in found.items():
            rides.append(ridden(Textbook(step=1.0 / rate, reading=reading))[0])
    sizes = {reading: np.array([ride.heights.std() for ride in rides]) for reading, rides in found.items()}
    errors = {
        reading: np.array([np.sqrt(np.mean((ride.heights - exact.heights) ** 2)) for ride in rides])
        for reading, rides in found.items()
    }
    misfits = {
        reading: max(float(np.abs(ride.heights - ride.formula).max()) for ride in rides)
        for reading, rides in found.items()
    }
    columns = {"step_s": 1.0 / np.array(RATES)}
    for reading in found:
        columns |= {f"rms_{reading}_m": sizes[reading], f"error_{reading}_m": errors[reading]}
    columns["rms_exact_m"] = np.full(len(RATES), size)
    return Outcome(
        _findings(exact, size, sizes, errors, misfits),
        {"steps": columns},
        lambda figure: _draw(figure, exact, ground, found, columns),
    )


def _findings(
    exact: Ride,
    size: float,
    sizes: dict[str, np.ndarray],
    errors: dict[str, np.ndarray],
    misfits: dict[str, float],
) -> tuple[Finding, ...]:
    off = float(np.abs(exact.heights - exact.formula).max())
    findings = [
        Finding(
            "exact ride against its closed form",
            f"the same heights within {SAME:g} m",
            f"{off:.1e} m off; rms {1e3 * size:.2f} mm",
            off < SAME,
        )
    ]
    for reading, misfit in misfits.items():
        findings.append(
            Finding(
                f"reading {reading}, {RATES[0]} to {RATES[-1]} steps a second, against H_{reading}",
                f"the same heights within {SAME:g} m",
                f"{misfit:.1e} m off",
                misfit < SAME,
            )
        )
    order = np.log2(errors["A"][:-1] / errors["A"][1:])
    findings.append(
        Finding(
            "reading A: its error when the step is halved",
            "halves (order 1), the last three times within 5 %",
            "orders " + ", ".join(f"{o:.2f}" for o in order),
            bool((np.abs(order[-3:] - 1.0) < 0.05).all()),
        )
    )
    ratio = sizes["B"][:-1] / sizes["B"][1:]
    findings.append(
        Finding(
            "reading B: its motion when the step is halved",
            "halves too: within 5 % of 2, the last three times",
            ", ".join(f"{r:.2f}" for r in ratio),
            bool((np.abs(ratio[-3:] - 2.0) < 0.1).all()),
        )
    )
    findings.append(
        Finding(
            f"motion at 1/{', 1/'.join(map(str, RATES[:4]))} s",
            f"A goes to the exact {1e3 * size:.1f} mm rms, B to 0",
            "; ".join(f"{k} " + ", ".join(f"{1e3 * s:.1f}" for s in v[:4]) for k, v in sizes.items()) + " mm",
            bool(abs(sizes["A"][3] / size - 1.0) < 0.05 and sizes["B"][3] < 0.2 * size),
        )
    )
    return tuple(findings)


def _draw(
    figure: Figure, exact: Ride, ground: np.ndarray, found: dict[str, list[Ride]], columns: dict[str, np.ndarray]
) -> None:
    """Heights over time, and rms over the step."""
    figure.set_size_inches(11.0, 4.5)
    left, right = figure.subplots(1, 2)
    shown = slice(0, 120)
    seconds = INTERVAL * np.arange(SAMPLES)[shown]
    left.plot(seconds, 1e3 * ground[shown], color=FAINT, lw=0.8, label="ground")
    left.plot(seconds, 1e3 * exact.heights[shown], color=FORMULA, label="exact")
    for reading, i, colour in (("A", 0, BALL), ("B", 0, FOUND), ("B", 3, BAR)):
        heights = found[reading][i].heights[shown]
        left.plot(seconds, 1e3 * heights, ".-", color=colour, ms=3.0, lw=0.6, label=f"{reading}, 1/{RATES[i]} s")
    label(left, "height of the mass", "time (s)", "height (mm)", legend=True)
    step = 1e3 * columns["step_s"]
    for reading, colour in (("A", BALL), ("B", FOUND)):
        right.loglog(step, 1e3 * columns[f"rms_{reading}_m"], "o-", color=colour, ms=4.0, label=f"{reading}, motion")
        right.loglog(step, 1e3 * columns[f"error_{reading}_m"], "o:", color=colour, ms=3.0, label=f"{reading}, error")
    right.axhline(1e3 * columns["rms_exact_m"][0], color=FORMULA, lw=0.8, label="exact")
    label(right, "root mean squares", "step (ms)", "height (mm)", legend=True)
