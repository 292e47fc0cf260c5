"""Horizontal growth rates against decays followed in the exact model, and the experiments' own findings."""

import math

import numpy as np
import pytest

from vr_envs.experiments.catalogue import EXPERIMENTS
from vr_envs.experiments.horizontal import (
    FRICTIONLESS,
    PARTIAL,
    SPHERE,
    STICKING,
    growth_rates,
    harmonics,
    parabolic,
)
from vr_envs.experiments.runner import silent

NAMES = ("growth", "growth-surface", "bar-motions", "growth-x", "growth-x-surface", "growth-x-sizes")


@pytest.mark.parametrize(
    ("law", "phase"), [(PARTIAL, -1.0), (PARTIAL, 0.6), (SPHERE, 0.3), (FRICTIONLESS, 1.0), (STICKING, 0.4)]
)
def test_a_displaced_ball_grows_or_decays_at_the_rate(law, phase):
    """Iterate the exact map from a small displacement: after the fast modes have died its size changes by the rate."""
    cycle_map = law.cycle_map()
    orbit = cycle_map.orbit(parabolic(cycle_map, 1.5, 150.0, phase))
    k = len(orbit.ball)
    point = np.concatenate([orbit.ball, orbit.motion, orbit.motion])
    point[0] += 1e-8
    sizes = []
    for _ in range(60):
        images, _, _ = cycle_map.run(point[None], float(cycle_map.params["period"]))
        point[:k] = images[0]
        sizes.append(abs(point[0] - orbit.ball[0]))
    rate = math.log(sizes[-1] / sizes[39]) / 20 / (2 * math.pi)
    assert rate == pytest.approx(orbit.growth, abs=2e-4)


def test_another_frequency_stands_for_another_tilt():
    """Only the tilt's amplitude and the ratios of the accelerations to gravity matter."""
    phases = np.linspace(-3.0, 3.0, 5)
    slow, fast = PARTIAL.cycle_map(), PARTIAL.cycle_map(frequency=22.5)
    same = growth_rates(fast, 2.0, [100.0 * 1.5**2], phases)
    assert same == pytest.approx(growth_rates(slow, 2.0, [100.0], phases), abs=1e-8)


def test_turning_the_tilts_phase_by_half_a_turn_is_nothing_without_x_motion():
    cycle_map = PARTIAL.cycle_map()
    rates = growth_rates(cycle_map, 0.0, [100.0], np.array([0.4, 0.4 + math.pi]))[0]
    assert rates[0] == pytest.approx(rates[1], abs=1e-9)


def test_harmonics_of_a_known_curve():
    phases = np.linspace(-math.pi, math.pi, 24, endpoint=False)
    curve = 0.3 + 2.0 * np.sin(phases + 0.4) - 0.7 * np.cos(2 * phases)
    assert harmonics(phases, curve) == pytest.approx((0.3, 2.0, 0.7), rel=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_what_is_expected_comes_out(name):
    outcome = EXPERIMENTS[name].run(silent)
    assert [f for f in outcome.findings if not f.agrees] == []
    for columns in outcome.tables.values():
        assert len({len(column) for column in columns.values()}) == 1
        assert all(np.isfinite(column).all() for column in columns.values())
