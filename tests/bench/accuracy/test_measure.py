"""The command: one report of the systems that are asked for."""

import json
import sys

import pytest

from vr_envs.__main__ import main
from vr_envs.bench.accuracy import measure
from vr_envs.bench.accuracy.account import System
from vr_envs.bench.accuracy.points import Measure, Method, Point
from vr_envs.bench.timing import Spread
from vr_envs.cli import bench_accuracy

TIME = Measure("impact time", "s", "largest over the impacts", 1e-15)


def toy(quick, progress):
    cost, euler = Spread(1e-5, 2e-5, 3e-5), Method("Euler", "fixed step", "step", fixed_step=True)
    points = [
        Point(Method("exact", "exact"), "orbit", None, cost, {TIME.name: 1e-16}),
        Point(euler, "orbit", 0.1, cost, {TIME.name: 0.1 if quick else 0.2}),
    ]
    return System("toy", "Toy", [TIME], {"orbit": "an orbit"}, points)


def test_command_knows_all_systems():
    assert list(measure.SYSTEMS) == list(bench_accuracy.SYSTEMS)


def test_command_writes_report_and_picture(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(measure.SYSTEMS, "ball_on_bar", toy)
    main(["bench", "accuracy", "--quick", "--system", "ball_on_bar", "--out", str(tmp_path)])
    assert "exact engine is on the front in the one pair" in (out := capsys.readouterr().out)
    assert "at equal error" not in out and "every point" not in out
    found = json.loads((tmp_path / "accuracy.json").read_text())["numbers"]["ball_on_bar"]
    assert found["points"][1]["errors"] == {TIME.name: 0.1} and found["points"][1]["step"] == 0.1
    assert (tmp_path / "accuracy-ball_on_bar.png").stat().st_size > 1000
    written = (tmp_path / "accuracy.md").read_text()
    assert (
        "![ball_on_bar](accuracy-ball_on_bar.png)" in written
        and "at equal error" in written
        and "every point" in written
    )


def test_unknown_system_is_refused():
    with pytest.raises(ValueError, match="choose among ball_on_bar"):
        measure.measure(["pendulum"])


def test_missing_package_is_told(monkeypatch, capsys, tmp_path):
    monkeypatch.setitem(sys.modules, measure.__name__, None)
    assert main(["bench", "accuracy", "--out", str(tmp_path)]) == 2
    assert "pip install '.[bench]'" in capsys.readouterr().err
