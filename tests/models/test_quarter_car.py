"""The quarter car by itself: its linear system, its contacts to rounding, its energy."""

import math

import mpmath
import numpy as np
import pytest
from scipy.linalg import expm

from vr_envs.models.constants import G
from vr_envs.models.quarter_car import check_stiffness, drive, lift_off, settle
from vr_envs.models.record import dtype_of, pack
from vr_envs.models.ride_options import Tyre
from vr_envs.models.terrain_ride import Params, State
from vr_envs.models.travel_stop import TravelStop

FIELDS = ("travel", "velocity", "deflection", "hub_velocity")
PARAMS, TYRE, STOP = Params(), Tyre(), TravelStop()
RECORDS = pack(PARAMS), pack(TYRE), pack(STOP)
LIMIT = (PARAMS.mass + TYRE.unsprung_mass) * G / TYRE.rate


def at(*x, payload=0.0):
    state = np.zeros(1, dtype_of(State))[0]
    for name, value in zip(FIELDS, x, strict=True):
        state[name] = value
    state["payload"] = payload
    return state


def x_of(state):
    return np.array([float(state[name]) for name in FIELDS])


def test_a_stiff_wheel_is_refused_with_what_to_do():
    check_stiffness(PARAMS, TYRE, STOP)
    with pytest.raises(ValueError, match=r"unsprung_mass = 0.1 .* 100000 1/s.* heavier"):
        check_stiffness(Params(mass=1e5), Tyre(unsprung_mass=0.1), None)


def run(state, t, gamma=3.0, w2=58.0, force=0.0, slope=0.0, speed=20.0, acceleration=0.0, records=RECORDS, stop=True):
    """`drive` over a plane."""
    params, tyre, rubber = records
    drive(state, t, gamma, w2, force, slope, speed, acceleration, params, None, tyre, rubber if stop else RECORDS[2])


def matrix(gamma, w2, grip, ratio, relative=1.0):
    """x' = A x of the linear quarter car, written down from Newton's laws."""
    pull = relative * gamma
    return np.array(
        [
            [0.0, 1.0, 0.0, -1.0],
            [-w2, -gamma, 0.0, pull],
            [0.0, 0.0, 0.0, 1.0],
            [ratio * w2, ratio * pull, -grip, -ratio * pull],
        ]
    )


@pytest.mark.parametrize("damping", ["relative", "absolute"])
@pytest.mark.parametrize("gamma", [1e-3, 1.0, 10.0, 300.0])
def test_agrees_with_the_matrix_exponential(damping, gamma):
    """Over a sloping road, changing speed, with force and payload: a linear system with inputs that vary evenly."""
    records = (pack(Params(damping=damping)), *RECORDS[1:])
    ratio, grip = PARAMS.mass / TYRE.unsprung_mass, TYRE.rate / TYRE.unsprung_mass
    rng = np.random.default_rng(0)
    for t in (1e-6, 1e-3, 0.01, 0.3):
        w2, force, payload = rng.uniform(20, 120), rng.uniform(-0.4, 0.4), rng.uniform(-0.4, 0.4)
        slope, speed, acceleration = rng.uniform(-0.003, 0.003), 15.0, rng.uniform(-3.0, 3.0)
        start = rng.uniform(-1, 1, 4) * (0.01, 0.1, 0.002, 0.1)
        whole = np.zeros((6, 6))  # x, 1, time
        whole[:4, :4] = matrix(gamma, w2, grip, ratio, float(damping == "relative"))
        whole[:4, 4] = 0.0, force + payload, -slope * speed, -ratio * force
        whole[2, 5] = -slope * acceleration
        whole[5, 4] = 1.0
        expected = (expm(whole * t) @ np.array([*start, 1.0, 0.0]))[:4]
        state = at(*start, payload=payload)
        run(state, t, gamma, w2, force, slope, speed, acceleration, records)
        assert (state["side"], state["airborne"], state["liftoffs"]) == (0.0, 0, 0)
        size = np.array([0.01, 0.1, 0.002, 0.1])
        assert np.abs(x_of(state) - expected).max() < 2e-13 * max(1.0, np.abs(expected / size).max())


@pytest.mark.parametrize(
    ("vehicle", "body", "hop"),
    [((290.0, 59.0, 16812.0, 190e3), (1.1, 1.2), (9.3, 9.5)), ((400.0, 40.0, 20e3, 210e3), (1.05, 1.15), (11.9, 12.2))],
)
def test_eigenfrequencies_of_body_and_wheel(vehicle, body, hop):
    """Two published vehicles: the body near 1.1 to 1.2 Hz, the wheel at 9.4 and 12 Hz."""
    sprung, unsprung, spring, tyre = vehicle
    records = pack(Params(mass=sprung, spring_rate=spring)), pack(Tyre(unsprung_mass=unsprung, rate=tyre)), RECORDS[2]
    step, columns = 1e-3, []
    for i in range(4):
        state = at(*(1e-3 * np.eye(4)[i]))
        run(state, step, 0.0, spring / sprung, records=records)
        columns.append(x_of(state) / 1e-3)
    values = np.linalg.eigvals(np.array(columns).T)
    assert np.abs(values) == pytest.approx(np.ones(4), rel=1e-12)
    slow, fast = np.sort(np.abs(np.angle(values)))[::2] / (2 * math.pi * step)
    assert body[0] < slow < body[1]
    assert hop[0] < fast < hop[1]


def flight(start, gamma, w2, payload):
    """Times (40 digits) of lift-off and landing on level ground, by the matrix exponential and bisection."""
    with mpmath.workdps(40):
        mass, hub, rate = (mpmath.mpf(v) for v in (PARAMS.mass, TYRE.unsprung_mass, TYRE.rate))
        ratio, limit = mass / hub, (mass + hub) * mpmath.mpf(G) / rate
        gamma, w2, payload = mpmath.mpf(gamma), mpmath.mpf(w2), mpmath.mpf(payload)

        def moved(x, t, grip, weight):
            a = mpmath.matrix(5, 5)
            a[0, 1], a[0, 3] = 1, -1
            a[1, 0], a[1, 1], a[1, 3], a[1, 4] = -w2, -gamma, gamma, payload
            a[2, 3] = 1
            a[3, 0], a[3, 1], a[3, 2], a[3, 3], a[3, 4] = ratio * w2, ratio * gamma, -grip, -ratio * gamma, -weight
            return mpmath.expm(a * t) * mpmath.matrix([*x, 1])

        def first(x, grip, weight, sign):
            step = mpmath.mpf("0.001")
            t = next(k * step for k in range(1, 100) if sign * (moved(x, k * step, grip, weight)[2] - limit) < 0)
            return mpmath.findroot(
                lambda s: moved(x, s, grip, weight)[2] - limit, (t - step, t), solver="anderson", tol=1e-38
            )

        up = first([mpmath.mpf(v) for v in start], rate / hub, mpmath.mpf(0), -1)
        x = moved([mpmath.mpf(v) for v in start], up, rate / hub, mpmath.mpf(0))
        down = first(list(x)[:4], mpmath.mpf(0), (1 + ratio) * mpmath.mpf(G), 1)
        return float(up), float(down)


@pytest.mark.parametrize(
    ("start", "gamma", "w2", "payload"),
    [
        ((0.0, 0.0, 0.0, 2.0), 3.0, 58.0, 0.0),
        ((0.03, 0.4, 0.01, 1.1), 0.3, 29.0, 0.7),
        ((-0.01, 0.3, -0.02, 2.9), 6.0, 115.0, 1.0),
        ((0.0, 0.0, 0.0, 1.15), 1.0, 58.0, 0.0),  # in the air for 5.5 ms
    ],
)
def test_lift_off_and_landing_times_to_forty_digits(start, gamma, w2, payload):
    """The clock stops at 1e-14 s: hundred times the rounding of a deflection of 20 mm at 1 m/s."""
    up, down = flight(start, gamma, w2, payload)
    state = at(*start, payload=payload)
    run(state, up + 0.5 * down, gamma, w2)
    assert state["airborne"]
    assert up + 0.5 * down - state["airborne_time"] == pytest.approx(up, abs=1e-14)
    run(state, 0.5 * down + 1e-3, gamma, w2)
    assert (state["airborne"], state["liftoffs"]) == (0, 1)
    assert state["airborne_time"] == pytest.approx(down, abs=1e-14)


def energy(state, w2, payload):
    """Of the whole vehicle on level ground, over the sprung mass."""
    travel, velocity, deflection, hub_velocity = x_of(state)
    ratio, grip = PARAMS.mass / TYRE.unsprung_mass, TYRE.rate / PARAMS.mass
    rubber = STOP.rate / PARAMS.mass * max(0.0, abs(travel) - STOP.travel) ** 2
    pressed = min(deflection, LIMIT)
    total = velocity**2 + hub_velocity**2 / ratio + w2 * travel**2 + rubber + grip * pressed**2
    return 0.5 * total + grip * LIMIT * (deflection - pressed) - payload * (travel + deflection)


def test_energy_is_kept_without_damper_through_contacts_of_tyre_and_stops():
    state, w2 = at(0.05, -1.2, 0.004, 2.5, payload=0.6), 58.0
    before, landings, touches = energy(state, w2, 0.6), 0, 0
    for _ in range(2000):
        side, airborne = float(state["side"]), int(state["airborne"])
        run(state, 0.01, 0.0, w2)
        assert energy(state, w2, 0.6) == pytest.approx(before, rel=2e-12)
        touches += side == 0.0 and state["side"] != 0.0
        landings += airborne and not state["airborne"]
    assert not state["fault"]
    assert landings > 20
    assert touches > 20


def test_payload_settles_on_spring_and_tyre():
    state = at(0.6 / 58.0, 0.0, 0.0, 0.0, payload=0.6)
    settle(state, *RECORDS[:2])
    assert lift_off(*RECORDS[:2]) == pytest.approx(LIMIT, rel=1e-15)
    assert state["deflection"] == pytest.approx(0.6 * PARAMS.mass / TYRE.rate)
    before = x_of(state)
    run(state, 1.0, 3.0, 58.0)
    assert x_of(state) == pytest.approx(before, abs=1e-16)


def test_a_force_between_body_and_hub_moves_no_centre_of_mass():
    """Off the ground everything falls as one: the force is inner, the payload is not."""
    for force, payload in ((4.0, 0.0), (0.0, 0.5)):
        state = at(0.01, 1.0, 0.3, 1.5, payload=payload)
        state["airborne"] = True
        mass, hub = PARAMS.mass, TYRE.unsprung_mass
        before = mass * state["velocity"] + hub * state["hub_velocity"]
        run(state, 0.02, 3.0, 58.0, force)
        after = mass * state["velocity"] + hub * state["hub_velocity"]
        assert (after - before) / 0.02 == pytest.approx(mass * payload - (mass + hub) * G, rel=1e-12)


@pytest.mark.parametrize("airborne", [False, True])
@pytest.mark.parametrize("rate", [-1e-3, -1e-15, 0.0, 1e-15, 1e-3])
@pytest.mark.parametrize("side", [-1.0, 0.0, 1.0])
def test_a_start_on_both_limits_at_once_is_no_trouble(airborne, rate, side):
    """At the limit of the tyre and of a stop, hardly moving, on any side of either: forces are the same on both."""
    ends = []
    for flag, contact in ((airborne, side), (not airborne, 1.0 if side == 0.0 else 0.0)):
        state = at(math.copysign(STOP.travel, side or 1.0), rate, lift_off(*RECORDS[:2]), rate)
        state["airborne"], state["side"] = flag, contact
        run(state, 0.01)
        assert not state["fault"]
        ends.append(x_of(state))
    assert ends[0] == pytest.approx(ends[1], abs=1e-14)


def test_random_bounces_never_fault_and_split_anywhere():
    """From the whole range of a rough ride, slopes that change: the state is the same by one step and by three."""
    rng, contacts = np.random.default_rng(3), 0
    whole, parts = at(0.0, 0.0, 0.0, 0.0), at(0.0, 0.0, 0.0, 0.0)
    for _ in range(3000):
        slope, gamma, share = rng.normal(0.0, 0.09), math.exp(rng.uniform(0.0, 2.3)), np.sort(rng.uniform(0, 0.01, 2))
        run(whole, 0.01, gamma, slope=slope)
        for piece in np.diff([0.0, *share, 0.01]):
            run(parts, piece, gamma, slope=slope)
        assert x_of(parts) == pytest.approx(x_of(whole), abs=1e-12)
        contacts += whole["airborne"] + abs(whole["side"])
        for name in FIELDS:
            parts[name] = whole[name]
    assert not whole["fault"]
    assert whole["liftoffs"] == parts["liftoffs"] > 100
    assert whole["touches"] == parts["touches"] > 100
    assert contacts > 200
