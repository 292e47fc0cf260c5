import math

import numpy as np
import pytest

from vr_envs.models.record import dtype_of, pack
from vr_envs.models.terrain import (
    RING,
    WAVES,
    Bumps,
    Road,
    Undulation,
    bump_height,
    pass_knot,
    place_on_road,
    road_height,
    roll_undulation,
    start_road,
    start_undulation,
    undulation_ahead,
    wave,
)
from vr_envs.models.terrain_ride import State


def fresh(key):
    state = np.zeros(1, dtype_of(State))[0]
    state["key"] = key
    return state


def profile(key, road, bumps=None, n=1000):
    """Heights of the first n knots."""
    state, road = fresh(key), pack(road)
    bumps = None if bumps is None else pack(bumps)
    start_road(state, road, bumps)
    heights = list(state["knots"])
    while len(heights) < n:
        pass_knot(state, road, bumps)
        if state["knot"] % 2 == 0:
            newest = state["knot"] + RING - 2
            heights += [state["knots"][newest % RING], state["knots"][(newest + 1) % RING]]
    return np.array(heights[:n])


@pytest.mark.parametrize(("letter", "mean"), [("A", 16e-6), ("B", 64e-6), ("C", 256e-6), ("H", 262144e-6)])
def test_class_means_are_those_of_the_standard(letter, mean):
    assert Road(iso_class=letter).density == pytest.approx(mean, rel=1e-15)


def test_knots_are_the_exact_discretisation():
    """Innovations of the first-order filter are white, standard normal: variance, whiteness, kurtosis."""
    road = Road(spread=0.0)
    n = 40000
    r = profile(7, road, n=n)
    sd = 0.1 * math.sqrt(math.pi * 256e-6 / (2 * 0.011))
    phi = math.exp(-2 * math.pi * 0.011 * 0.2)
    e = (r[1:] - phi * r[:-1]) / (sd * math.sqrt(1 - phi**2))
    assert abs(e.mean()) < 4 / math.sqrt(n)
    assert abs(e.var() - 1) < 4 * math.sqrt(2 / n)
    assert abs((e**4).mean() - 3) < 4 * math.sqrt(96 / n)
    for lag in range(1, 6):
        assert abs(np.mean(e[lag:] * e[:-lag])) < 4 / math.sqrt(n)


def test_starts_are_stationary():
    sd = 0.1 * math.sqrt(math.pi * 256e-6 / (2 * 0.011))
    heights = np.array([profile(key, Road(spread=0.0), n=RING)[[0, RING - 1]] for key in range(4000)])
    assert heights.var(axis=0) == pytest.approx(sd**2, rel=4 * math.sqrt(2 / 4000))


def test_density_follows_the_standard():
    """Averaged periodogram against Gd(n) = Gd(n0) (n/n0)^-2 between the cut-off and the knots' resolution."""
    road, n = Road(spread=0.0), 4096
    power = np.zeros(n // 2 + 1)
    for key in range(60):
        r = profile(key, road, n=n) * np.hanning(n) / math.sqrt(np.mean(np.hanning(n) ** 2))
        power = power + abs(np.fft.rfft(r)) ** 2 * 2 * road.knot_spacing / n / 60
    f = np.fft.rfftfreq(n, road.knot_spacing)
    for low, high in ((0.05, 0.1), (0.1, 0.2), (0.2, 0.4), (0.4, 0.8)):
        band = (f >= low) & (f < high)
        assert np.mean(power[band] / (256e-6 * (f[band] / 0.1) ** -2)) == pytest.approx(1.0, abs=0.1)


def test_density_is_drawn_about_the_mean():
    octaves = []
    for key in range(3000):
        state = fresh(key)
        start_road(state, pack(Road(spread=1.0)), None)
        octaves.append(math.log2((state["roughness_sd"] / 0.1) ** 2 * 2 * 0.011 / math.pi / 256e-6))
    assert -1 < min(octaves) < -0.99 and 0.99 < max(octaves) < 1
    assert abs(np.mean(octaves)) < 4 * math.sqrt(1 / 3 / 3000)


def test_preview_is_the_road_that_comes():
    state, road, bumps = fresh(3), pack(Road()), pack(Bumps())
    heights = profile(3, Road(), Bumps(), n=400)
    start_road(state, road, bumps)
    for knot in range(300):
        assert state["knot"] == knot
        state["to_knot"] = 0.05
        assert place_on_road(state, road) == pytest.approx(0.75)
        for place in (0.0, 0.75, 1.0, 30.25, 60.5):
            expected = np.interp(knot + place, np.arange(400), heights)
            assert road_height(state, place) == pytest.approx(expected, abs=1e-15)
        pass_knot(state, road, bumps)


def test_bumps_stay_in_their_stretch_and_size():
    bumps = Bumps()
    record, x = pack(bumps), np.arange(0.0, 40000.0, 0.05)
    h = np.array([bump_height(11, d, record) for d in x]).reshape(1000, -1)
    top = np.abs(h).max(axis=1)
    assert (top <= bumps.high).all() and (top > bumps.low * (1 - 0.05 / bumps.shortest)).all()
    assert (np.sign(h).max(axis=1) - np.sign(h).min(axis=1) == 1).all()
    width = (h != 0).sum(axis=1) * 0.05
    assert (width > 2 * bumps.shortest - 0.1).all() and (width < 2 * bumps.longest + 0.1).all()
    assert 0.4 < (h.sum(axis=1) > 0).mean() < 0.6
    assert np.abs(np.diff(h, axis=1)).max() <= 0.05 * bumps.high / bumps.shortest * (1 + 1e-9)


def test_bumps_are_laid_onto_the_roughness():
    flat = profile(5, Road())
    bumpy = profile(5, Road(), Bumps())
    expected = [bump_height(5, k * 0.2, pack(Bumps())) for k in range(1000)]
    assert bumpy - flat == pytest.approx(expected, abs=1e-15)


def test_rolling_over_sines():
    record = pack(Undulation())
    state = fresh(1)
    start_undulation(state)
    phases = np.arctan2(state["wave_sin"], state["wave_cos"])
    for step in range(1, 1001):
        roll_undulation(state, 0.2, record)
        if step % 250 == 0:
            terms = [wave(i, record) for i in range(WAVES)]
            expected = sum(a * math.sin(k * (0.2 * step + 1.7) + p) for (a, k), p in zip(terms, phases, strict=True))
            assert undulation_ahead(state, 1.7, record) == pytest.approx(expected, abs=1e-14)
    assert wave(0, record) == pytest.approx((0.04, 2 * math.pi / 40))
