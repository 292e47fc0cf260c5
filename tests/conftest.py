import gymnasium as gym
import pytest
from hypothesis import settings

# the first example of a test may compile a kernel; the same examples in every run
settings.register_profile("suite", deadline=None, derandomize=True)
settings.load_profile("suite")


@pytest.fixture
def toy(monkeypatch, tmp_path):
    """The id of the toy environment of tests/toy.py, with an empty folder for its tuned gains."""
    from tests.toy import toy_in

    return toy_in(monkeypatch, tmp_path)


@pytest.fixture
def limited(monkeypatch):
    """Register an id anew with another time limit, for one test."""

    def register(id, steps):
        monkeypatch.setattr(gym.registry[id], "max_episode_steps", steps)

    return register
