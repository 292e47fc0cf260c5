import numpy as np
import pytest
from matplotlib.figure import Figure

from vr_envs.experiments import ride_classes as experiment
from vr_envs.experiments.runner import silent


def test_smooth_roads_ride_as_the_formula_says(monkeypatch):
    monkeypatch.setattr(experiment, "CLASSES", "ABE")
    monkeypatch.setattr(experiment, "SPEEDS", (20.0,))
    monkeypatch.setattr(experiment, "SPEED_COLOURS", experiment.SPEED_COLOURS[:1])
    outcome = experiment.ride_classes(silent)
    assert [f.agrees for f in outcome.findings] == [True] * 3
    assert "class E" not in "".join(f.what for f in outcome.findings)
    rides = outcome.tables["rides"]
    assert rides["formula_m_s2"] == pytest.approx([0.326, 0.653, 5.224], abs=6e-4)
    assert rides["airborne"][:2] == pytest.approx([0.0, 0.0]) and rides["airborne"][2] > 0.1
    # a tyre that leaves the ground pushes less than one that would pull
    assert rides["ridden_m_s2"][2] < 0.95 * rides["formula_m_s2"][2]
    assert np.isfinite(rides["error_m_s2"]).all()
    outcome.draw(Figure())
