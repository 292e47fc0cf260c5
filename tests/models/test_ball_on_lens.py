"""The ball on a lens against 50 digits, a plane computation, and the laws of impact."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from tests.models.lens_reference import Reference
from vr_envs.experiments.lens_orbit import period_one_start
from vr_envs.experiments.lens_simulation import simulate
from vr_envs.models.ball_on_lens import LOGGED, MAX_IMPACTS, Params, State, cycle, plano_concave, rebound
from vr_envs.models.ball_options import Friction, Spin
from vr_envs.models.lens_flight import gap_at, surface_height
from vr_envs.models.record import dtype_of, pack


def record(state):
    return np.array([pack(state)], dtype_of(State))[0]


def started(params, spin_vector=(0.0, 0.0, 0.0), raised=0.0, **place):
    state = period_one_start(params, **place)
    names = dict(zip(("spin_x", "spin_y", "spin_z"), spin_vector, strict=True))
    return dataclasses.replace(state, z=state.z + raised, **names)


@pytest.mark.parametrize(
    ("overrides", "options", "start"),
    [
        pytest.param({}, {}, {"x": 0.008, "v": 0.05}, id="concave-frictionless"),
        pytest.param({"frequency": 20.0, "phase": -1.0}, {}, {"x": 0.01, "y": -0.004}, id="concave-twenty-hertz"),
        pytest.param({"tangential_loss": 0.3}, {}, {"x": 0.008, "v": 0.1}, id="concave-loss"),
        pytest.param(
            {}, {"spin": Spin()}, {"x": 0.01, "v": 0.08, "spin_vector": (0.02, -0.01, 0.3)}, id="concave-spin"
        ),
        pytest.param(
            {},
            {"spin": Spin(), "friction": Friction(0.05, 0.3)},
            {"x": 0.01, "v": 0.08, "spin_vector": (0.2, -0.1, 0.3)},
            id="concave-slip-then-grip",
        ),
        pytest.param({"curvature": -1.0}, {}, {"x": 1e-4, "v": 2e-4}, id="convex-frictionless"),
        pytest.param({"curvature": -1.0}, {"spin": Spin(2 / 3)}, {"x": 1e-4, "v": 2e-4}, id="convex-hollow-sphere"),
        pytest.param({"acceleration": 10.0, "restitution": 0.68}, {}, {"x": 0.01, "raised": 0.004}, id="transient"),
    ],
)
def test_impact_times_match_fifty_digits(overrides, options, start):
    params = dataclasses.replace(Params(), **overrides)
    state = started(params, **start)
    inertia_ratio = options["spin"].inertia_ratio if options else None
    reference = Reference(params, state, inertia_ratio, options.get("friction"))
    for number in range(40):
        reference.cycle(number)
    run = simulate(params, state, 40, **options)
    assert not run.end["lost"]
    assert not run.end["fault"]
    assert len(run.cycle) == len(reference.impacts) >= 36
    assert np.array_equal(run.cycle, [row[0] for row in reference.impacts])
    mine = np.column_stack([run.impacts[name] for name in ("time", "x", "y", "z")])
    error = np.array(
        [
            [float(a - b) for a, b in zip(row, theirs[1:], strict=True)]
            for row, theirs in zip(mine, reference.impacts, strict=True)
        ]
    )
    print(f"largest error over {len(error)} impacts: time {abs(error[:, 0]).max():.1e} s, {abs(error).max():.1e} m")
    assert np.abs(error[:, 0]).max() < 1e-13
    assert np.abs(error[:, 1:]).max() < 1e-13


def plane_impacts(params, state, cycles):
    """Impacts (time since the start, distance from the axis) of a frictionless ball in a plane, by angle and brentq."""
    rho = 1 / params.path_curvature
    g, place, z = params.gravity, state.x, state.z
    u, w, t, out = state.u, state.w, 0.0, []

    def lens(at):
        return params.amplitude * math.sin(params.omega * at + params.phase)

    def depth(since):
        h = z + w * since - g / 2 * since**2 - lens(t + since)
        return rho - math.hypot(place + u * since, h - rho)

    step = params.period / 500
    while True:
        a = step / 100
        while depth(a + step) > 0:
            a += step
        since = brentq(depth, a, a + step, xtol=1e-16, rtol=1e-14)
        if t + since > cycles * params.period:
            return np.array(out)
        t, place, z, w = t + since, place + u * since, z + w * since - g / 2 * since**2, w - g * since
        angle = math.asin(place / rho)
        climb = params.omega * params.amplitude * math.cos(params.omega * t + params.phase)
        inward = -u * math.sin(angle) + (w - climb) * math.cos(angle)
        u += (1 + params.restitution) * inward * math.sin(angle)
        w -= (1 + params.restitution) * inward * math.cos(angle)
        out.append((t, place))


def test_a_plane_through_the_axis_is_kept_and_is_the_plane_problem():
    params = Params()
    flat = started(params, x=0.009, u=0.03)
    expected = plane_impacts(params, flat, 60)
    run = simulate(params, flat, 60)
    assert np.all(run.impacts["y"] == 0.0)
    assert len(run.times) == len(expected) == 60
    assert np.abs(run.times - expected[:, 0]).max() < 1e-12
    assert np.abs(run.impacts["x"] - expected[:, 1]).max() < 1e-12
    turned = simulate(params, started(params, x=0.6 * 0.009, y=0.8 * 0.009, u=0.6 * 0.03, v=0.8 * 0.03), 60)
    x, y = turned.impacts["x"], turned.impacts["y"]
    assert np.abs(0.8 * x - 0.6 * y).max() < 1e-15
    assert np.abs(0.6 * x + 0.8 * y - expected[:, 1]).max() < 1e-12


@pytest.mark.parametrize("spin", [None, Spin()])
def test_the_ball_keeps_its_sense_of_travel_whichever_way_the_lens_is_seen_from(spin):
    """A mirror image of the start is the mirror image of the run; spin is an axial vector."""
    params = Params()
    right = simulate(params, started(params, (0.1, -0.2, 0.3), x=0.006, y=0.002, v=0.05), 100, spin).impacts
    left = simulate(params, started(params, (-0.1, -0.2, -0.3), x=0.006, y=-0.002, v=-0.05), 100, spin).impacts
    assert np.array_equal(right["x"], left["x"])
    assert np.array_equal(right["y"], -left["y"])


@pytest.mark.parametrize("frequency", [20.0, 30.0])
def test_angular_momentum_about_the_axis_is_kept_without_friction(frequency):
    params = Params(frequency=frequency)
    i = simulate(params, started(params, x=0.008, y=0.003, v=0.06), 2000).impacts
    momentum = i["x"] * i["v"] - i["y"] * i["u"]
    assert len(momentum) == 2000
    assert np.ptp(momentum) < 1e-12 * abs(momentum[0])


velocities = st.floats(-2.0, 2.0)
vectors = st.tuples(velocities, velocities, velocities)
parts = st.floats(0.0, 1.0)


limits = st.none() | st.builds(Friction, st.floats(0.0, 2.0), parts)


@given(
    vectors,
    vectors,
    st.floats(0.0, 1.5),
    st.floats(-3.2, 3.2),
    parts,
    parts,
    st.none() | st.builds(Spin, st.floats(0.01, 1.0)),
    limits,
)
def test_an_impact_obeys_its_laws(velocity, spinning, slope, direction, restitution, loss, spin, friction):
    normal = np.array([math.sin(slope) * math.cos(direction), math.sin(slope) * math.sin(direction), math.cos(slope)])
    velocity, spinning = np.array(velocity), np.array(spinning)
    if velocity @ normal > 0:
        velocity = -velocity
    params = pack(Params(restitution=restitution, tangential_loss=loss))
    after, spun, approach, leave = rebound(
        tuple(velocity),
        tuple(spinning),
        tuple(normal),
        params,
        None if spin is None else pack(spin),
        None if friction is None else pack(friction),
    )
    after, spun = np.array(after), np.array(spun)
    assert approach == pytest.approx(velocity @ normal, abs=1e-14)
    assert leave == pytest.approx(after @ normal, abs=1e-14)
    assert leave == pytest.approx(-restitution * approach, abs=1e-14)
    ratio = 0.0 if spin is None else spin.inertia_ratio
    before = velocity @ velocity + ratio * spinning @ spinning
    assert after @ after + ratio * spun @ spun <= before + 1e-13
    tangent, new_tangent = velocity - approach * normal, after - leave * normal
    if friction is not None:
        # the impulse along the surface is within the cone of friction
        most = friction.coefficient * (leave - approach)
        assert np.linalg.norm(new_tangent - tangent) <= most + 1e-13
    if spin is None:
        assert np.array_equal(spun, spinning)
        if friction is None:
            assert new_tangent == pytest.approx((1 - loss) * tangent, abs=1e-14)
    else:
        about_contact = np.cross(normal, velocity) + ratio * spinning
        assert np.cross(normal, after) + ratio * spun == pytest.approx(about_contact, abs=1e-13)
        if friction is None:
            assert new_tangent == pytest.approx(np.cross(spun, normal), abs=1e-13)  # no slip


@pytest.mark.parametrize("curvature", [plano_concave(0.15), 0.0, -20.0])
@pytest.mark.parametrize("launches", [150, pytest.param(20_000, marks=pytest.mark.slow)])
def test_no_first_impact_is_missed_by_grazing_launches(curvature, launches):
    """Launches just above the lens's velocity against a dense scan of the distance to the sphere's centre."""
    rng = np.random.default_rng(5)
    fine = np.linspace(0.0, 1.0, 4001)[1:]
    late = 0
    for _ in range(launches):
        acceleration = float(np.exp(rng.uniform(math.log(5.0), math.log(99.0))))
        params = Params(
            acceleration=acceleration,
            phase=rng.uniform(-math.pi, math.pi),
            curvature=curvature,
            half_aperture=0.04,
            restitution=0.5,
        )
        x, y = rng.uniform(-0.012, 0.012, 2)
        kappa = params.path_curvature
        h = surface_height(math.hypot(x, y), kappa) + 1e-12
        u, v = rng.normal(0.0, 0.1, 2)
        normal = np.array([-kappa * x, -kappa * y, 1 - kappa * h])
        out = float(np.exp(rng.uniform(math.log(1e-4), math.log(1.0))))
        climb = params.omega * params.amplitude * math.cos(params.phase)
        w = climb + (out - normal[0] * u - normal[1] * v) / normal[2]
        start = State(x=x, y=y, z=h + params.amplitude * math.sin(params.phase), u=u, v=v, w=w)
        log = np.full((MAX_IMPACTS + 1, len(LOGGED)), np.nan)
        state = record(start)
        cycle(state, pack(params), None, None, log)

        t = fine * params.period
        lens = params.amplitude * np.sin(params.omega * t + params.phase)
        px, py, ph = x + u * t, y + v * t, start.z + w * t - params.gravity / 2 * t**2 - lens
        gap = ph - kappa / 2 * (px**2 + py**2 + ph**2)
        if kappa:
            rho = 1 / kappa
            gap = np.sign(rho) * (abs(rho) - np.sqrt(px**2 + py**2 + (ph - rho) ** 2))
        below = np.flatnonzero(gap <= 0)
        found = log[0, 0] if state["impacts"] else np.inf
        if len(below) == 0:
            late += found > params.period
            assert found > params.period * (1 - 1e-3) or gap.min() < 1e-7
        else:
            expected = t[below[0]]
            assert found <= expected + 1e-12
            assert found >= expected - params.period / 4000 * 1.0001 or gap[: below[0]].min() < 1e-7
    assert late < launches / 2


@pytest.mark.parametrize("spin", [None, Spin()])
def test_the_ball_is_never_inside_the_glass(spin):
    rng = np.random.default_rng(4)
    for _ in range(30):
        params = Params(acceleration=rng.uniform(5, 40), curvature=rng.uniform(-15, 15), restitution=0.8)
        x, y = rng.uniform(-0.01, 0.01, 2)
        state = record(State(x=x, y=y, z=0.01, u=rng.normal(0, 0.05), v=rng.normal(0, 0.05)))
        packed = pack(params)
        for _ in range(60):
            cycle(state, packed, None if spin is None else pack(spin), None)
            if state["lost"] or state["fault"]:
                break
            assert gap_at(state, 0.0, packed)[0] > -1e-15


def test_a_ball_beyond_the_aperture_is_lost():
    params = Params(half_aperture=0.01)
    run = simulate(params, started(params, x=0.008, u=0.1), 300)
    assert run.end["lost"] == 1
    assert run.end["fault"] == 0
    # the last place is where the ball meets the sphere of which the lens is a part
    assert math.hypot(run.end["x"], run.end["y"]) > params.path_edge
    distances = np.hypot(run.impacts["x"], run.impacts["y"])
    assert distances.max() <= params.path_edge
    assert params.path_edge == pytest.approx(0.01 * (1 - 0.0025 / (0.15 * 0.517)), rel=1e-14)


def test_a_ball_that_falls_past_a_convex_lens_is_lost():
    params = Params(curvature=-20.0, half_aperture=0.02)
    run = simulate(params, State(x=0.06, z=0.01), 300)
    assert run.end["lost"] == 1
    assert len(run.cycle) == 0


@pytest.mark.parametrize("restitution", [0.0, 0.3])
def test_a_chatter_is_a_fault_and_not_a_silent_loop(restitution):
    run = simulate(Params(acceleration=4.0, restitution=restitution), State(z=0.003), 100)
    assert run.end["fault"] == 1
    assert run.end["lost"] == 0
    assert run.end["cycles"] < 20


def test_the_upper_half_of_the_sphere_is_no_lens():
    run = simulate(Params(), State(z=0.1, w=5.0, x=0.002), 100)
    assert run.end["fault"] == 1
    assert len(run.cycle) == 0


def test_focal_length_gives_the_radius_of_the_glass():
    """f = R_s / (n - 1) for a plano-concave lens: 77.55 mm for 15 cm and 103.4 mm for 20 cm of BK7."""
    assert 1 / plano_concave(0.15) == pytest.approx(0.07755)
    assert 1 / plano_concave(0.20) == pytest.approx(0.1034)
    assert 1 / Params().path_curvature == pytest.approx(0.07755 - 0.0025)
    assert 1 / Params(curvature=-10.0).path_curvature == pytest.approx(-0.1025)


def test_what_is_no_lens_is_refused():
    with pytest.raises(ValueError, match="ball_radius = 0.1 m does not fit"):
        Params(ball_radius=0.1)
    with pytest.raises(ValueError, match="half_aperture = 0.1 m is not allowed"):
        Params(half_aperture=0.1)
