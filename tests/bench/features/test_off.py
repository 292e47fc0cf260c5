"""An option that is off leaves no instruction in the compiled kernels: against kernels that never had it."""

import pytest

from tests.toy import TASK as TOY
from vr_envs.bench.features.batch import Batch
from vr_envs.bench.features.cases import cases, plain
from vr_envs.bench.features.costs import NO_OPTION, pruning_cost, same
from vr_envs.bench.features.skipped import rests
from vr_envs.bench.features.stripped import stripped_task
from vr_envs.envs.registry import ids, task_of

TASKS = {task.name: task for task in map(task_of, ids())}
ROWS, STEPS = 4, 12
HANDFUL = 8  # instructions


def shipped_and_stripped(task, scene, rows=ROWS):
    """Instructions of both, after a look at whether they do the same."""
    with stripped_task(task, scene) as bare:
        assert set(bare.options) < set(task.options)
        shipped, stripped = Batch(task, scene, rows, STEPS), Batch(bare, None, rows, STEPS)
        assert same(shipped, stripped)
        return shipped.instructions, stripped.instructions


@pytest.mark.parametrize("task", [*TASKS.values(), TOY], ids=[*TASKS, "toy"])
def test_options_that_are_off_leave_no_instruction(task):
    """As many of everything that calculates; a call with fewer arguments may be inlined where the other is not."""
    shipped, stripped = shipped_and_stripped(task, plain(task))
    assert shipped.calculation() == stripped.calculation()
    assert shipped.calculation().total() > 20
    assert abs(shipped.optimised.total() - stripped.optimised.total()) <= HANDFUL


def test_an_option_of_amplitude_zero_would_be_found_out():
    idle = Batch(TOY, {**plain(TOY), "bias": {"size": 0.0}}, ROWS, STEPS)
    with stripped_task(TOY, plain(TOY)) as bare:
        stripped = Batch(bare, None, ROWS, STEPS)
        assert same(idle, stripped)
        assert idle.instructions.optimised.total() > stripped.instructions.optimised.total()
        assert (idle.instructions.calculation() - stripped.instructions.calculation())["fmul"] > 0


def test_kernels_that_do_something_else_are_refused(monkeypatch):
    monkeypatch.setattr("vr_envs.bench.features.costs.same", lambda *_: False)
    with pytest.raises(
        ArithmeticError, match="toy, no option: the kernels without the absent options give another result"
    ):
        pruning_cost(NO_OPTION, TOY, plain(TOY), 1, 1e-4, ROWS)


def test_a_ball_bounces_or_lies_as_it_should():
    found = rests(TASKS["ball_on_bar"], 1, 1e-4)  # which refuses a ball that does not
    assert [rest.name.split()[0] for rest in found] == ["bounces", "lies", "lies"]


SCENES = [
    (task, name, scene)
    for task in TASKS.values()
    for name, scene in [
        *((case.option, case.with_it) for case in cases(task)),
        *((name, {"base": name}) for name in task.scenes),
    ]
]


@pytest.mark.slow
@pytest.mark.parametrize("rows", [ROWS, 64])
@pytest.mark.parametrize(("task", "name", "scene"), SCENES, ids=[f"{task.name}-{name}" for task, name, _ in SCENES])
def test_the_other_options_leave_nothing_beside_one_that_is_on(task, name, scene, rows):
    """No more of anything that calculates; where a call is inlined in more places than another, there is less."""
    shipped, stripped = shipped_and_stripped(task, scene, rows)
    assert shipped.calculation() - stripped.calculation() == {}
    assert shipped.optimised.total() <= 1.02 * stripped.optimised.total()
