"""The clock of an impact, and kernels from which options have been taken out by machine."""

import ast
import itertools

import numpy as np
import pytest

from vr_envs.bench.features import impact
from vr_envs.bench.features.stripped import StripError, stripped, stripped_sources
from vr_envs.models.ball_options import OPTIONS

ENTRY = ("ball_on_bar", "advance")


def mentions(text, options):
    """Names of options that a source uses; the ball's spin is also a number of its state."""
    tree = ast.parse(text)
    found = {n.id for n in ast.walk(tree) if isinstance(n, ast.Name)}
    found |= {n.arg for n in ast.walk(tree) if isinstance(n, ast.arg | ast.keyword)}
    found |= {n.attr for n in ast.walk(tree) if isinstance(n, ast.Attribute) and ast.unparse(n.value) != "state"}
    return found & set(options)


def test_stripped_sources_have_no_option():
    sources = stripped_sources(ENTRY, list(OPTIONS))
    assert {"ball_on_bar", "flight", "surface", "impact", "bar"} <= set(sources)
    for text in sources.values():
        assert mentions(text, OPTIONS) == set()
        assert "None is" not in text and "camera" not in text
    assert "_sampled" not in sources["flight"]


@pytest.mark.parametrize("present", OPTIONS)
def test_one_option_alone_stays_in(present):
    absent = [name for name in OPTIONS if name != present]
    sources = stripped_sources(ENTRY, absent)
    assert all(mentions(text, absent) == set() for text in sources.values())
    assert any(mentions(text, [present]) for text in sources.values())


def test_unknown_options_are_refused():
    with pytest.raises(StripError, match="there are no options magnet; choose among scatter"):
        stripped_sources(ENTRY, ["magnet"])


@pytest.mark.parametrize("name", ["tilting, no option", "lens"])
def test_stripped_kernel_gives_the_same_bytes(name):
    changes, action = impact.SCENES[name]
    with stripped(ENTRY, impact.absent_of(changes)) as module:
        assert not module.__name__.startswith("vr_envs.")
        works = [impact.work_of(name, changes, action, k) for k in (module.advance, impact.advance)]
        done = [work.run(2) for work in works]
    assert done[0] == done[1] and done[0][0] > 100
    assert works[0].state.tobytes() == works[1].state.tobytes()
    assert np.isfinite(works[0].state["z"]).all()


def test_costs_are_time_over_impacts(monkeypatch):
    # a clock that goes on by one second each time it is read, and work of 5 impacts an episode
    monkeypatch.setattr(impact.time, "process_time", itertools.count(0.0, 1.0).__next__)
    works = [impact.Work(name, lambda n, k=k: (k * n, 2 * n), np.zeros(1)) for name, k in (("a", 5), ("b", 10))]
    first, second = impact.costs(works, [works[0]] * 2, repeats=3, seconds=3.0, progress=False)
    assert works[0].episodes == 3  # one second an episode
    assert first.nanoseconds.median == pytest.approx(1e9 / 15) and first.ratio is None
    assert second.nanoseconds.median == pytest.approx(1e9 / 30) and second.ratio.median == pytest.approx(0.5)
    assert (first.impacts_per_cycle, second.impacts_per_cycle) == (2.5, 5.0)


def test_nothing_to_measure_is_refused():
    with pytest.raises(ValueError, match="at least 1"):
        impact.costs([], [], repeats=0, seconds=1.0, progress=False)
