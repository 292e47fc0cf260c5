"""A ball bouncing on a bar with three degrees of freedom: exact event-driven dynamics.

Ballistic flight, impacts located by a certified first-root march, restitution and tangential law at the contact
point, chatter closed by its accumulation time, rest until release. Frame and motion: `models/bar.py`; what a scene may
add: `models/ball_options.py`. Source: Bell (bouncing-ball report), sections III and IV. Time runs from 0 in each base
cycle, so it never loses digits.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any, NamedTuple

from vr_envs.models.ball_sensors import ages_of, sense
from vr_envs.models.bar import Piece, bounds, frame_at
from vr_envs.models.chatter import settle
from vr_envs.models.drive import base_cycle, demanded, phase_at, phasors_at
from vr_envs.models.flight import AIRBORNE, BOUNCED, RELEASED, flight
from vr_envs.models.impact import collide, collide_rough, softened
from vr_envs.models.jit import kernel
from vr_envs.models.noise import normal_pair
from vr_envs.models.record import quantity
from vr_envs.models.rest import rest
from vr_envs.models.rolling import STILL
from vr_envs.models.root import UNDECIDED
from vr_envs.models.surface import contact_at

MAX_EVENTS = 20_000  # impacts and releases in one piece of bar motion; a ball that needs more is a fault
STEEPEST = 1.5  # rad, a ramp may take the bar to this tilt; beyond it, where it nearly stands upright, is a fault

LOGGED = ("time", "x", "z", "normal_in", "tangent_in", "normal_out", "tangent_out")
"""Columns of the log of impacts: time in the base cycle (s), place of the ball (m), velocity of its centre relative to
the bar's material along normal and tangent, before and after (m/s)."""


@dataclasses.dataclass(frozen=True)
class Params:
    """The bar, the ball and the range of the bar's motion. Defaults: Bell section IV at the project's 15 Hz."""

    DERIVED = ("omega", "period", "x_span", "tilt_span", "z_centre", "z_span")

    gravity: float = quantity(9.81, "m/s^2", "gravity", low=0.1, high=100.0)
    frequency: float = quantity(15.0, "Hz", "base frequency of x and tilt; z moves at twice this", low=0.5, high=200.0)
    half_length: float = quantity(0.025, "m", "half the length of the bar", low=0.001, high=10.0)
    restitution: float = quantity(0.75, "", "normal restitution alpha, best fit of Bell's data", low=0.0, high=1.0)
    tangential_loss: float = quantity(
        2.0 / 7.0, "", "part c of the tangential velocity lost at an impact (without spin)", low=0.0, high=1.0
    )
    blend: float = quantity(0.5, "cycle", "part of a cycle in which the bar goes to its new motion", low=0.05, high=1.0)
    hold: float = quantity(1.0, "cycle", "base cycles between two actions: 0.5, or a whole number", low=0.5, high=100.0)
    x_acceleration: float = quantity(10.0, "m/s^2", "x: peak acceleration at action 1", low=0.0, high=100.0)
    tilt_acceleration: float = quantity(100.0, "rad/s^2", "tilt: peak acceleration at action 1", low=0.0, high=5000.0)
    z_acceleration: float = quantity(
        8.0, "m/s^2", "z: peak acceleration at action 0 (Bell, Fig 4.1)", low=0.0, high=100.0
    )
    z_acceleration_span: float = quantity(4.0, "m/s^2", "z: change of it at action 1", low=0.0, high=100.0)

    @property
    def omega(self) -> float:
        """Base angular frequency, rad/s."""
        return 2.0 * math.pi * self.frequency

    @property
    def period(self) -> float:
        """Base cycle, s."""
        return 1.0 / self.frequency

    @property
    def x_span(self) -> float:
        """Amplitude of x at action 1, m."""
        return self.x_acceleration / self.omega**2

    @property
    def tilt_span(self) -> float:
        """Amplitude of tilt at action 1, rad."""
        return self.tilt_acceleration / self.omega**2

    @property
    def z_centre(self) -> float:
        """Amplitude of z at action 0, m."""
        return self.z_acceleration / (2.0 * self.omega) ** 2

    @property
    def z_span(self) -> float:
        """Change of the amplitude of z at action 1, m."""
        return self.z_acceleration_span / (2.0 * self.omega) ** 2


@dataclasses.dataclass(frozen=True)
class State:
    """The ball at the start of a control interval, and the bar's motion."""

    key: int = quantity(0, "", "episode key", kind="key")
    steps: int = quantity(0, "", "control intervals since the start", low=0)
    impacts: int = quantity(0, "", "impacts since the start; the counter of the scatter", low=0)
    resting: bool = quantity(False, "", "the ball lies on the bar")
    lost: bool = quantity(False, "", "the ball has left the bar")
    fault: bool = quantity(
        False, "", "more than MAX_EVENTS events, a search that did not end, or a tilt beyond STEEPEST"
    )
    x: float = quantity(0.0, "m", "ball, along the bar, from the bar's mean position")
    z: float = quantity(0.0, "m", "ball, upwards, from the bar's mean position")
    u: float = quantity(0.0, "m/s", "velocity of x")
    w: float = quantity(0.0, "m/s", "velocity of z")
    spin: float = quantity(0.0, "m/s", "radius times spin about +y")
    d: float = quantity(0.0, "m", "place on the bar of a resting ball")
    rate: float = quantity(0.0, "m/s", "velocity along the bar of a resting ball")
    motion: float = quantity(0.0, "m, rad, m", "x, tilt, z: cosine and sine parts of the bar's motion", shape=(6,))
    seen: float = quantity(0.0, "m, m/s", "what a sensor saw last: x, u, z, w, spin", shape=(5,))


class Laws(NamedTuple):
    """The records that decide what happens between ball and bar; an absent option is None."""

    params: Any
    scatter: Any
    spin: Any
    friction: Any
    softening: Any
    curve: Any
    textbook: Any


@kernel
def _impact(state, piece, frame, limits, s, end, params, scatter, spin, friction, softening, curve, log):
    """One impact at time s; returns (time, how a flight begins from here if the ball has not come to rest)."""
    contact = contact_at(frame, state.x, state.z, state.u, state.w, curve)
    state.x, state.z = contact.x, contact.z
    if abs(contact.d) > params.half_length:
        state.lost = True
        return s, AIRBORNE
    surface_spin = 0.0
    if spin is not None:
        surface_spin = state.spin - spin.radius * frame.tilt[1]
    normal, tangent = contact.normal, contact.tangent
    if normal < 0.0:
        alpha, deviation = params.restitution, 0.0
        if scatter is not None:
            first, second = normal_pair(state.key, state.impacts + 1)
            alpha = min(1.0, max(0.0, alpha + scatter.restitution * first))
            deviation = scatter.normal * second
        alpha = softened(alpha, normal, softening)
        if scatter is None:
            normal, tangent, surface_spin = collide(
                normal, tangent, surface_spin, alpha, params.tangential_loss, spin, friction
            )
        else:
            normal, tangent, surface_spin = collide_rough(
                normal, tangent, surface_spin, alpha, params.tangential_loss, spin, friction, deviation
            )
    if log is not None:
        log[state.impacts % log.shape[0]] = s, state.x, state.z, contact.normal, contact.tangent, normal, tangent
    state.impacts += 1
    d_normal, d_tangent = normal - contact.normal, tangent - contact.tangent
    state.u += d_normal * contact.sin + d_tangent * contact.cos
    state.w += d_normal * contact.cos - d_tangent * contact.sin
    if spin is not None:
        state.spin = surface_spin + spin.radius * frame.tilt[1]
    s = settle(
        state, piece, frame, limits, s, end, contact, normal, tangent, params, scatter, spin, friction, softening, curve
    )
    return s, BOUNCED if normal > STILL else RELEASED


@kernel
def _stretch(state, piece, s, end, laws, log):
    """All events of one piece of bar motion, from time s to `end`."""
    gravity = laws.params.gravity
    limits = bounds(piece)
    if limits[1].d0 > STEEPEST:
        state.fault = True
        return
    tan = math.tan(limits[1].d0)
    frame = frame_at(piece, s)
    contact = AIRBORNE
    for _ in range(MAX_EVENTS):
        if state.resting:
            s, frame = rest(state, piece, limits, s, end, laws.params, laws.spin, laws.friction, laws.curve)
            if state.resting or state.lost or state.fault or s >= end:
                return
            contact = RELEASED
        hit, ds = flight(
            piece, limits, tan, s, frame, end, state.x, state.z, state.u, state.w, gravity, contact,
            laws.curve, laws.textbook,
        )  # fmt: skip
        if ds == UNDECIDED:
            state.fault = True
            return
        state.x += state.u * ds
        state.z += (state.w - 0.5 * gravity * ds) * ds
        state.w -= gravity * ds
        if not hit:
            return
        s += ds
        frame = frame_at(piece, s)
        s, contact = _impact(
            state, piece, frame, limits, s, end, laws.params, laws.scatter, laws.spin, laws.friction, laws.softening,
            laws.curve, log,
        )  # fmt: skip
        if state.lost:
            return
    state.fault = True


@kernel
def _move(state, old, new, s, end, begin, number, laws, frequencies, ramp, log):
    """From time s to `end` of base cycle `number`, in which the bar goes from `old` to `new` from time `begin` on."""
    params = laws.params
    phase = phase_at(number, frequencies)
    blended = begin
    if new != old:
        blended = begin + params.blend * params.period
    if s < min(end, blended) and not (state.lost or state.fault):
        blend, base, change = phasors_at(old, new, s, begin, number, params, ramp)
        piece = Piece(params.omega, begin, blend, base, change, frequencies, phase, ramp)
        _stretch(state, piece, s, min(end, blended), laws, log)
    if max(s, blended) < end and not (state.lost or state.fault):
        blend, base, change = phasors_at(new, new, s, begin, number, params, ramp)
        piece = Piece(params.omega, begin, blend, base, change, frequencies, phase, ramp)
        _stretch(state, piece, max(s, blended), end, laws, log)


@kernel
def interval(
    state, new, params, scatter, spin, friction, softening, curve, frequencies, ramp, sensing, camera, textbook,
    log=None, until=None,
):  # fmt: skip
    """Move the ball by one control interval, or to the time `until` (s) in it, while the bar goes to the motion `new`.

    The interval is `hold` base cycles, or half a one. The other arguments are those of `advance`.
    """
    laws = Laws(params, scatter, spin, friction, softening, curve, textbook)
    m = state.motion
    old = (m[0], m[1], m[2], m[3], m[4], m[5])
    period = params.period
    number, begin = base_cycle(state.steps, params)
    cycles = max(1, int(params.hold))
    for j in range(cycles):
        end = begin + min(1.0, params.hold) * period
        if until is not None:
            end = min(end, begin + until - j * period)
        s = begin
        if (sensing is not None or camera is not None) and j == cycles - 1:
            earlier, last = ages_of(sensing, camera)
            first, second = max(begin, end - earlier), max(begin, end - last)
            _move(state, old, new, begin, first, begin, number + j, laws, frequencies, ramp, log)
            x, z = state.x, state.z
            _move(state, old, new, first, second, begin, number + j, laws, frequencies, ramp, log)
            sense(state, state.steps + 1, x, z, sensing, camera)
            s = second
        _move(state, old, new, s, end, begin, number + j, laws, frequencies, ramp, log)
        old = new
    for k in range(6):
        m[k] = new[k]


@kernel
def advance(
    state,
    action,
    params,
    scatter,
    spin,
    friction,
    softening,
    curve,
    frequencies,
    ramp,
    sensing,
    camera,
    textbook,
    log=None,
):
    """Move the ball by one control interval while the bar goes to the motion that `action` asks for.

    Args:
        state: record of `State`, changed in place; a lost ball stays where it left the bar.
        action: six numbers in [-1, 1], see `demanded`.
        params: record of `Params`.
        scatter, spin, friction, softening, curve, frequencies, ramp, sensing, camera, textbook: records of `OPTIONS`,
            or None.
        log: None, or an array (capacity, len(LOGGED)) that receives each impact, number i in row i modulo capacity.
    """
    interval(
        state, demanded(action, params), params, scatter, spin, friction, softening, curve, frequencies, ramp, sensing,
        camera, textbook, log,
    )  # fmt: skip
