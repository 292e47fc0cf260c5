"""Derivatives of the cycle map against the closed forms of the bouncing ball."""

import math

import numpy as np
import pytest

from vr_envs.models.ball_on_bar import Params
from vr_envs.models.ball_options import OPTIONS, Curve, Scatter, Spin
from vr_envs.models.linearised import CycleMap, smooth
from vr_envs.models.record import pack

GRAVITY = 9.81
TIGHT = 2e-9


def cycle_map(options=(), **params):
    """The map of a bar and ball with the given options."""
    given = dict(options)
    return CycleMap(pack(Params(**params)), [pack(given[n]) if n in given else None for n in OPTIONS])


def upright(a_map, acceleration, quadrature=0.0):
    """Up-and-down motion with the given peak accelerations of its two parts."""
    w = 2.0 * float(a_map.params["omega"])
    return np.array([0, 0, 0, 0, acceleration / w**2, quadrature / w**2])


def trace_of_an_impact(acceleration, alpha, m=1):
    """Luck and Mehta's map of one impact: 1 + alpha^2 + (1 + alpha)^2 a/g, a the bar's acceleration there."""
    cos = m * math.pi * GRAVITY * (1 - alpha) / (1 + alpha) / acceleration
    return 1 + alpha**2 - (1 + alpha) ** 2 * acceleration * math.sqrt(1 - cos**2) / GRAVITY


@pytest.mark.parametrize(
    ("alpha", "acceleration"), [(0.75, 8.0), (0.75, 5.0), (0.856, 3.0), (0.856, 12.0), (0.68, 10.4)]
)
@pytest.mark.parametrize("frequency", [15.0, 2.0])
def test_vertical_block_has_the_determinant_and_trace_of_the_formula(alpha, acceleration, frequency):
    a_map = cycle_map(restitution=alpha, frequency=frequency)
    orbit = a_map.orbit(upright(a_map, acceleration))
    block = orbit.map.state[2:4, 2:4]
    trace = trace_of_an_impact(acceleration, alpha)
    assert np.linalg.det(block) == pytest.approx(alpha**4, rel=TIGHT)
    assert np.trace(block) == pytest.approx(trace**2 - 2 * alpha**2, rel=TIGHT, abs=TIGHT)
    assert orbit.map.error < 1e-7
    assert len(orbit.map.times) == 2


@pytest.mark.parametrize("half", [0, 1])
def test_an_impact_in_every_second_cycle_of_z(half):
    alpha, acceleration = 0.75, 11.0
    a_map = cycle_map(restitution=alpha)
    orbit = a_map.orbit(upright(a_map, acceleration), m=2, half=half)
    block = orbit.map.state[2:4, 2:4]
    assert np.linalg.det(block) == pytest.approx(alpha**2, rel=TIGHT)
    assert np.trace(block) == pytest.approx(trace_of_an_impact(acceleration, alpha, 2), rel=TIGHT)
    (time,) = orbit.map.times
    assert half * 0.5 < time / float(a_map.params["period"]) < 0.5 + half * 0.5


def test_a_flat_frictionless_bar_is_neutral():
    a_map = cycle_map(tangential_loss=0.0)
    orbit = a_map.orbit(upright(a_map, 8.0))
    flight = float(a_map.params["period"])
    assert np.allclose(orbit.map.state[:2, :2], [[1, flight], [0, 1]], rtol=0, atol=1e-12)
    assert np.abs(orbit.map.state[:2, 2:]).max() < 1e-12 and np.abs(orbit.map.state[2:, :2]).max() < 1e-12
    assert abs(orbit.growth) < 1e-6  # a Jordan block: rounding of its entries counts by its square root


@pytest.mark.parametrize("loss", [0.0, 2 / 7, 0.6])
@pytest.mark.parametrize("motion", [(4.0, 100.0, 0.4), (1.0, 200.0, -2.0)])
def test_area_shrinks_by_the_losses_of_the_impacts_whatever_the_motion(loss, motion):
    """Flight keeps area; an impact takes alpha^2 of it normally and 1 - c tangentially."""
    alpha = 0.8
    a_map = cycle_map(restitution=alpha, tangential_loss=loss)
    x, tilt, phase = motion
    w2 = float(a_map.params["omega"]) ** 2
    parts = np.array([x / w2, 0.2 * x / w2, tilt / w2 * math.sin(phase), tilt / w2 * math.cos(phase), 0, 0])
    orbit = a_map.orbit(parts + upright(a_map, 8.0))
    assert np.linalg.det(orbit.map.state) == pytest.approx(alpha**4 * (1 - loss) ** 2, rel=1e-8)


def test_a_change_of_the_lasting_motion_moves_the_orbit_as_the_closed_form_says():
    a_map = cycle_map()
    motion, span = upright(a_map, 8.0, -1.0), 1e-5 * upright(a_map, 8.0)[4]
    orbit = a_map.orbit(motion)
    lasting = orbit.map.old + orbit.map.new
    moved = np.linalg.solve((np.eye(4) - orbit.map.state)[2:, 2:], lasting[2:, 4:])
    for k in (4, 5):
        step = span * np.eye(6)[k]
        formula = (a_map.period_one(motion + step) - a_map.period_one(motion - step)) / (2 * span)
        assert moved[:, k - 4] == pytest.approx(formula[2:], rel=1e-7)


def test_the_bar_drags_the_ball_along_by_the_part_lost():
    """On a flat bar each impact takes the part c of the difference to the bar's velocity, during a blend too."""
    loss = 0.4
    a_map = cycle_map(tangential_loss=loss)
    orbit = a_map.orbit(upright(a_map, 8.0))
    w, period, blend = (float(a_map.params[k]) for k in ("omega", "period", "blend"))
    (t1, t2), blend = orbit.map.times, blend * period

    def velocity(t, share, rate):
        """Of the bar at t, per unit of a part that has reached `share` of itself and grows at `rate`."""
        c, s = math.cos(w * t), math.sin(w * t)
        return np.array([rate * c - share * w * s, rate * s + share * w * c])

    u = t1 / blend
    weight, slope = u * u * (3 - 2 * u), 6 * u * (1 - u) / blend
    assert t1 < blend < t2
    for found, first, second in (
        (orbit.map.new, velocity(t1, weight, slope), velocity(t2, 1.0, 0.0)),
        (orbit.map.old, velocity(t1, 1 - weight, -slope), np.zeros(2)),
    ):
        kick1, kick2 = loss * first, loss * (second - loss * first)
        assert found[1, :2] == pytest.approx(kick1 + kick2, abs=1e-8)
        assert found[0, :2] == pytest.approx(kick1 * (period - t1) + kick2 * (period - t2), abs=1e-10)


def betas(a_map, beta):
    """The curved bar for which beta = curvature * g * flight^2 at 15 Hz."""
    flight = 0.5 / 15.0
    return Curve(curvature=beta / (GRAVITY * flight**2))


@pytest.mark.parametrize("beta", [0.2, 1.0])
def test_a_frictionless_hollow_is_neutral(beta):
    a_map = cycle_map({"curve": betas(None, beta)}, tangential_loss=0.0, restitution=0.8)
    block = a_map.orbit(upright(a_map, 7.0)).map.state[:2, :2]
    assert np.linalg.det(block) == pytest.approx(1.0, rel=TIGHT)
    assert np.trace(block) == pytest.approx((2 - beta) ** 2 - 2, abs=1e-8)


@pytest.mark.parametrize("beta", [0.2, 1.0])
def test_a_ball_that_sticks_in_a_hollow_closes_in_at_the_rate_of_the_formula(beta):
    alpha = 0.8
    a_map = cycle_map({"curve": betas(None, beta)}, tangential_loss=1.0, restitution=alpha)
    orbit = a_map.orbit(upright(a_map, 7.0))
    largest = np.abs(np.linalg.eigvals(orbit.map.state[:2, :2])).max()
    assert largest == pytest.approx((1 - beta * alpha / (1 + alpha)) ** 2, rel=1e-8)
    assert orbit.growth == pytest.approx(math.log(largest) / (2 * math.pi), rel=1e-8)


@pytest.mark.parametrize(("beta", "radius"), [(0.2, 0.987), (0.5, 0.968), (1.0, 0.934)])
def test_a_spinning_sphere_in_a_hollow_closes_in(beta, radius):
    a_map = cycle_map({"curve": betas(None, beta), "spin": Spin()}, restitution=0.8)
    state = a_map.orbit(upright(a_map, 7.0)).map.state
    block = state[np.ix_([0, 1, 4], [0, 1, 4])]
    assert np.abs(np.linalg.eigvals(block)).max() == pytest.approx(radius**2, abs=1.5e-3)


def test_the_orbit_is_its_own_mirror_image_after_half_a_cycle():
    a_map = cycle_map()
    w2 = float(a_map.params["omega"]) ** 2
    motion = np.array([4, 1, 100, -50, 0, 0]) / w2 + upright(a_map, 8.0, 0.5)
    orbit = a_map.orbit(motion)
    half = a_map.derivative(orbit.ball, motion, motion, 0.5 * float(a_map.params["period"]))
    assert half.image * [-1, -1, 1, 1] == pytest.approx(orbit.ball, rel=1e-9, abs=1e-15)
    assert orbit.map.image == pytest.approx(orbit.ball, rel=1e-9, abs=1e-15)
    mirrored = np.diag([-1.0, -1, 1, 1]) @ half.state
    assert mirrored @ mirrored == pytest.approx(orbit.map.state, rel=1e-7, abs=1e-8)


def test_what_has_no_derivative_is_refused_with_the_reason():
    params, given = pack(Params()), pack(Scatter())
    options = [given if name == "scatter" else None for name in OPTIONS]
    with pytest.raises(ValueError, match="'scatter'"):
        CycleMap(params, options)
    assert all(o is None for o in smooth(options))
    a_map = CycleMap(params, smooth(options))
    with pytest.raises(ValueError, match=r"4 m/s\^2; period one with m = 1 needs at least 4.40"):
        a_map.orbit(upright(a_map, 4.0))
    still = upright(a_map, 0.5)
    with pytest.raises(ValueError, match="rest"):
        a_map.derivative(np.array([0.0, 0.0, still[4] + 1e-9, 0.0]), still, still)
    with pytest.raises(ValueError, match="leaves"):
        a_map.derivative(np.array([0.03, 0.0, 0.001, 0.0]), still, still)
    # the impact falls on the section where the phase of z is that of the impact
    phase = math.pi / 2 - math.acos(math.pi * GRAVITY / 7 / 8.0)
    with pytest.raises(ValueError, match="at the start of the cycle"):
        a_map.orbit(upright(a_map, 8.0 * math.cos(phase), 8.0 * math.sin(phase)))
