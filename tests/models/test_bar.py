"""Kinematics of the bar against differentiation in 40 digits, and the bounds that certify the impact search."""

import math

import mpmath as mp
import numpy as np
import pytest

from vr_envs.models.ball_options import Frequencies, Ramp
from vr_envs.models.bar import Piece, bounds, drift_of, frame_at, increments
from vr_envs.models.record import pack

OMEGA = 2 * math.pi * 15
RNG = np.random.default_rng(1)
SIZES = np.array([1e-3, 1e-3, 0.01, 0.01, 3e-4, 3e-4])
MOTIONS = [(tuple(SIZES * RNG.uniform(-1, 1, 6)), tuple(SIZES * RNG.uniform(-1, 1, 6))) for _ in range(4)]
PLAIN = None, (0.0, 0.0, 0.0), None
FREE = pack(Frequencies(1.0, 0.7, 1.9)), (0.3, 1.0, -2.0)
RAMP = pack(Ramp(8.0, -3.0, 100.0, 50.0, 9.0, 2.0))
PIECES = (
    [Piece(OMEGA, 0.0, 1 / 30, base, change, *PLAIN) for base, change in MOTIONS]
    + [Piece(OMEGA, 0.0, 0.0, base, base, *PLAIN) for base, _ in MOTIONS]
    + [
        Piece(OMEGA, -1 / 60, 1 / 15, *MOTIONS[0], *PLAIN),
        Piece(OMEGA, 0.0, 1 / 30, *MOTIONS[0], *FREE, None),
        Piece(OMEGA, 0.0, 1 / 30, *MOTIONS[0], None, (0.0, 0.0, 0.0), RAMP),
        Piece(OMEGA, 0.0, 0.0, *MOTIONS[0], *FREE, RAMP),
    ]
)


def exact(piece, s):
    """(x, tilt, z) at time s, in the working precision."""
    s, w = mp.mpf(s), mp.mpf(piece.omega)
    u = (s - piece.begin) / piece.blend if piece.blend else mp.mpf(0)
    weight = u * u * (3 - 2 * u)
    drift = [0] * 6 if piece.ramp is None else drift_of(piece.omega, piece.ramp)
    m = [
        mp.mpf(b) + weight * mp.mpf(c) + s * mp.mpf(d) for b, c, d in zip(piece.base, piece.change, drift, strict=True)
    ]
    f = piece.frequencies
    ratios = (1, 1, 2) if f is None else [mp.mpf(float(f[n])) for n in ("x", "tilt", "z")]
    angles = [r * w * s + mp.mpf(p) for r, p in zip(ratios, piece.phase, strict=True)]
    return [m[2 * i] * mp.cos(a) + m[2 * i + 1] * mp.sin(a) for i, a in enumerate(angles)]


@pytest.fixture(autouse=True)
def forty_digits():
    with mp.workdps(40):
        yield


@pytest.mark.parametrize("piece", PIECES)
def test_frame_is_the_motion_and_its_derivatives(piece):
    for s in (0.0, 0.004, 0.013, 0.0301):
        frame = frame_at(piece, s)
        for i, values in enumerate((frame.x, frame.tilt, frame.z)):
            for order, value in enumerate(values):
                truth = mp.diff(lambda t: exact(piece, t)[i], s, order) if order else exact(piece, s)[i]  # noqa: B023
                scale = SIZES[2 * i] * (2 * OMEGA) ** order
                assert abs(value - truth) < 1e-14 * scale * 10


@pytest.mark.parametrize("piece", PIECES)
@pytest.mark.parametrize("ds", [1e-12, 1e-9, 1e-6, 1e-3, 1e-2])
def test_increments_keep_their_digits_however_short(piece, ds):
    s = 0.0123
    mine = increments(piece, frame_at(piece, s), s, ds)
    end = mp.mpf(s) + mp.mpf(ds)
    for i in range(3):
        truth = exact(piece, end)[i] - exact(piece, mp.mpf(s))[i]
        scale = SIZES[2 * i] * min(1.0, 2 * OMEGA * ds)
        assert abs(mine[i][0] - truth) < 2e-14 * scale
        after = frame_at(piece, s + ds)[i]
        assert mine[i][1] == pytest.approx(after[1], rel=1e-11, abs=1e-13 * SIZES[2 * i] * OMEGA)
        assert mine[i][2] == pytest.approx(after[2], rel=1e-11, abs=1e-13 * SIZES[2 * i] * OMEGA**2)


@pytest.mark.parametrize("piece", PIECES)
def test_bounds_hold_everywhere_on_the_piece(piece):
    limits = bounds(piece)
    end = piece.begin + piece.blend if piece.blend else 1 / 15
    worst = np.zeros((3, 4))
    for s in np.linspace(0.0, end, 500):
        frame = frame_at(piece, s)
        worst = np.maximum(worst, np.abs([frame.x, frame.tilt, frame.z]))
    for i in range(3):
        assert (worst[i] <= np.array(limits[i][:4]) * (1 + 1e-12)).all()
        # a bound that is far too wide would be safe, and slow
        assert (worst[i] * 6 >= limits[i][:4]).all()


def test_two_pieces_join_with_the_same_position_and_velocity():
    old, change = MOTIONS[0]
    new = tuple(a + b for a, b in zip(old, change, strict=True))
    blended, kept, before = (
        Piece(OMEGA, 0.0, 1 / 30, old, change, *PLAIN),
        Piece(OMEGA, 0.0, 0.0, new, new, *PLAIN),
        Piece(OMEGA, 0.0, 0.0, old, old, *PLAIN),
    )
    for a, b, s in [(blended, kept, 1 / 30), (before, blended, 0.0)]:
        left, right = frame_at(a, s), frame_at(b, s)
        for i in range(3):
            assert left[i][0] == pytest.approx(right[i][0], abs=1e-16)
            assert left[i][1] == pytest.approx(right[i][1], abs=1e-13)
