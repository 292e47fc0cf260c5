import math

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vr_envs.models.spring import free_motion
from vr_envs.models.travel_stop import move_with_stop, time_to_contact

GAMMA, W2, W2_STOP, TRAVEL = 1.2, 58.0, 860.0, 0.08


def reference(u, rate, push, t, gamma=GAMMA):
    """Restarted DOP853 at 1e-13: u, its rate and the times of all contacts."""

    def phase(side):
        def equation(_, y):
            return y[1], push - gamma * y[1] - W2 * y[0] - abs(side) * W2_STOP * (y[0] - side * TRAVEL)

        def boundary(sign):
            def event(_, y):
                return sign * y[0] - TRAVEL

            vars(event).update(terminal=True, direction=1.0 if side == 0 else -1.0)
            return event

        return equation, [boundary(s) for s in ((1.0, -1.0) if side == 0 else (side,))]

    side, now, contacts = 0.0, 0.0, []
    while True:
        equation, events = phase(side)
        solution = solve_ivp(equation, (now, t), (u, rate), "DOP853", rtol=1e-13, atol=1e-16, events=events)
        (u, rate), now = solution.y[:, -1], solution.t[-1]
        if solution.status == 0:
            return u, rate, contacts
        contacts.append(now)
        side = math.copysign(1.0, u) if side == 0.0 else 0.0
        u = math.copysign(TRAVEL, u)
        # step off the boundary by a time in which the motion is straight to rounding
        u, rate, now = u + 1e-12 * rate, rate + 1e-12 * (push - gamma * rate - W2 * u), now + 1e-12


@pytest.mark.parametrize("seed", range(12))
def test_agrees_with_a_restarted_integrator(seed):
    u, rate, push = np.random.default_rng(seed).uniform((-0.079, -3.0, -1.0), (0.079, 3.0, 1.0))
    t = 0.6
    expected_u, expected_rate, contacts = reference(u, rate, push, t)
    got = move_with_stop(u, rate, 0.0, GAMMA, W2, push, W2_STOP, TRAVEL, t)
    assert got[:2] == pytest.approx((expected_u, expected_rate), abs=2e-11)
    assert got[3] == (len(contacts) + 1) // 2
    assert got[2] == (math.copysign(1.0, expected_u) if len(contacts) % 2 else 0.0)
    if contacts:
        first = time_to_contact(u, rate, 0.0, GAMMA, W2, push, W2_STOP, TRAVEL, t)
        assert first == pytest.approx(contacts[0], abs=1e-12)


def test_contact_time_to_rounding():
    """Against 50-digit arithmetic, over the whole range of approach speeds."""
    for rate in (0.05, 0.3, 1.0, 10.0):
        t = time_to_contact(0.075, rate, 0.0, GAMMA, W2, 0.5, W2_STOP, TRAVEL, 10.0)
        with mpmath.workdps(50):
            e, half = mpmath.mpf(0.5) / W2, mpmath.mpf(GAMMA) / 2
            wd = mpmath.sqrt(W2 - half**2)
            x0 = mpmath.mpf(0.075) - e

            def gap(s, rate=rate, e=e, half=half, wd=wd, x0=x0):
                motion = x0 * mpmath.cos(wd * s) + (rate + half * x0) / wd * mpmath.sin(wd * s)
                return e + mpmath.exp(-half * s) * motion - mpmath.mpf(TRAVEL)

            if t == 10.0:
                assert all(gap(mpmath.mpf(k) / 1000) < 0 for k in range(1, 1000))
            else:
                assert t == pytest.approx(float(mpmath.findroot(gap, t)), rel=1e-15, abs=2e-16)


def test_grazing_contacts_are_found():
    """A first swing that passes the stop by 1e-9 m for some 1e-5 s is a touch; one that fails by as much is none."""
    t = 0.4
    peak_time = time_to_peak(0.0, 0.6)
    peak = free_motion(0.0, 0.6, GAMMA, W2, peak_time)[0]
    for past, touches in ((1e-9, 1), (-1e-9, 0)):
        got = move_with_stop(0.0, 0.6, 0.0, GAMMA, W2, 0.0, W2_STOP, peak - past, t)
        assert got[3] == touches
        assert got[2] == 0.0


def test_no_contact_is_missed():
    """Until the time returned, fine sampling sees the mass on one side of the boundary, whatever the regime."""
    rng = np.random.default_rng(4)
    early = 0
    for _ in range(600):
        gamma, w2, push, rate = rng.uniform((0, 10, -20, -4), (40, 900, 20, 4))
        side = rng.choice([-1.0, 0.0, 1.0])
        u = rng.uniform(-TRAVEL, TRAVEL) if side == 0.0 else side * (TRAVEL + rng.exponential(0.01))
        t = time_to_contact(u, rate, side, gamma, w2, push, W2_STOP, TRAVEL, 0.3)
        early += t < 0.3
        stiff = w2 + W2_STOP * abs(side)
        centre = (push + side * W2_STOP * TRAVEL) / stiff
        path = np.array([free_motion(u - centre, rate, gamma, stiff, s)[0] for s in np.linspace(0, t, 200)]) + centre
        gap = TRAVEL - abs(path) if side == 0.0 else side * path - TRAVEL
        assert gap.min() > -1e-15
        if t < 0.3:
            assert abs(gap[-1]) < 1e-15
    assert 100 < early < 600


def time_to_peak(u, rate):
    low, high = 0.0, 0.4
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if free_motion(u, rate, GAMMA, W2, middle)[1] > 0 else (low, middle)
    return low


def test_energy_is_kept_by_the_rubber_without_damping():
    u, rate, side, count = 0.0, 2.0, 0.0, 0
    for _ in range(500):
        u, rate, side, touches, fault = move_with_stop(u, rate, side, 0.0, W2, 0.0, W2_STOP, TRAVEL, 0.0137)
        count += touches
        assert not fault
        squeeze = max(0.0, abs(u) - TRAVEL)
        assert rate**2 + W2 * u**2 + W2_STOP * squeeze**2 == pytest.approx(4.0, rel=1e-12)
    assert count > 20


def test_splits_give_the_same_motion():
    rng = np.random.default_rng(3)
    for _ in range(200):
        u, rate, push = rng.uniform((-0.079, -2.0, -1.0), (0.079, 2.0, 1.0))
        whole = move_with_stop(u, rate, 0.0, GAMMA, W2, push, W2_STOP, TRAVEL, 0.2)
        parts, count = (u, rate, 0.0), 0
        for _ in range(20):
            *parts, touches, fault = move_with_stop(*parts, GAMMA, W2, push, W2_STOP, TRAVEL, 0.01)
            count += touches
        assert not fault
        assert (*parts, count) == pytest.approx(whole[:4], abs=1e-13)


@pytest.mark.parametrize("lift", [-5.0, 0.0, 5.0])
@pytest.mark.parametrize("side", [0.0, 1.0])
def test_rest_on_the_stop_goes_where_the_push_goes(lift, side):
    """At rest exactly on the boundary, in either phase, neither the search nor the phase gets stuck."""
    got = move_with_stop(TRAVEL, 0.0, side, 0.0, W2, W2 * TRAVEL + lift, W2_STOP, TRAVEL, 0.05)
    stiff = W2 + (W2_STOP if lift > 0 else 0.0)
    assert got[0] == pytest.approx(TRAVEL + lift / stiff * (1 - math.cos(math.sqrt(stiff) * 0.05)), abs=1e-14)
    assert got[1] == pytest.approx(lift / math.sqrt(stiff) * math.sin(math.sqrt(stiff) * 0.05), abs=1e-12)
    if lift:
        assert got[2] == float(lift > 0)


def test_more_contacts_than_are_followed_are_a_failure():
    rate, period = 3.0, 2 * math.pi / math.sqrt(W2)
    assert not move_with_stop(0.0, rate, 0.0, 0.0, W2, 0.0, W2_STOP, TRAVEL, 5 * period)[4]
    assert move_with_stop(0.0, rate, 0.0, 0.0, W2, 0.0, W2_STOP, TRAVEL, 100 * period)[4]


def test_a_march_ends_well_within_its_limit_even_where_the_mass_grazes_a_stop():
    """Linear convergence at a graze is slowest with strong damping; the search still ends, on either side."""
    for gamma in (0.0, 1.2, 12.0, 15.0):
        low, high = 0.0, 2.0
        for _ in range(60):  # bisection to the speed that just touches
            rate = 0.5 * (low + high)
            touches = move_with_stop(0.0, rate, 0.0, gamma, W2, 0.0, W2_STOP, TRAVEL, 0.4)[3]
            low, high = (low, rate) if touches else (rate, high)
        for rate in (low, high):
            assert time_to_contact(0.0, rate, 0.0, gamma, W2, 0.0, W2_STOP, TRAVEL, 0.4) >= 0.0
    # the longest search of 6000 such swings: decided by rounding, after 1802 steps
    longest = (0.0016478446065063407, 1.868289663130776, 0.0, 23.931530473061024, 3.066747536104477)
    assert time_to_contact(*longest, 0.23631326137946917, W2_STOP, TRAVEL, 0.358) > 0.0


def test_a_stiff_spring_swings_from_stop_to_stop_many_times_in_one_piece():
    """Without damping the energy stays, however many contacts there are: four in each of some fifty swings."""
    w2, rubber, travel = 1e9, 4e3, 0.05
    u, rate, side, touches, fault = move_with_stop(0.051, 0.0, 1.0, 0.0, w2, 0.0, rubber, travel, 0.01)
    assert not fault and touches > 90
    energy = [v * v + w2 * x * x + rubber * max(0.0, abs(x) - travel) ** 2 for x, v in ((0.051, 0.0), (u, rate))]
    assert energy[1] == pytest.approx(energy[0], rel=1e-12)
    assert (side != 0.0) == (abs(u) > travel)
