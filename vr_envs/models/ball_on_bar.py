"""A ball bouncing on a bar with three degrees of freedom: exact event-driven dynamics over one base cycle.

Ballistic flight, impacts located by a certified first-root march, restitution and tangential law at the contact
point, chatter closed by its accumulation time, rest until release. Frame and motion: `models/bar.py`. Source: Bell
(bouncing-ball report), sections III and IV. Time runs from 0 in each cycle, so it never loses digits.
"""

from __future__ import annotations

import dataclasses
import math

from vr_envs.models.bar import Piece, bounds, frame_at
from vr_envs.models.flight import AIRBORNE, BOUNCED, RELEASED, contact_at, flight
from vr_envs.models.impact import collide, collide_rough
from vr_envs.models.jit import kernel
from vr_envs.models.noise import normal_pair
from vr_envs.models.record import quantity
from vr_envs.models.rest import STILL, UNDECIDED, rest, settle

MAX_EVENTS = 20_000  # impacts and releases in one base cycle; a ball that needs more ends the episode as a fault

LOGGED = ("time", "x", "z", "normal_in", "tangent_in", "normal_out", "tangent_out")
"""Columns of the log of impacts: time in the cycle (s), place of the ball (m), velocity of its centre relative to the
bar's material along normal and tangent, before and after (m/s)."""


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
class Scatter:
    """Option: an imperfect ball and surface (Bell: "a great variation in the C.o.R. values")."""

    restitution: float = quantity(0.02, "", "standard deviation of alpha from impact to impact", low=0.0, high=0.3)
    normal: float = quantity(0.002, "rad", "standard deviation of the surface normal", low=0.0, high=0.1)


@dataclasses.dataclass(frozen=True)
class Spin:
    """Option: a ball that grips the bar, spins and rolls (Wang and Mason 1992). Replaces `tangential_loss`."""

    inertia_ratio: float = quantity(0.4, "", "I/(m R^2): 2/5 solid sphere, 2/3 hollow, 1/2 disc", low=0.0, high=1.0)
    radius: float = quantity(0.0025, "m", "radius R of the ball", low=1e-4, high=1.0)


OPTIONS: dict[str, type] = {"scatter": Scatter, "spin": Spin}
"""What a scene may add, in the order in which kernels take the records; an absent one is passed as None."""


@dataclasses.dataclass(frozen=True)
class State:
    """The ball at the start of a base cycle, and the bar's motion."""

    key: int = quantity(0, "", "episode key", kind="key")
    steps: int = quantity(0, "", "cycles since the start", low=0)
    impacts: int = quantity(0, "", "impacts since the start; the counter of the scatter", low=0)
    resting: bool = quantity(False, "", "the ball lies on the bar")
    lost: bool = quantity(False, "", "the ball has left the bar")
    fault: bool = quantity(False, "", "a cycle needed more than MAX_EVENTS events, or a search did not end")
    x: float = quantity(0.0, "m", "ball, along the bar, from the bar's mean position")
    z: float = quantity(0.0, "m", "ball, upwards, from the bar's mean position")
    u: float = quantity(0.0, "m/s", "velocity of x")
    w: float = quantity(0.0, "m/s", "velocity of z")
    spin: float = quantity(0.0, "m/s", "radius times spin about +y")
    d: float = quantity(0.0, "m", "place on the bar of a resting ball")
    rate: float = quantity(0.0, "m/s", "velocity along the bar of a resting ball")
    motion: float = quantity(0.0, "m, rad, m", "x, tilt, z: cosine and sine parts of the bar's motion", shape=(6,))


@kernel
def demanded(action, params):
    """The bar motion that an action asks for: in-phase and quadrature parts of x, tilt and z."""
    return (
        params.x_span * action[0],
        params.x_span * action[1],
        params.tilt_span * action[2],
        params.tilt_span * action[3],
        params.z_centre + params.z_span * action[4],
        params.z_span * action[5],
    )


@kernel
def _impact(state, piece, frame, limits, s, end, params, scatter, spin, log):
    """One impact at time s; returns (time, how a flight begins from here if the ball has not come to rest)."""
    height, normal, tangent, d = contact_at(frame, state.x, state.u, state.w)
    state.z = height
    if abs(d) > params.half_length:
        state.lost = True
        return s, AIRBORNE
    surface_spin = 0.0
    if spin is not None:
        surface_spin = state.spin - spin.radius * frame.tilt[1]
    normal_0, tangent_0 = normal, tangent
    if normal < 0.0:
        if scatter is None:
            normal, tangent, surface_spin = collide(
                normal, tangent, surface_spin, params.restitution, params.tangential_loss, spin
            )
        else:
            first, second = normal_pair(state.key, state.impacts + 1)
            restitution = min(1.0, max(0.0, params.restitution + scatter.restitution * first))
            normal, tangent, surface_spin = collide_rough(
                normal, tangent, surface_spin, restitution, params.tangential_loss, spin, scatter.normal * second
            )
    if log is not None:
        log[state.impacts % log.shape[0]] = s, state.x, state.z, normal_0, tangent_0, normal, tangent
    state.impacts += 1
    state.u += (normal - normal_0) * frame.sin + (tangent - tangent_0) * frame.cos
    state.w += (normal - normal_0) * frame.cos - (tangent - tangent_0) * frame.sin
    if spin is not None:
        state.spin = surface_spin + spin.radius * frame.tilt[1]
    s = settle(state, piece, frame, limits, s, end, normal, tangent, d, params, spin)
    return s, BOUNCED if normal > STILL else RELEASED


@kernel
def _interval(state, piece, s, end, params, scatter, spin, log):
    """All events of one piece of bar motion, from time s to `end`."""
    limits = bounds(piece)
    tan = math.tan(limits[1].d0)
    frame = frame_at(piece, s)
    contact = AIRBORNE
    for _ in range(MAX_EVENTS):
        if state.resting:
            s, frame = rest(state, piece, limits, s, end, params, spin)
            if state.resting or state.lost or state.fault or s >= end:
                return
            contact = RELEASED
        hit, ds = flight(piece, limits, tan, s, frame, end, state.x, state.z, state.u, state.w, params.gravity, contact)
        if ds == UNDECIDED:
            state.fault = True
            return
        state.x += state.u * ds
        state.z += (state.w - 0.5 * params.gravity * ds) * ds
        state.w -= params.gravity * ds
        if not hit:
            return
        s += ds
        frame = frame_at(piece, s)
        s, contact = _impact(state, piece, frame, limits, s, end, params, scatter, spin, log)
        if state.lost:
            return
    state.fault = True


@kernel
def piece_at(old, new, s, params):
    """The `Piece` of bar motion at time `s` of a cycle that goes from the motion `old` to the motion `new`."""
    blend = params.blend * params.period
    if new == old or s >= blend:
        return Piece(params.omega, 0.0, new, new)
    change = (
        new[0] - old[0], new[1] - old[1], new[2] - old[2], new[3] - old[3], new[4] - old[4], new[5] - old[5],
    )  # fmt: skip
    return Piece(params.omega, blend, old, change)


@kernel
def cycle(state, new, params, scatter, spin, log=None, until=None):
    """Move the ball by one base cycle, or to the time `until` (s) in it, while the bar goes to the motion `new`.

    The other arguments are those of `advance`.
    """
    if state.lost or state.fault:
        return
    end = params.period
    if until is not None:
        end = min(end, until)
    m = state.motion
    old = (m[0], m[1], m[2], m[3], m[4], m[5])
    start = 0.0
    if new != old:
        start = params.blend * params.period
        _interval(state, piece_at(old, new, 0.0, params), 0.0, min(start, end), params, scatter, spin, log)
    if start < end and not (state.lost or state.fault):
        _interval(state, piece_at(old, new, start, params), start, end, params, scatter, spin, log)
    for k in range(6):
        m[k] = new[k]


@kernel
def advance(state, action, params, scatter, spin, log=None):
    """Move the ball by one base cycle while the bar goes to the motion that `action` asks for.

    Args:
        state: record of `State`, changed in place; a lost ball stays where it left the bar.
        action: six numbers in [-1, 1], see `demanded`.
        params: record of `Params`.
        scatter: record of `Scatter` or None.
        spin: record of `Spin` or None.
        log: None, or an array (capacity, len(LOGGED)) that receives each impact, number i in row i modulo capacity.
    """
    cycle(state, demanded(action, params), params, scatter, spin, log)
