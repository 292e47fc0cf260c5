"""Front, orders and the cost of a wanted error, on points whose answers are known."""

import dataclasses
import math

import pytest

from vr_envs.bench.accuracy import account
from vr_envs.bench.accuracy.front import front, order, reach
from vr_envs.bench.accuracy.picture import picture
from vr_envs.bench.accuracy.points import Measure, Method, Point, Run, measured
from vr_envs.bench.timing import Spread

TIME = Measure("impact time", "s", "largest over the impacts", 1e-15)
EXACT = Method("exact", "exact")
STEPS = Method("step's end", "fixed step", "step", fixed_step=True)
LOCATED = Method("bisection", "located step", "step")
ADAPTIVE = Method("RK45", "scipy", "tolerance")


def point(method, value, cost, error, episode="orbit"):
    return Point(method, episode, value, Spread(0.9 * cost, cost, 1.1 * cost), {TIME.name: error})


def power_law(p, steps=(1e-2, 1e-3, 1e-4), method=STEPS):
    """Error 0.3 h^p at a cost of 1e-8/h."""
    return [point(method, h, 1e-8 / h, 0.3 * h**p) for h in steps]


def test_front_is_what_nothing_beats():
    a, b, c = point(STEPS, 1, 1.0, 1e-3), point(STEPS, 2, 2.0, 1e-4), point(STEPS, 3, 4.0, 1e-6)
    worse = [point(STEPS, 4, 3.0, 1e-4), point(STEPS, 5, 2.0, 2e-4), point(STEPS, 6, 0.1, math.inf)]
    assert front([c, *worse, a, b], TIME) == [a, b, c]


def test_errors_below_rounding_are_the_same():
    cheap, dear = point(EXACT, None, 1.0, 8e-16), point(STEPS, 1, 2.0, 1e-17)
    assert front([dear, cheap], TIME) == [cheap]


@pytest.mark.parametrize("p", [0.5, 1.0, 2.0, 4.0])
def test_order_of_a_power_law(p):
    assert order(power_law(p), TIME) == pytest.approx(p, rel=1e-12)


def test_order_leaves_out_rounding_and_a_run_that_went_astray():
    points = [point(STEPS, 1.0, 1e-8, math.inf), *power_law(2.0), point(STEPS, 1e-9, 10.0, 5e-15)]
    assert order(points, TIME) == pytest.approx(2.0, rel=1e-12)
    assert order([point(EXACT, None, 1.0, 1e-3)], TIME) is None
    assert order(power_law(2.0)[:1], TIME) is None


def test_order_leaves_out_what_has_lost_the_reference():
    lost = [point(STEPS, 0.3, 3e-8, 5.0), *power_law(1.0)]
    bounded = Measure(TIME.name, "s", "", TIME.rounding, astray=1.0)
    assert order(lost, bounded) == pytest.approx(1.0, rel=1e-12) != order(lost, TIME)
    all_lost = [point(STEPS, h, 1e-8 / h, 2.0 * h**0.1) for h in (1e-2, 1e-3, 1e-4)]
    assert order(all_lost, Measure(TIME.name, "s", "", TIME.rounding, astray=0.1)) is None


def test_cost_of_an_error_between_two_points_is_interpolated():
    found = reach(power_law(2.0), TIME, 1e-6)
    assert found.how == "interpolated"
    assert found.cost == pytest.approx(1e-8 * math.sqrt(0.3 / 1e-6), rel=1e-12)


def test_cost_of_an_error_below_all_points_is_extrapolated_with_the_order():
    found = reach(power_law(1.0), TIME, 1e-9)
    assert found.how == "extrapolated"
    assert found.cost == pytest.approx(1e-8 * 0.3 / 1e-9, rel=1e-12)


def test_cheapest_point_that_is_good_enough_is_measured():
    found = reach([point(EXACT, None, 2e-5, 1e-12), point(EXACT, None, 4e-5, 1e-14)], TIME)
    assert (found.how, found.cost) == ("measured", 2e-5)
    coarse = reach(power_law(4.0), TIME, 1e-7)
    assert (coarse.how, coarse.cost) == ("at most", 1e-6)  # a longer step may do


@pytest.mark.parametrize(
    "points",
    [
        [point(STEPS, h, 1e-8 / h, 1e-3) for h in (1e-2, 1e-3, 1e-4)],  # levels off
        power_law(1.0, method=ADAPTIVE),  # what a smaller tolerance costs is not known
        [point(STEPS, 1e-3, 1.0, math.inf)],
    ],
)
def test_what_cannot_be_had_is_not_reached(points):
    found = reach(points, TIME, 1e-9)
    assert found.cost is None and found.how == "not reached"


def system(points):
    return account.System("toy", "Toy", [TIME], {"orbit": "an orbit"}, points)


def test_sentences_follow_the_numbers():
    good = system([point(EXACT, None, 3e-5, 1e-16), *power_law(1.0)])  # 3 s against 3e-5 s
    assert account.sentences(good) == [
        "Toy: the exact engine is on the front in the one pair of episode and error.",
        "Toy: at an error of 1e-09 the exact engine is 100,000 (orbit, impact time; extrapolated) times as fast as the "
        "best fixed step (1 of 1 extrapolated).",
        "Toy: at an error of 1e-09 no other method was tried in 1 of 1 pair.",
        "orbit, impact time to 1e-09 s: exact is 100,000 times as fast as the best fixed step (step's end, "
        "extrapolated at order 1.00); no other method was tried.",
    ]


def test_sentences_say_what_is_not_as_wanted():
    poor = system([point(EXACT, None, 0.1, 1e-12), point(LOCATED, 1e-3, 0.01, 1e-13), *power_law(1.0)])
    on_front, ratio, other, pair = account.sentences(poor)
    assert "in 0 of 1 pair" in on_front and "beaten by bisection, 0.001 s" in on_front
    assert "short of the 100 times wanted in 1 of 1 pair." in ratio
    assert "0.1 (orbit, impact time; at most) times as fast as the best other method (1 of 1 at most)." in other
    assert "30 times as fast as the best fixed step" in pair
    assert "at least 10 times as slow as the best other method (bisection)" in pair
    slow = system([point(EXACT, None, 6.0, 1e-12), *power_law(1.0)])
    assert "2 times as slow as the best fixed step" in account.sentences(slow)[3]
    missed = system([point(EXACT, None, 0.1, 1e-3), *power_law(1.0)])
    assert account.sentences(missed)[1].endswith("1e-09 the exact engine itself does not reach it in 1 of 1 pair.")
    assert "does not reach" in account.sentences(missed)[3]


def test_a_pair_without_a_fixed_step_that_converges_is_counted():
    level = [point(STEPS, h, 1e-8 / h, 1e-3, "chaos") for h in (1e-2, 1e-3, 1e-4)]
    points = [point(EXACT, None, 3e-5, 1e-16), *power_law(1.0), point(EXACT, None, 3e-5, 1e-16, "chaos"), *level]
    toy = account.System("toy", "Toy", [TIME], {"orbit": "an orbit", "chaos": "chaos"}, points)
    assert account.ratio_sentence(toy, True).endswith("; no fixed step reaches it in 1 of 2 pairs.")
    assert account.ratio_sentence(toy, False).endswith("no other method was tried in 2 of 2 pairs.")
    assert "no fixed step reaches it" in account.sentences(toy)[4]


def test_the_ends_of_a_range_say_how_they_are_known():
    other = [point(EXACT, None, 1e-5, 1e-16, "near"), point(STEPS, 0.1, 2e-4, 1e-8, "near")]
    fine = [*other, point(STEPS, 0.01, 2e-3, 1e-10, "near")]
    points = [point(EXACT, None, 3e-5, 1e-16), *power_law(1.0), *fine]
    toy = account.System("toy", "Toy", [TIME], {"orbit": "an orbit", "near": "near"}, points)
    assert account.ratio_sentence(toy, True) == (
        "Toy: at an error of 1e-09 the exact engine is 63 (near, impact time) to 100,000 (orbit, impact time; "
        "extrapolated) times as fast as the best fixed step (1 of 2 extrapolated); short of the 100 times wanted in 1 "
        "of 2 pairs."
    )


def test_why_the_wanted_ratio_is_missed():
    """A rule that needs few steps an interval: its one step is told, and what a hundredth of its cost is."""
    points = [point(EXACT, None, 4e-8, 1e-16), *(point(STEPS, 0.5**k, 3e-8 * 2**k, 1.6e-8 * 0.5**k) for k in range(5))]
    toy = account.System("toy", "Toy", [TIME], {"orbit": "an orbit"}, points, interval=1.0)
    assert account.sentences(toy)[2] == (
        "Toy, why not 100 times as fast: in 'orbit' a control interval of 1 s costs the exact engine 40 ns and one "
        "step of step's end 30 ns, and step's end needs the time of 16 (impact time) such steps for 1e-09, so that the "
        "exact engine would have to move a record in 4.8 ns."
    )
    for silent in (
        dataclasses.replace(toy, interval=None),
        dataclasses.replace(toy, interval=2.0),  # no step is as long
        dataclasses.replace(toy, points=[point(EXACT, None, 1e-10, 1e-16), *points[1:]]),  # fast enough
        dataclasses.replace(toy, points=[points[0], points[1], point(STEPS, 1e-3, 3.5e-6, 1e-9)]),  # many steps
    ):
        assert account.interval_sentence(silent) is None


@pytest.mark.parametrize(
    ("number", "text"),
    [(0.126, "0.13"), (9.96, "10"), (99.4, "99"), (99.6, "100"), (123456.0, "120,000"), (996000.0, "1.0e6")],
)
def test_numbers_in_sentences_have_two_digits(number, text):
    assert account._short(number) == text


def test_large_ratios_are_powers_of_ten():
    fast = system([point(EXACT, None, 1e-6, 1e-16), *power_law(1.0)])
    assert "3.0e6 times as fast" in account.sentences(fast)[3]


def test_a_jump_to_rounding_is_not_interpolated():
    found = reach([point(LOCATED, 4e-3, 1e-5, 1e-2), point(LOCATED, 2e-3, 6e-5, 1e-17)], TIME)
    assert (found.how, found.cost, found.order) == ("at most", 6e-5, None)


def test_tables_numbers_and_picture_of_points_that_went_astray_and_of_zero_errors():
    points = [point(EXACT, None, 3e-5, 0.0), *power_law(1.0), point(STEPS, 1.0, 1e-8, math.inf)]
    toy = system(points)
    assert [row[-1] for row in account.points_table(toy).rows] == [
        "0.0e+00 *",
        "3.0e-03 *",
        "3.0e-04 *",
        "3.0e-05",
        "astray",
    ]
    assert account.points_table(toy).detail and account.points_table(toy).note.endswith("impact time 1e-15 s.")
    assert account.target_table(toy).note.startswith("Orbit: ")
    assert account.target_table(toy).rows[0][2:] == ["exact", "0.0e+00", "", "3e-05", "measured", "1"]
    assert account.numbers(toy)["panels"][0]["exact_on_front"]
    axes = picture(toy).axes
    assert len(axes) == 1 and axes[0].get_xlim()[0] == pytest.approx(TIME.rounding / 3.0)


def test_a_long_call_is_timed_once_a_repeat():
    seen = []
    runs = [Run(EXACT, "orbit", None, lambda: seen.append(1) or 3.0, 0.5, lambda x: {TIME.name: x})]
    assert len(measured(runs, 4, 0.0, progress=False, title="toy")) == 1
    assert len(seen) == 1 + 4  # judged, and timed


def test_runs_are_judged_and_timed():
    seen = []
    runs = [
        Run(EXACT, "orbit", None, lambda: seen.append("exact") or 3.0, 0.5, lambda x: {TIME.name: x}),
        Run(STEPS, "orbit", 0.1, lambda: 4.0, 2.0, lambda x: {TIME.name: x}),
    ]
    points = measured(runs, 2, 1e-4, progress=False, title="toy")
    assert [p.errors[TIME.name] for p in points] == [3.0, 4.0]
    assert [p.label for p in points] == ["exact", "step's end, 0.1 s"]
    assert all(0.0 < p.cost.minimum <= p.cost.median <= p.cost.maximum for p in points) and len(seen) > 4
    with pytest.raises(ValueError, match="is nan"):
        measured([Run(EXACT, "orbit", None, lambda: 0, 1.0, lambda _: {TIME.name: math.nan})], 1, 1e-4, False, "toy")
