import pytest


@pytest.fixture
def toy(monkeypatch, tmp_path):
    """The id of the toy environment of tests/toy.py, with an empty folder for its tuned gains."""
    from tests.toy import toy_in

    return toy_in(monkeypatch, tmp_path)
