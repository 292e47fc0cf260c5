"""The public simulation against closed forms, and its refusals."""

import math

import numpy as np
import pytest

from vr_envs.experiments.simulation import SimulationError, ball, bar_motion, scan, simulate
from vr_envs.models.ball_on_bar import Params
from vr_envs.models.ball_options import Curve, Frequencies, Friction, Ramp, Scatter, Spin

PARAMS = Params(frequency=15.0, restitution=0.68)
GRAVITY = PARAMS.gravity


def test_motion_has_the_peak_acceleration_and_phase_asked_for():
    motion = bar_motion(PARAMS, x=2.0, x_phase=0.3, tilt=50.0, tilt_phase=-1.1, z=8.0, z_phase=0.9)
    t = np.linspace(0.0, PARAMS.period, 50)
    w = PARAMS.omega
    for (cos, sin), rate, peak, phase in zip(
        motion.reshape(3, 2), (w, w, 2 * w), (2.0, 50.0, 8.0), (0.3, -1.1, 0.9), strict=True
    ):
        place = cos * np.cos(rate * t) + sin * np.sin(rate * t)
        np.testing.assert_allclose(rate**2 * place, peak * np.sin(rate * t + phase), atol=1e-12 * peak)


@pytest.mark.parametrize("z_phase", [math.pi / 2, 0.4, -2.0])
def test_period_one_is_the_closed_form_whatever_the_origin_of_time(z_phase):
    motion = bar_motion(PARAMS, z=10.4, z_phase=z_phase)
    cos = math.pi * GRAVITY * (1 - 0.68) / (1 + 0.68) / 10.4
    flight, amplitude = PARAMS.period / 2, 10.4 / (2 * PARAMS.omega) ** 2  # z moves at twice the base frequency
    # within 0.1 mm of the periodic orbit, as far after an impact as the origin of time asks for
    since = (z_phase - math.acos(cos)) % (2 * math.pi) / (2 * PARAMS.omega)
    speed = GRAVITY * flight / 2
    height = amplitude * math.sqrt(1 - cos**2) + (speed - GRAVITY / 2 * since) * since
    trace = simulate(PARAMS, motion, ball(motion, z=height + 1e-4, w=speed - GRAVITY * since), 300)
    last = trace.impacts[-20:]
    assert np.abs(last["phase"] - math.acos(cos)).max() < 1e-12
    np.testing.assert_allclose(last["w_out"], GRAVITY * flight / 2, rtol=1e-12)
    np.testing.assert_allclose(last["normal_out"], -0.68 * last["normal_in"], rtol=1e-14)
    apex = amplitude * math.sqrt(1 - cos**2) + GRAVITY * flight**2 / 8
    np.testing.assert_allclose(trace.apexes["z"][-10:], apex, rtol=1e-12)
    assert trace.free.all()


def test_departure_is_the_centre_of_the_ball_on_a_tilting_bar():
    """w_out and u_out are the velocities with which the next impact is reached."""
    params = Params(restitution=0.8)
    motion = bar_motion(params, x=4.0, tilt=60.0, tilt_phase=1.0, z=8.0)
    trace = simulate(params, motion, ball(motion, x=0.003, z=0.003, u=0.01), 40)
    first, second = trace.impacts[:-1][trace.free], trace.impacts[1:][trace.free]
    t = trace.flight_times[trace.free]
    assert len(t) > 30
    np.testing.assert_allclose(first["x"] + first["u_out"] * t, second["x"], atol=1e-15)
    np.testing.assert_allclose(first["z"] + (first["w_out"] - GRAVITY / 2 * t) * t, second["z"], atol=1e-15)


def test_samples_lie_on_the_flights_and_on_the_bar():
    motion = bar_motion(PARAMS, z=10.4)
    trace = simulate(PARAMS, motion, ball(motion, z=0.002), 15, sample_rate=500.0)
    t = trace.seconds(trace.samples)
    np.testing.assert_allclose(t, np.arange(500) / 500.0, atol=1e-12)
    np.testing.assert_allclose(
        trace.samples["bar_z"], motion[4] * np.cos(2 * PARAMS.omega * trace.samples["time"]), rtol=0, atol=1e-17
    )
    hits = trace.seconds(trace.impacts)
    before = np.searchsorted(hits, t, side="right") - 1
    flying = before >= 0
    start, since = trace.impacts[before[flying]], (t - hits[before])[flying]
    expected = start["z"] + start["w_out"] * since - GRAVITY / 2 * since**2
    np.testing.assert_allclose(trace.samples["z"][flying], expected, atol=1e-14)


@pytest.mark.parametrize(
    "options",
    [
        {"curve": Curve(13.0)},
        {"frequencies": Frequencies(x=1.3, tilt=0.7, z=2.2)},
        {"ramp": Ramp(x_cos=0.3, tilt_sin=5.0, z_cos=0.5)},
        {"spin": Spin(), "friction": Friction(0.1)},
    ],
    ids=lambda options: "-".join(options),
)
@pytest.mark.parametrize("hold", [1.0, 0.5])
def test_departure_holds_with_every_option_that_moves_or_bends_the_bar(options, hold):
    params = Params(restitution=0.8, hold=hold)
    motion = bar_motion(params, x=2.0, tilt=30.0, tilt_phase=1.0, z=8.0)
    rows = np.tile(motion, (round(20 / hold), 1))
    rows[::2] *= 1.05
    trace = simulate(params, rows, ball(motion, x=0.002, z=0.004, u=0.01), 20, options, sample_rate=400.0)
    assert not trace.lost
    assert trace.free.sum() > 15
    first, second = trace.impacts[:-1][trace.free], trace.impacts[1:][trace.free]
    t = trace.flight_times[trace.free]
    np.testing.assert_allclose(first["x"] + first["u_out"] * t, second["x"], atol=1e-14)
    np.testing.assert_allclose(first["z"] + (first["w_out"] - GRAVITY / 2 * t) * t, second["z"], atol=1e-14)
    np.testing.assert_allclose(trace.seconds(trace.samples), np.arange(len(trace.samples)) / 400.0, atol=1e-12)


def test_a_ramp_raises_the_bar_from_cycle_to_cycle():
    motion = bar_motion(PARAMS, z=5.0)
    trace = simulate(PARAMS, motion, ball(motion, z=0.002), 300, {"ramp": Ramp(z_cos=0.1)}, sample_rate=15.0)
    expected = (5.0 + 0.1 * trace.seconds(trace.samples)) / (2 * PARAMS.omega) ** 2
    np.testing.assert_allclose(trace.samples["bar_z"], expected, rtol=1e-12)


def test_a_run_in_two_parts_is_the_same_bytes():
    motion = bar_motion(PARAMS, x=1.0, tilt=20.0, z=11.0)
    options = {"scatter": Scatter()}
    start = ball(motion, z=0.002, key=5)
    whole = simulate(PARAMS, motion, start, 60, options, sample_rate=700.0)
    first = simulate(PARAMS, motion, start, 23, options, sample_rate=700.0)
    second = simulate(PARAMS, motion, first.final, 37, options, sample_rate=700.0)
    assert whole.final.tobytes() == second.final.tobytes()
    for name in ("impacts", "samples"):
        joined = np.concatenate([getattr(first, name), getattr(second, name)])
        assert joined.tobytes() == getattr(whole, name).tobytes()


def test_a_scan_is_the_same_runs_one_by_one():
    motions = np.array([bar_motion(PARAMS, z=a) for a in (9.0, 11.0, 12.5, 15.0)])
    starts = np.repeat(ball(motions[0], z=0.002), 4)
    starts["motion"] = motions
    kept, counts, finals = scan(PARAMS, motions, starts, 20, 12)
    for j in range(4):
        before = simulate(PARAMS, motions[j], starts[j], 20)
        after = simulate(PARAMS, motions[j], before.final, int(finals[j]["steps"]) - 20)
        assert counts[j] == 12
        assert kept[j].tobytes() == after.impacts[:12].tobytes()
        assert finals[j].tobytes() == after.final.tobytes()


def test_a_following_scan_hands_the_ball_on():
    motions = np.array([bar_motion(PARAMS, z=a) for a in (9.0, 9.5)])
    start = ball(motions[0], z=0.002)
    kept, _, finals = scan(PARAMS, motions, start, 30, 4, follow=True)
    _, _, alone = scan(PARAMS, motions[0], start, 30, 4)
    second, _, _ = scan(PARAMS, motions[1], alone[0], 30, 4)
    assert kept[1].tobytes() == second[0].tobytes()
    assert finals["steps"][1] > finals["steps"][0]


def test_a_lost_ball_ends_the_run():
    motion = bar_motion(PARAMS, z=8.0)
    trace = simulate(PARAMS, motion, ball(motion, z=0.002, u=1.0), 100)
    assert trace.lost
    assert trace.final["steps"] < 100


def test_rests_are_not_flights():
    motion = bar_motion(PARAMS, z=10.4)
    trace = simulate(Params(frequency=15.0, restitution=0.1), motion, ball(motion, z=0.002), 20)
    assert 0 < np.count_nonzero(~trace.free) < 45
    assert (np.diff(trace.seconds(trace.apexes)) > 0).all()


MOTION = bar_motion(PARAMS, z=8.0)
START = ball(MOTION, z=0.002)


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: simulate(PARAMS, MOTION[:5], START, 3), r"shape \(5,\)"),
        (lambda: simulate(PARAMS, MOTION * np.nan, START, 3), "not finite"),
        (lambda: simulate(PARAMS, np.zeros((4, 6)), START, 3), r"\(3, 6\)"),
        (lambda: simulate(PARAMS, MOTION, START, 0), "at least 1"),
        (lambda: simulate(PARAMS, MOTION, START, 3, sample_rate=-1.0), "sample_rate"),
        (lambda: simulate(PARAMS, MOTION, START, 3, {"spni": Spin()}), "choose among scatter, spin"),
        (lambda: simulate(PARAMS, MOTION, START, 3, {"spin": True}), "ball_options.Spin"),
        (lambda: simulate(PARAMS, MOTION, START, 3, {"spin": Spin(radius=-1.0)}), r"spin\.radius"),
        (lambda: simulate(Params(restitution=2.0), MOTION, START, 3), r"params\.restitution"),
        (lambda: simulate({}, MOTION, START, 3), "give a vr_envs.models.ball_on_bar.Params"),
        (lambda: simulate(PARAMS, MOTION, 0.002, 3), r"made by ball\(\)"),
        (lambda: ball(MOTION, z=math.inf), "z = inf"),
        (lambda: ball(MOTION, key=-1), "key"),
        (lambda: ball(MOTION, key=1.5), "key"),
        (lambda: bar_motion(PARAMS, z=math.nan), "finite"),
        (lambda: scan(PARAMS, np.tile(MOTION, (3, 1)), np.repeat(START, 2), 1, 1), "2 of them|3 of them"),
        (lambda: scan(PARAMS, MOTION, START, -1, 1), "skip"),
        (lambda: simulate(PARAMS, MOTION, ball(MOTION, z=-0.001), 3), "under the bar's surface"),
        (lambda: simulate(Params(hold=3.0), MOTION, START, 3), "hold = 3"),
    ],
)
def test_bad_input_is_told(call, told):
    with pytest.raises(ValueError, match=told):
        call()


def test_too_many_events_are_an_error():
    """No losses and a gravity of 100 m/s^2: a ball almost at rest on the bar needs too many impacts in a cycle."""
    params = Params(frequency=0.5, restitution=1.0, gravity=100.0)
    motion = bar_motion(params)
    with pytest.raises(SimulationError, match="events"):
        simulate(params, motion, ball(motion, z=1e-10), 2)


def test_a_trace_tells_in_a_line_what_it_holds():
    trace = simulate(Params(), MOTION, ball(MOTION, z=0.002), 10, sample_rate=100.0)
    assert repr(trace) == f"Trace({len(trace.impacts)} impacts, {len(trace.samples)} samples)"
