from vr_envs.evaluation.table import markdown


def test_columns_are_aligned_and_numbers_stand_to_the_right():
    assert markdown(["id", "n"], [["a", "1"], ["long", "10"]]).splitlines() == [
        "| id   |  n |",
        "| ---- | -: |",
        "| a    |  1 |",
        "| long | 10 |",
    ]


def test_a_bar_in_a_cell_is_escaped():
    lines = markdown(["|x|", "unit"], [["largest |x| at the start", "m"]], left=(0, 1)).splitlines()
    assert lines == [
        r"| \|x\|                      | unit |",
        r"| -------------------------- | ---- |",
        r"| largest \|x\| at the start | m    |",
    ]
