import json
import sys

import numpy as np
import pytest

from vr_envs.__main__ import main
from vr_envs.bench.report import Report, Table, machine


def test_a_table_of_detail_goes_to_the_file_alone(tmp_path):
    report = Report("x", "X", tables=[Table("Main", ["a"], [["1"]]), Table("More", ["b"], [["2"]], detail=True)])
    short = report.text(detail=False)
    assert "### Main" in short and "### More" not in short
    written = {path.name: path.read_text() for path in report.write(tmp_path)}
    assert "### Main" in written["x.md"] and "### More" in written["x.md"]


def test_a_report_says_how_it_was_made(tmp_path):
    report = Report("x", "X", packages=("numpy", "no-such-package"))
    assert report.text().startswith("## X\n") and "no-such-package" not in report.text()
    report.quick = True
    assert report.text().startswith("## X (quick")
    report.write(tmp_path)
    data = json.loads((tmp_path / "x.json").read_text())
    assert data["quick"] is True and data["machine"]["numpy"] == np.__version__


def test_versions_of_opponents_are_told():
    assert {"scipy", "pymunk"} <= set(machine()) and machine(())["numba"]


@pytest.mark.parametrize("kind", ["accuracy", "speed", "stress", "features"])
def test_without_matplotlib_a_benchmark_says_what_to_install_before_it_measures(kind, monkeypatch, capsys, tmp_path):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert main(["bench", kind, "--quick", "--out", str(tmp_path)]) == 2
    assert "pip install '.[bench]'" in capsys.readouterr().err
