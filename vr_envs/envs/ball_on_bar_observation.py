"""What a policy sees of the ball on a bar."""

from __future__ import annotations

import numpy as np

from vr_envs.envs.scene import Scene
from vr_envs.envs.task import Channel
from vr_envs.models.jit import kernel
from vr_envs.models.noise import normal_pair

# Scales of the observation: a channel is the quantity over its scale, clipped to [-1, 1].
HEIGHT_SCALE = 0.02  # m
SPEED_SCALE = 0.5  # m/s, sideways velocity and spin
FALL_SCALE = 1.0  # m/s, vertical velocity
_NOISE_COUNTER = 1 << 60  # of normal pairs: apart from those of the scatter and of the start


@kernel
def _scaled(value, scale):
    """`value` over `scale`, clipped; a motion without a range (a scale of 0) shows as 0."""
    if scale == 0.0:
        return np.float32(0.0)
    return np.float32(min(1.0, max(-1.0, value / scale)))


@kernel
def _seen(state, sensing, camera):
    """(x, u, z, w, spin) of the ball as they are seen."""
    v = state.seen
    if camera is not None:
        return v[0], v[1], v[2], v[3], v[4]
    if sensing is None:
        return state.x, state.u, state.z, state.w, state.spin
    else:
        counter = _NOISE_COUNTER + 3 * state.steps
        n_x, n_z = normal_pair(state.key, counter)
        n_u, n_w = normal_pair(state.key, counter + 1)
        n_spin, _ = normal_pair(state.key, counter + 2)
        a, b = sensing.position, sensing.velocity
        return v[0] + a * n_x, v[1] + b * n_u, v[2] + a * n_z, v[3] + b * n_w, v[4] + b * n_spin


@kernel
def observe(
    state, row, params, scatter, spin, friction, softening, curve, frequencies, ramp, sensing, camera, textbook
):
    """Write the observation of `state`; the channels are documented at `observations`."""
    x, u, z, w, rolled = _seen(state, sensing, camera)
    row[0] = _scaled(x, params.half_length)
    row[1] = _scaled(u, SPEED_SCALE)
    row[2] = _scaled(z, HEIGHT_SCALE)
    row[3] = _scaled(w, FALL_SCALE)
    m = state.motion
    row[4] = _scaled(m[0], params.x_span)
    row[5] = _scaled(m[1], params.x_span)
    row[6] = _scaled(m[2], params.tilt_span)
    row[7] = _scaled(m[3], params.tilt_span)
    row[8] = _scaled(m[4] - params.z_centre, params.z_span)
    row[9] = _scaled(m[5], params.z_span)
    if spin is not None:
        row[10] = _scaled(rolled, SPEED_SCALE)


def observations(scene: Scene) -> tuple[Channel, ...]:
    """The channels of an observation."""
    p = scene.params
    half, x, tilt = f"{p.half_length:g} m", f"{p.x_span:.3g} m", f"{p.tilt_span:.3g} rad"
    rows = [
        ("x", half, "ball along the bar, from the centre"),
        ("x velocity", f"{SPEED_SCALE:g} m/s", "ball velocity along x"),
        ("z", f"{HEIGHT_SCALE:g} m", "ball height, from the bar's mean height"),
        ("z velocity", f"{FALL_SCALE:g} m/s", "ball velocity upwards"),
        ("x in phase", x, "bar: cosine part of x"),
        ("x quadrature", x, "bar: sine part of x"),
        ("tilt in phase", tilt, "bar: cosine part of the tilt"),
        ("tilt quadrature", tilt, "bar: sine part of the tilt"),
        ("z in phase", f"{p.z_span:.3g} m", "bar: cosine part of z at twice the base frequency, from its centre value"),
        ("z quadrature", f"{p.z_span:.3g} m", "bar: sine part of z at twice the base frequency"),
    ]
    if scene.options["spin"] is not None:
        rows.append(("spin", f"{SPEED_SCALE:g} m/s", "ball radius times spin about +y"))
    return tuple(Channel(name, unit, doc) for name, unit, doc in rows)
