"""The catalogue of experiments, the runner's files, and the command."""

import csv
import json
import sys

import numpy as np
import pytest

from vr_envs.__main__ import main
from vr_envs.experiments import catalogue, runner
from vr_envs.experiments.experiment import Experiment, Finding, Outcome


def toy(progress):
    """An experiment that finds one thing that agrees and one that does not."""
    values = np.array([x / 3 for x in progress(range(4), desc="toy")])
    return Outcome(
        (Finding("mean", "0.5", f"{values.mean():.2f}", True), Finding("sum", "3 | 4", f"{values.sum():.2f}", False)),
        {"numbers": {"x_m": np.arange(4), "y_m": values}},
        lambda figure: figure.subplots().plot(values),
    )


@pytest.fixture
def experiments(monkeypatch):
    """A catalogue of one toy."""
    monkeypatch.setitem(sys.modules, "vr_envs.experiments.toy", sys.modules[__name__])
    found = {"toy": Experiment("toy", "Fig 0", "a toy", "toy:toy")}
    for module in (catalogue, runner):
        monkeypatch.setattr(module, "EXPERIMENTS", found)
    return found


def test_names_are_unique_and_all_can_be_loaded():
    import importlib

    listed = [e.name for e in catalogue.EXPERIMENTS.values()]
    assert listed == list(catalogue.EXPERIMENTS)
    for experiment in catalogue.EXPERIMENTS.values():
        module, function = experiment.function.split(":")
        assert callable(getattr(importlib.import_module(f"vr_envs.experiments.{module}"), function))


def test_the_runner_writes_a_picture_the_numbers_and_the_findings(experiments, tmp_path):
    findings = runner.run_one("toy", tmp_path)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["toy-numbers.csv", "toy.json", "toy.png"]
    assert (tmp_path / "toy.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    rows = list(csv.reader((tmp_path / "toy-numbers.csv").read_text().splitlines()))
    assert rows[0] == ["x_m", "y_m"]
    assert [float(row[1]) for row in rows[1:]] == [0 / 3, 1 / 3, 2 / 3, 3 / 3]
    report = json.loads((tmp_path / "toy.json").read_text())
    assert report["figure"] == "Fig 0"
    assert [f["agrees"] for f in report["findings"]] == [True, False]
    assert [f.what for f in findings] == ["mean", "sum"]


def test_the_command_prints_expected_beside_found(experiments, tmp_path, capsys):
    assert main(["experiment", "--all", "--out", str(tmp_path / "new" / "folder")]) == 0
    printed = capsys.readouterr().out
    assert "toy: a toy (Fig 0)" in printed
    lines = [[cell.strip() for cell in line.split(" | ")] for line in printed.splitlines()]
    assert ["| mean", "0.5", "0.50", "yes    |"] in lines
    assert any(cells[-1].startswith("NO") for cells in lines)
    assert "1 of 2 findings agree" in printed


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["nothing"], "there is no experiment 'nothing'; choose among toy"),
        (["toi"], "there is no experiment 'toi'; did you mean 'toy'? choose among toy"),
        ([], "give names of experiments (see --list), or --all"),
        (["toy", "--all"], "give names of experiments (see --list), or --all"),
    ],
)
def test_the_command_refuses_in_one_line(experiments, capsys, arguments, told):
    assert main(["experiment", *arguments]) == 2
    assert told in capsys.readouterr().err


def test_a_file_in_the_place_of_the_folder_is_told(experiments, tmp_path, capsys):
    (tmp_path / "file").touch()
    assert main(["experiment", "toy", "--out", str(tmp_path / "file")]) == 2
    assert str(tmp_path / "file") in capsys.readouterr().err


def test_without_matplotlib_the_command_says_what_to_install(experiments, tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert main(["experiment", "toy", "--out", str(tmp_path)]) == 2
    assert "pip install '.[render]'" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_the_list_has_a_line_for_each(capsys):
    assert main(["experiment", "--list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split("|")[1].strip() for line in lines[2:]] == list(catalogue.EXPERIMENTS)


def test_two_jobs_run_the_same_experiments(tmp_path):
    names = ["restitution", "period-two"]
    found = dict(runner.run_all(names, tmp_path, jobs=2))
    assert sorted(found) == sorted(names)
    for name in names:
        assert found[name] == runner.run_one(name, tmp_path)
