"""A ball bouncing in three dimensions on a spherical lens that moves up and down: exact, event by event.

Frame (Bell's): x right, y away from the camera, z up; the lens's axis is vertical. The lens moves with
z = A sin(omega s + phase), time s running from 0 in each cycle, so it never loses digits. The ball's centre moves
above a sphere of its own, the path: for a ball of radius R on glass of curvature k (positive where concave) the path
has the curvature kappa = k / (1 - k R). Source: Bell (bouncing-ball report), section II.

A ball that comes to rest is outside this model: a chatter ends in a fault, never in a silent loop.
"""

from __future__ import annotations

import dataclasses
import math

from vr_envs.models.impact import collide
from vr_envs.models.jit import kernel
from vr_envs.models.lens_flight import flight, gap_at, lens_at, surface_height
from vr_envs.models.record import quantity
from vr_envs.models.root import UNDECIDED

MAX_IMPACTS = 1000  # in one cycle; a ball that needs more chatters, which is a fault

LOGGED = ("time", "x", "y", "z", "u", "v", "w", "normal_in", "normal_out")
"""Columns of the log of impacts: time in the cycle (s), place of the ball's centre (m), its velocity after the impact
(m/s), and its velocity along the normal relative to the lens before and after (m/s)."""


@dataclasses.dataclass(frozen=True)
class Params:
    """The lens, its motion and the ball. Defaults: Bell's lens of 15 cm focal length and best fit of restitution.

    Raises:
        ValueError: the ball does not fit the lens, or the lens is wider than its sphere.
    """

    DERIVED = ("omega", "period", "amplitude", "path_curvature", "path_edge")

    gravity: float = quantity(9.81, "m/s^2", "gravity", low=0.1, high=100.0)
    frequency: float = quantity(30.0, "Hz", "frequency of the lens", low=0.5, high=400.0)
    acceleration: float = quantity(8.0, "m/s^2", "peak acceleration of the lens (Bell, Fig 4.1)", low=0.0, high=100.0)
    phase: float = quantity(0.0, "rad", "phase of the lens at the start of a cycle", low=-7.0, high=7.0)
    curvature: float = quantity(
        1.0 / (0.15 * 0.517), "1/m", "of the glass; positive: concave, 0: flat, negative: convex", low=-1e3, high=1e3
    )
    half_aperture: float = quantity(0.025, "m", "distance of the glass's edge from the axis", low=1e-3, high=10.0)
    ball_radius: float = quantity(0.0025, "m", "radius R of the ball", low=1e-4, high=1.0)
    restitution: float = quantity(0.75, "", "normal restitution alpha, best fit of Bell's data", low=0.0, high=1.0)
    tangential_loss: float = quantity(
        0.0, "", "part c of the tangential velocity lost at an impact (without spin)", low=0.0, high=1.0
    )

    def __post_init__(self) -> None:
        """Refuse what is no lens with a ball on it."""
        if self.curvature * self.ball_radius >= 1.0:
            raise ValueError(
                f"ball_radius = {self.ball_radius} m does not fit a lens of radius {1.0 / self.curvature:g} m; "
                "it must be smaller"
            )
        if abs(self.curvature) * self.half_aperture >= 1.0:
            raise ValueError(
                f"half_aperture = {self.half_aperture} m is not allowed; it must be below the lens's radius, "
                f"{1.0 / abs(self.curvature):g} m"
            )

    @property
    def omega(self) -> float:
        """Angular frequency of the lens, rad/s."""
        return 2.0 * math.pi * self.frequency

    @property
    def period(self) -> float:
        """One cycle of the lens, s."""
        return 1.0 / self.frequency

    @property
    def amplitude(self) -> float:
        """Amplitude of the lens, m."""
        return self.acceleration / self.omega**2

    @property
    def path_curvature(self) -> float:
        """Curvature kappa of the path of the ball's centre, 1/m."""
        return self.curvature / (1.0 - self.curvature * self.ball_radius)

    @property
    def path_edge(self) -> float:
        """Distance of the ball's centre from the axis when it touches the glass's edge, m."""
        return self.half_aperture * (1.0 - self.curvature * self.ball_radius)


@dataclasses.dataclass(frozen=True)
class State:
    """The ball in flight at the start of a cycle. Place: its centre, from the path's lowest point at mean height."""

    cycles: int = quantity(0, "", "cycles since the start", low=0)
    impacts: int = quantity(0, "", "impacts since the start", low=0)
    lost: bool = quantity(False, "", "the ball has left the lens")
    fault: bool = quantity(
        False, "", "more than MAX_IMPACTS in a cycle, a search that did not end, or a ball above its sphere's centre"
    )
    x: float = quantity(0.0, "m", "ball, to the right")
    y: float = quantity(0.0, "m", "ball, away from the camera")
    z: float = quantity(0.0, "m", "ball, upwards")
    u: float = quantity(0.0, "m/s", "velocity of x")
    v: float = quantity(0.0, "m/s", "velocity of y")
    w: float = quantity(0.0, "m/s", "velocity of z")
    spin_x: float = quantity(0.0, "m/s", "ball radius times spin about +x")
    spin_y: float = quantity(0.0, "m/s", "ball radius times spin about +y")
    spin_z: float = quantity(0.0, "m/s", "ball radius times spin about +z")


def plano_concave(focal_length: float, refractive_index: float = 1.517) -> float:
    """Curvature (1/m) of the hollow side of a thin plano-concave lens with a focal length of size `focal_length` (m).

    The index is that of BK7 glass in yellow light.
    """
    return 1.0 / (focal_length * (refractive_index - 1.0))


@kernel
def rebound(velocity, spin_velocity, normal, params, spin, friction):
    """Velocities after an impact in three dimensions.

    The impact is central, so its impulse stays in the plane of the normal and the slip: the law in that plane is
    `impact.collide`.

    Args:
        velocity: of the ball's centre relative to the lens, m/s, three components, approaching.
        spin_velocity: R times the ball's angular velocity, m/s, three components.
        normal: unit normal from the lens to the ball.
        params: record of `Params`.
        spin: record of `vr_envs.models.ball_options.Spin` or None: the ball grips, which replaces `tangential_loss`.
        friction: record of `vr_envs.models.ball_options.Friction` or None: the limit of the grip.

    Returns:
        (velocity, spin_velocity, normal velocity before, and after the impact).
    """
    (u, v, w), (p, q, r), (nx, ny, nz) = velocity, spin_velocity, normal
    approach = u * nx + v * ny + w * nz
    # tangential velocity, and the velocity spin x normal that the spin takes from it
    tu, tv, tw = u - approach * nx, v - approach * ny, w - approach * nz
    cu, cv, cw = q * nz - r * ny, r * nx - p * nz, p * ny - q * nx
    eu, ev, ew = tu, tv, tw
    if spin is not None:
        eu, ev, ew = tu - cu, tv - cv, tw - cw
    size = math.sqrt(eu * eu + ev * ev + ew * ew)
    if size > 0.0:
        eu, ev, ew = eu / size, ev / size, ew / size
    tangent, rolling = tu * eu + tv * ev + tw * ew, cu * eu + cv * ev + cw * ew
    leave, new_tangent, new_rolling = collide(
        approach, tangent, rolling, params.restitution, params.tangential_loss, spin, friction
    )
    push, drag, twist = leave - approach, new_tangent - tangent, new_rolling - rolling
    velocity = (u + push * nx + drag * eu, v + push * ny + drag * ev, w + push * nz + drag * ew)
    spin_velocity = (
        p + twist * (ny * ew - nz * ev),
        q + twist * (nz * eu - nx * ew),
        r + twist * (nx * ev - ny * eu),
    )
    return velocity, spin_velocity, approach, leave


@kernel
def _move(state, ds, gravity):
    """Free flight for a time `ds`."""
    state.x += state.u * ds
    state.y += state.v * ds
    state.z += (state.w - 0.5 * gravity * ds) * ds
    state.w -= gravity * ds


@kernel
def _impact(state, s, params, spin, friction, log):
    """The impact of a ball that touches the lens at time s; returns its normal velocity after it."""
    kappa = params.path_curvature
    distance = math.hypot(state.x, state.y)
    height, climb, _, _ = lens_at(params, s)
    if distance > params.path_edge:
        state.lost = True
        return 0.0
    if kappa * (state.z - height) > 1.0:
        state.fault = True  # the upper half of the path's sphere is no glass
        return 0.0
    # on the path to the last digit, so that rounding does not add up over the impacts
    h = surface_height(distance, kappa)
    state.z = height + h
    velocity, rolling, approach, leave = rebound(
        (state.u, state.v, state.w - climb),
        (state.spin_x, state.spin_y, state.spin_z),
        (-kappa * state.x, -kappa * state.y, 1.0 - kappa * h),
        params,
        spin,
        friction,
    )
    state.u, state.v, state.w = velocity[0], velocity[1], velocity[2] + climb
    state.spin_x, state.spin_y, state.spin_z = rolling
    if log is not None:
        log[state.impacts % len(log)] = (
            s, state.x, state.y, state.z, state.u, state.v, state.w, approach, leave,
        )  # fmt: skip
    state.impacts += 1
    return leave


@kernel
def cycle(state, params, spin, friction, log=None):
    """Move the ball by one cycle of the lens.

    Args:
        state: record of `State`, changed in place; a lost ball stays where it left the lens.
        params: record of `Params`.
        spin, friction: as in `rebound`.
        log: None, or an array (capacity, len(LOGGED)) that receives each impact, number i in row i modulo capacity.
    """
    if state.lost or state.fault:
        return
    s = 0.0
    gap, rate = gap_at(state, s, params)
    for _ in range(MAX_IMPACTS + 1):
        hit, ds = flight(state, s, gap, rate, params)
        if ds == UNDECIDED:
            break
        s += ds
        _move(state, ds, params.gravity)
        if not hit:
            state.cycles += 1
            h = state.z - lens_at(params, params.period)[0]
            edge = params.path_edge
            rim = surface_height(edge, params.path_curvature)
            state.lost = math.hypot(state.x, state.y) > edge and h < rim  # it has fallen past the lens
            return
        gap, rate = 0.0, _impact(state, s, params, spin, friction, log)
        if state.lost or state.fault:
            return
    state.fault = True
