"""First contacts of grazing launches, and the search by brackets that they are checked against."""

import math

import mpmath as mp
import numpy as np
import pytest

from vr_envs.experiments import grazing
from vr_envs.experiments.contact_search import CONTACT, first_contact

GRAVITY, OMEGA = 9.81, 2.0 * math.pi * 30.0


@pytest.fixture(scope="module")
def grazes():
    return grazing.graze(20_000, seed=12345)


def test_no_first_contact_is_missed(grazes):
    decided = ~grazes.ambiguous
    assert decided.mean() > 0.999
    assert not (grazes.late | grazes.early)[0][decided].any()
    assert np.abs(grazes.error[0]).max() < 1e-13  # s
    assert (grazes.accelerations.min() < 5.01) and (grazes.accelerations.max() > 99.0)


def test_sampled_search_misses_some_where_the_bar_can_fall_away(grazes):
    late = (grazes.late & ~grazes.ambiguous).sum(1)
    assert late[1] > 100  # of 20 000 with 8 samples a period
    assert (np.diff(late[1:]) < 0).all()
    assert not grazes.late[:, grazes.accelerations < GRAVITY].any()


def dense(cos, sin, v):
    """First contact in 30 digits, by a scan of 20 000 samples a period and bisection."""
    mp.mp.dps = 30
    t = np.linspace(0.0, 0.3, 180_001)[1:]
    gap = v * t - 0.5 * GRAVITY * t**2 - (cos * np.cos(OMEGA * t) + sin * np.sin(OMEGA * t) - cos)
    k = int(np.argmax(gap < 0.0))
    c, s, u, w, g = map(mp.mpf, (cos, sin, v, OMEGA, GRAVITY))
    bracket = (t[k - 1], t[k])
    root = mp.findroot(
        lambda x: u * x - g * x * x / 2 - (c * mp.cos(w * x) + s * mp.sin(w * x) - c), bracket, solver="anderson"
    )
    return float(root)


@pytest.mark.parametrize("acceleration", [5.0, 12.0, 60.0])
@pytest.mark.parametrize("speed", [3e-3, 0.02, 0.3])
def test_brackets_find_what_a_dense_scan_finds(acceleration, speed):
    size = acceleration / OMEGA**2
    for angle in np.linspace(0.1, 6.2, 12):
        cos, sin = size * math.sin(angle), size * math.cos(angle)
        v = OMEGA * sin + speed
        time, slope, _, scale = first_contact(cos, sin, v, GRAVITY, OMEGA)
        truth = dense(cos, sin, v)
        assert abs((time - truth) * slope) < 8.0 * np.finfo(float).eps * scale
        h = 1e-7
        rate = v - GRAVITY * (truth + h) - OMEGA * (sin * math.cos(OMEGA * truth) - cos * math.sin(OMEGA * truth))
        assert slope == pytest.approx(rate, abs=1e-4)


def test_a_gap_that_just_closes_is_told_apart_from_one_that_does_not():
    """A launch from the trough with which the ball just clears the next crest, and one a little slower."""
    size = 60.0 / OMEGA**2
    cos = -size

    def lowest(v):
        t = np.linspace(0.0, 0.03, 300_001)[1:]
        crest = (OMEGA * t > 0.5 * math.pi) & (OMEGA * t < 1.5 * math.pi)
        return (v * t - 0.5 * GRAVITY * t**2 - cos * (np.cos(OMEGA * t) - 1.0))[crest].min()

    low, high = 0.05, 1.0
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if lowest(middle) > 0.0 else (middle, high)
    touching = first_contact(cos, 0.0, low - 1e-7, GRAVITY, OMEGA)
    clear = first_contact(cos, 0.0, high + 1e-7, GRAVITY, OMEGA)
    assert clear[0] > touching[0] + 1e-4
    assert clear[2] < 1e-8 and touching[2] < 1e-8


def test_counts_of_a_small_run_add_up(monkeypatch):
    monkeypatch.setattr(grazing, "LAUNCHES", 4000)
    monkeypatch.setattr(grazing, "CHUNK", 2000)
    outcome = grazing.grazing(lambda items, desc: items)
    searches = outcome.tables["searches"]
    assert list(searches["search"]) == list(grazing.SEARCHES)
    assert searches["missed"][0] == searches["false"][0] == 0
    found = [grazing.graze(2000, seed) for seed in (0, 1)]
    assert list(searches["missed"]) == list(sum((g.late & ~g.ambiguous).sum(1) for g in found))
    for name in ("acceleration", "speed"):
        columns = outcome.tables[name]
        assert columns["launches"].sum() == 4000 - searches["ambiguous"][0]
        assert columns["missed_textbook_8"].sum() == searches["missed"][1]
    assert np.dtype(CONTACT).names == ("time", "slope", "closest", "scale")
