from vr_envs.bench.report import Report, Table


def test_a_table_of_detail_goes_to_the_file_alone(tmp_path):
    report = Report("x", "X", tables=[Table("Main", ["a"], [["1"]]), Table("More", ["b"], [["2"]], detail=True)])
    short = report.text(detail=False)
    assert "### Main" in short and "### More" not in short
    written = {path.name: path.read_text() for path in report.write(tmp_path)}
    assert "### Main" in written["x.md"] and "### More" in written["x.md"]
