import pytest

from vr_envs.models.csv_columns import read_columns


@pytest.fixture
def file(tmp_path):
    def write(text, encoding="utf-8"):
        path = tmp_path / "data.csv"
        path.write_text(text, encoding)
        return str(path)

    return write


def test_columns_are_found_by_name(file):
    path = file("# made by hand\nname, b ,a\n\nx,2,1\n ,-3e-2, 4 \n# the end\ny,5,6\n", "utf-8-sig")
    assert read_columns(path, ("a", "b"), "data") == ([4, 5, 7], {"a": [1.0, 4.0, 6.0], "b": [2.0, -0.03, 5.0]})


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "its header, empty, has 0 columns 'a'; give each of a, b once"),
        ("a;b\n1;2\n", "its header, a;b, has 0 columns 'a'"),
        ("a,b,a\n1,2,3\n", "has 2 columns 'a'"),
        ("a,b\n1,2\n\n3,\n", "line 4: b = '' is not a finite number"),
        ("a,b\n1,2\n3\n", "line 3: b = '' is not a finite number"),
        ("a,b\n1,two\n", "line 2: b = 'two' is not a finite number"),
        ("a,b\n1,2\nnan,2\n", "line 3: a = 'nan' is not a finite number"),
        ("a,b\n1e999,2\n", "line 2: a = '1e999' is not a finite number"),
    ],
)
def test_a_file_that_cannot_be_used_says_why(file, text, told):
    with pytest.raises(ValueError) as error:
        read_columns(file(text), ("a", "b"), "data")
    assert told in str(error.value)
    assert str(error.value).startswith("data '") and "data.csv'" in str(error.value)


def test_what_is_no_text_file_says_so(tmp_path):
    (tmp_path / "binary").write_bytes(b"\xff\xfe\x00\x81")
    for name in ("missing.csv", "", "binary"):
        with pytest.raises(ValueError, match="cannot be read: .*; give the path of a CSV file"):
            read_columns(str(tmp_path / name), ("a",), "data")
