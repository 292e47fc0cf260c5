"""The autopilot's observation and action: how they are scaled, and how a controller undoes it, in SI units."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vr_envs.envs.autopilot_sensing import measure
from vr_envs.envs.scene import Scene
from vr_envs.envs.task import Channel
from vr_envs.models.atmosphere import airspeed_rate, true_airspeed
from vr_envs.models.autopilot import wrap
from vr_envs.models.autopilot_limits import rate_limits
from vr_envs.models.elementary import log
from vr_envs.models.jit import kernel

# tolerance of each channel: the score of a channel is 1/2 there (altitude m, airspeed m/s, heading rad)
BAND = (15.0, 1.0, math.radians(0.5))
# error at which the logarithmic scale reaches 1
SPAN = (15000.0, 300.0, math.pi)
_LOG_SPAN = tuple(math.log(1.0 + span / band) for span, band in zip(SPAN, BAND, strict=True))
# a kernel multiplies: division by a constant is several times slower
_PER_BAND = tuple(1.0 / band for band in BAND)
_PER_LOG_SPAN = tuple(1.0 / log_span for log_span in _LOG_SPAN)
_NAMES = ("altitude", "airspeed", "heading")
_UNITS = ("m", "m/s", "rad")
_RATES = ("vertical speed", "acceleration", "turn rate")


class Reading(NamedTuple):
    """What an observation batch says, in SI units; (n, 3) is altitude, airspeed, heading."""

    error: np.ndarray  # demand - value, (n, 3)
    rate: np.ndarray  # vertical speed, acceleration, turn rate, (n, 3)
    demand_rate: np.ndarray  # (n, 3)
    speed: np.ndarray  # airspeed as measured, (n,)
    altitude: np.ndarray  # (n,)
    true_speed: np.ndarray  # true airspeed, (n,)
    action: np.ndarray  # last action, (n, 3)
    earlier_action: np.ndarray  # the one before, (n, 3)


@kernel
def errors(demand, altitude, speed, heading):  # type: ignore[no-untyped-def]
    """Demands (3) minus values, the airspeed as measured; the heading's the short way round."""
    return demand[0] - altitude, demand[1] - speed, wrap(demand[2] - heading)


@kernel
def _put(row, index, value):  # type: ignore[no-untyped-def]
    row[index] = min(1.0, max(-1.0, value))


@kernel
def _signed_log(error, channel):  # type: ignore[no-untyped-def]
    return math.copysign(log(1.0 + abs(error) * _PER_BAND[channel]) * _PER_LOG_SPAN[channel], error)


@kernel
def delays_of(lags):  # type: ignore[no-untyped-def]
    """Time constants [s] of the three channels."""
    return lags.vertical, lags.along, lags.turn


@kernel
def observe(
    state, row, params, envelope, energy, lags, atmosphere, wind, shear, turbulence, track, textbook, demands,
    plan, sensing, metrics,
):  # type: ignore[no-untyped-def]  # fmt: skip
    """Write the observation of a record into `row` (float32, 23 channels of `channels`)."""
    altitude, speed, heading, climb, acceleration, turn = measure(state, atmosphere, sensing)
    per_limit = (
        1.0 / max(params.climb, params.descent),
        1.0 / max(params.acceleration, params.deceleration),
        1.0 / params.turn,
    )
    away = errors(state.demand, altitude, speed, heading)
    rates = (climb, acceleration, turn)
    changes = (climb, airspeed_rate(altitude, speed, climb, acceleration, atmosphere), turn)
    for channel in range(3):
        error = away[channel]
        lead = error
        if lags is not None:
            lead -= delays_of(lags)[channel] * (changes[channel] - state.demand_rate[channel])
        _put(row, channel, _signed_log(error, channel))
        row[3 + channel] = error / (BAND[channel] + abs(error))
        row[6 + channel] = lead / (BAND[channel] + abs(lead))
        _put(row, 9 + channel, rates[channel] * per_limit[channel])
        _put(row, 12 + channel, state.demand_rate[channel] * per_limit[channel])
        row[17 + channel] = state.action[channel]
        row[20 + channel] = state.earlier_action[channel]
    _put(row, 15, (speed - params.stall_speed) * (2.0 / (params.top_speed - params.stall_speed)) - 1.0)
    _put(row, 16, altitude * (2.0 / params.ceiling) - 1.0)


def read(observations: np.ndarray, scene: Scene) -> Reading:
    """The inverse of `observe` for a batch (n, 23); errors beyond SPAN read as SPAN."""
    row = np.asarray(observations, np.float64)
    p = scene.params
    scales = np.array([max(p.climb, p.descent), max(p.acceleration, p.deceleration), p.turn])

    def errors_of(encoded: np.ndarray) -> np.ndarray:
        return np.sign(encoded) * np.array(BAND) * np.expm1(np.abs(encoded) * np.array(_LOG_SPAN))

    speed = p.stall_speed + 0.5 * (row[:, 15] + 1.0) * (p.top_speed - p.stall_speed)
    altitude = 0.5 * (row[:, 16] + 1.0) * p.ceiling
    return Reading(
        error=errors_of(row[:, 0:3]),
        rate=row[:, 9:12] * scales,
        demand_rate=row[:, 12:15] * scales,
        speed=speed,
        altitude=altitude,
        true_speed=_true_airspeeds(altitude, speed, _record(scene, "atmosphere")),
        action=row[:, 17:20],
        earlier_action=row[:, 20:23],
    )


def _record(scene: Scene, option: str) -> np.void | None:
    return scene.records()[1][list(scene.options).index(option)]


@kernel
def _true_airspeeds(altitudes, speeds, atmosphere):  # type: ignore[no-untyped-def]
    found = np.empty_like(speeds)
    for i in range(speeds.shape[0]):
        found[i] = true_airspeed(altitudes[i], speeds[i], atmosphere)
    return found


@kernel
def _limits_of_rows(altitudes, speeds, params, envelope, falling, rising):  # type: ignore[no-untyped-def]
    for i in range(altitudes.shape[0]):
        down, up = rate_limits(altitudes[i], speeds[i], params, envelope)
        for channel in range(3):
            falling[i, channel], rising[i, channel] = down[channel], up[channel]


def limits(reading: Reading, scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Largest falling and rising rates (n, 3), all positive, at the altitudes and airspeeds of a reading."""
    falling, rising = np.empty_like(reading.rate), np.empty_like(reading.rate)
    envelope = _record(scene, "envelope")
    _limits_of_rows(reading.altitude, reading.true_speed, scene.records()[0], envelope, falling, rising)
    return falling, rising


def actions_for(rates: np.ndarray, falling: np.ndarray, rising: np.ndarray) -> np.ndarray:
    """Actions (n, 3), float32, that command vertical speeds, accelerations and turn rates (n, 3), clipped to [-1, 1].

    `falling`, `rising`: their limits (n, 3), from `limits`.
    """
    limit = np.where(rates > 0.0, rising, falling)
    shares = np.divide(rates, limit, out=np.zeros_like(rates), where=limit > 0.0)
    return np.clip(shares, -1.0, 1.0).astype(np.float32)


def channels(scene: Scene) -> tuple[Channel, ...]:
    """The 23 numbers of an observation."""
    p = scene.params
    scales = (max(p.climb, p.descent), max(p.acceleration, p.deceleration), p.turn)
    triple = tuple(zip(_NAMES, _UNITS, BAND, SPAN, _RATES, scales, strict=True))
    rate_units = ("m/s", "m/s^2", "rad/s")
    rates = tuple(zip(_RATES, rate_units, scales, strict=True))
    last = ("vertical speed command", "acceleration command", "turn command")
    return (
        *(Channel(f"{n} error", u, f"demand - value = +-{b:.4g} (exp(|o| ln(1 + {s:.5g}/{b:.4g})) - 1)")
          for n, u, b, s, _, _ in triple),
        *(Channel(f"{n} error, near", u, f"e / ({b:.4g} + |e|), e = demand - value") for n, u, b, *_ in triple),
        *(Channel(f"{n} lead error", u, f"l / ({b:.4g} + |l|), l = e - lag (rate - demand rate)")
          for n, u, b, *_ in triple),
        *(Channel(n, u, f"in units of {s:.4g} {u}") for n, u, s in rates),
        *(Channel(f"rate of demanded {n}", u, f"in units of {s:.4g} {u}")
          for n, (_, u, s) in zip(_NAMES, rates, strict=True)),
        Channel("airspeed, as measured", "m/s", f"from {p.stall_speed:g} at -1 to {p.top_speed:g} at 1"),
        Channel("altitude", "m", f"from 0 at -1 to {p.ceiling:g} at 1"),
        *(Channel(f"last {n}", "1", "fraction of the limit") for n in last),
        *(Channel(f"earlier {n}", "1", "fraction of the limit, one control interval before the last") for n in last),
    )  # fmt: skip
