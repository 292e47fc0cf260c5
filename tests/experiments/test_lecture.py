"""The experiments of the lecture's vehicles: everything found agrees, and the formulas they hold against hold alone."""

import math

import numpy as np
import pytest

from vr_envs.experiments import catalogue, ride_readings, runner
from vr_envs.experiments.kd_step import damping_of, rung
from vr_envs.experiments.ride_readings import transfer
from vr_envs.models.ride_options import Textbook


@pytest.mark.parametrize(
    "name", ["kd-step", "ride-readings", "heading-step", pytest.param("ride-engines", marks=pytest.mark.slow)]
)
def test_all_that_is_found_agrees_and_is_drawn(name):
    outcome = catalogue.EXPERIMENTS[name].run(runner.silent)
    assert [finding for finding in outcome.findings if not finding.agrees] == []
    assert len(outcome.findings) >= 5
    assert runner.picture(outcome)[:4] == b"\x89PNG"
    assert all(np.isfinite(column).all() for table in outcome.tables.values() for column in table.values())


def test_the_readings_responses_have_their_limits():
    """H_A goes to the exact response, H_B to i W dt times that; both errors are of first order in the step."""
    frequency = np.array([1.0, 5.0, 9.0])
    exact = transfer(frequency, 0.8, 58.0, None)
    for reading, limit in (("A", lambda dt: exact), ("B", lambda dt: 1j * frequency * dt * exact)):
        off = [
            np.abs(transfer(frequency, 0.8, 58.0, Textbook(step=dt, reading=reading)) - limit(dt)) / np.abs(limit(dt))
            for dt in (2e-4, 1e-4)
        ]
        assert np.allclose(off[0] / off[1], 2.0, 0, 0.01)


def test_the_damping_seen_in_a_motion_is_the_factors():
    """Also where the spring no longer swings, and not that of another factor."""
    for rate, gamma in ((30, 0.1), (60, 2.0), (60, 40.0)):
        assert damping_of(rung(rate, gamma), rate) == pytest.approx(gamma, rel=1e-6)
    assert math.exp(-damping_of(rung(60, -math.log(0.98) * 60), 60) / 60) == pytest.approx(0.98, rel=1e-9)


def test_samples_fall_on_every_step():
    for rate in ride_readings.RATES:
        assert (ride_readings.INTERVAL * rate) % 1.0 == pytest.approx(0.0, abs=1e-9)
