"""What a sensor sees of the ball: the state itself of some time ago, or a camera's last two exposures."""

from __future__ import annotations

from vr_envs.models.jit import kernel
from vr_envs.models.tracker import observe_ball


@kernel
def ages_of(sensing, camera):
    """How long before an observation the sensor looks, s: the earlier time and the last."""
    if sensing is not None:
        return sensing.delay, sensing.delay
    if camera is not None:
        return camera.latency + 1.0 / camera.frame_rate, camera.latency
    return 0.0, 0.0


@kernel
def sense(state, number, x, z, sensing, camera):
    """Keep in `state.seen` what the sensor sees of the ball now, for observation `number`.

    `x`, `z`: place of the ball at the earlier time. A camera that does not see the ball keeps what it saw last; it sees
    no spin.
    """
    v = state.seen
    if camera is not None:
        sight = observe_ball(state.key, number, x, z, state.x, state.z, camera)
        if sight.seen:
            v[0], v[1], v[2], v[3] = sight.x, sight.u, sight.z, sight.w
    if sensing is not None:
        v[0], v[1], v[2], v[3], v[4] = state.x, state.u, state.z, state.w, state.spin


@kernel
def sense_start(state, gravity, sensing, camera):
    """`sense` at the start of an episode: of the flight that would have led to it."""
    earlier, last = ages_of(sensing, camera)
    x, z, u, w = state.x, state.z, state.u, state.w
    state.x, state.z, state.w = x - last * u, z - last * (w + 0.5 * gravity * last), w + gravity * last
    sense(state, 0, x - earlier * u, z - earlier * (w + 0.5 * gravity * earlier), sensing, camera)
    state.x, state.z, state.w = x, z, w
