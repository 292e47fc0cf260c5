"""Kernels from which options have been taken out by machine: their sources."""

import ast
import sys

import pytest

from tests.toy import TASK as TOY
from vr_envs.bench.features.cases import plain
from vr_envs.bench.features.stripped import (
    StripError,
    kernels_of,
    stripped,
    stripped_sources,
    stripped_task,
    with_kernels,
)
from vr_envs.envs.registry import ids, task_of

TASKS = {task.name: task for task in map(task_of, ids())}


def entries(task):
    return [(kernel.py_func.__module__, kernel.py_func.__name__) for kernel in kernels_of(task)]


def mentions(text, options):
    """Names of options that a source uses; some options are also numbers of a state or fields of a record."""
    tree = ast.parse(text)
    found = {n.id for n in ast.walk(tree) if isinstance(n, ast.Name)}
    found |= {n.arg for n in ast.walk(tree) if isinstance(n, ast.arg | ast.keyword)}
    found |= {
        n.attr for n in ast.walk(tree) if isinstance(n, ast.Attribute) and ast.unparse(n.value) in ("laws", "piece")
    }
    return found & set(options)


@pytest.mark.parametrize("task", TASKS.values(), ids=TASKS)
def test_sources_without_options_mention_none(task):
    sources = stripped_sources(entries(task), list(task.options), list(task.options))
    assert {kernel.py_func.__module__ for kernel in kernels_of(task)} <= set(sources)
    for text in sources.values():
        assert mentions(text, task.options) == set()


PAIRS = [(task, option) for task in TASKS.values() for option in task.options]


@pytest.mark.parametrize(("task", "present"), PAIRS, ids=[f"{task.name}-{option}" for task, option in PAIRS])
def test_one_option_alone_stays_in(task, present):
    absent = [name for name in task.options if name != present]
    sources = stripped_sources(entries(task), absent, list(task.options))
    assert all(mentions(text, absent) == set() for text in sources.values())
    assert any(mentions(text, [present]) for text in sources.values())


def test_what_stands_behind_a_return_that_is_always_reached_goes_too():
    absent = list(TASKS["autopilot"].options)
    sources = stripped_sources([("vr_envs.envs.autopilot_sensing", "measure")], absent, absent)
    text = sources["vr_envs.envs.autopilot_sensing"]
    assert "def measure(state):" in text and "return values(state)" in text
    assert "state.past" not in text


def test_a_name_of_a_whole_module_is_taken_from_there():
    absent = list(TASKS["terrain_ride"].options)
    text = stripped_sources([("vr_envs.envs.terrain_ride", "start")], absent, absent)["vr_envs.envs.terrain_ride"]
    assert "from NEW_PACKAGE.vr_envs.models.terrain_ride import rest as model_rest" in text
    assert "model_rest(state, params)" in text


def test_what_is_no_kernel_is_not_made_again():
    absent = list(TASKS["autopilot"].options)
    sources = stripped_sources(entries(TASKS["autopilot"]), absent, absent)
    assert all("class State" not in text and "class Params" not in text for text in sources.values())
    assert "vr_envs.models.jit" not in sources


def test_unknown_options_are_refused():
    with pytest.raises(StripError, match="there are no options magnet; choose among scatter"):
        stripped_sources([("vr_envs.models.ball_on_bar", "advance")], ["magnet"], list(TASKS["ball_on_bar"].options))


GREEDY = """
from vr_envs.models.jit import kernel


@kernel
def push(x, gust):
    return x + gust.size
"""


def test_an_option_that_is_used_without_being_asked_for_is_refused(tmp_path, monkeypatch):
    (tmp_path / "greedy_kernel.py").write_text(GREEDY)
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(StripError, match="greedy_kernel.push still uses gust without the option"):
        stripped_sources([("greedy_kernel", "push")], ["gust"], ["gust"])


def test_the_made_package_is_gone_afterwards_and_its_kernels_leave_no_cache():
    with stripped([("tests.toy", "advance")], ["bias"], ["bias"]) as (advance,):
        module = advance.py_func.__module__
        assert module.startswith("vr_envs_stripped_") and module.endswith(".tests.toy")
        assert advance._cache.cache_path is None
        assert advance.py_func.__code__.co_varnames[:3] == ("state", "action", "params")
    assert module not in sys.modules


def test_a_task_with_other_kernels_keeps_the_rest():
    kernels = kernels_of(TOY)
    assert kernels == [TOY.start, TOY.advance, TOY.outcome, TOY.observe]
    swapped = with_kernels(TOY, dict(zip(kernels, reversed(kernels), strict=True)))
    assert (swapped.start, swapped.observe, swapped.metrics) == (TOY.observe, TOY.start, TOY.metrics)


def test_a_stripped_task_has_the_scene_and_its_options_alone():
    with stripped_task(TOY, {**plain(TOY), "push": 3.0, "bias": {"size": 0.25}}) as task:
        assert list(task.options) == ["bias"] and list(task.scenes) == [task.default_scene]
        assert task.scenes[task.default_scene]["push"] == 3.0
        assert task.scenes[task.default_scene]["bias"]["size"] == 0.25
    with stripped_task(TOY, plain(TOY)) as task:
        assert task.options == {}
