"""Flight of a ball over the bar: what it uses to take off."""

import numpy as np
import pytest

from vr_envs.models.ball_options import Curve
from vr_envs.models.bar import Piece, frame_at
from vr_envs.models.flight import bend_at
from vr_envs.models.jit import kernel
from vr_envs.models.record import pack
from vr_envs.models.surface import contact_at, gap

GRAVITY, OMEGA = 9.81, 94.0


@kernel
def both(motion, s, d, u, w, curve):
    """Second derivative of the gap at a take-off, by `bend_at` and by `gap`."""
    piece = Piece(OMEGA, 0.0, 0.0, motion, motion, None, (0.0, 0.0, 0.0), None)
    frame = frame_at(piece, s)
    across = 0.0
    if curve is not None:
        across = 0.5 * curve.curvature * d * d
    x = frame.x[0] + d * frame.cos + across * frame.sin
    z = frame.z[0] - d * frame.sin + across * frame.cos
    at = contact_at(frame, x, z, u, w, curve)
    rx, rz = x - frame.x[0], z - frame.z[0]
    return bend_at(frame, GRAVITY, at, rx, u, curve), gap(piece, s, frame, 0.0, 0.0, rx, rz, u, w, GRAVITY, curve)[2]


@pytest.mark.parametrize("curve", [None, pack(Curve(13.3)), pack(Curve(-40.0))])
def test_bend_at_take_off_is_the_second_derivative_of_the_gap(curve):
    rng = np.random.default_rng(3)
    for _ in range(200):
        motion = tuple(rng.normal(size=6) * (1e-3, 1e-3, 0.05, 0.05, 5e-4, 5e-4))
        found, truth = both(motion, rng.uniform(0, 0.06), rng.normal() * 0.01, rng.normal(), rng.normal(), curve)
        assert found == pytest.approx(truth, rel=1e-11, abs=1e-9)
