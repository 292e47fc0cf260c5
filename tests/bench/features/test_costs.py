"""The scenes that show what an option costs, and the arithmetic of the clock."""

import pytest

from tests.toy import TASK as TOY
from vr_envs.bench.features import costs
from vr_envs.bench.features.batch import Batch
from vr_envs.bench.features.cases import cases, plain
from vr_envs.bench.features.skipped import finished, judging
from vr_envs.envs.registry import ids, task_of
from vr_envs.envs.scene import resolve

TASKS = {task.name: task for task in map(task_of, ids())}


@pytest.mark.parametrize("task", TASKS.values(), ids=TASKS)
def test_every_option_has_a_scene_with_it_and_the_same_without(task):
    found = list(cases(task))
    assert [case.option for case in found] == list(task.options)
    for case in found:
        without, with_it = resolve(task, case.without), resolve(task, case.with_it)
        assert without.params == with_it.params
        assert without.options[case.option] is None and with_it.options[case.option] is not None
        others = [name for name in task.options if name != case.option]
        assert [without.options[name] for name in others] == [with_it.options[name] for name in others]


@pytest.mark.parametrize("task", TASKS.values(), ids=TASKS)
def test_a_plain_scene_has_what_it_cannot_do_without(task):
    present = [name for name, option in resolve(task, plain(task)).options.items() if option is not None]
    assert present == {"terrain_ride": ["road"]}.get(task.name, [])


def test_a_task_one_by_one_has_no_lockstep_and_is_the_same_else():
    task = TASKS["autopilot"]
    assert task.lockstep is not None and costs.one_by_one(task).lockstep is None
    assert costs.one_by_one(task).advance is task.advance


def test_the_options_that_exclude_lockstep_are_named():
    assert {"shear", "sensing"} <= set(costs.outside_lockstep(TASKS["autopilot"]))
    assert not {"turbulence", "demands"} & set(costs.outside_lockstep(TASKS["autopilot"]))
    assert "tyre" in costs.outside_lockstep(TASKS["terrain_ride"])
    assert "road" not in costs.outside_lockstep(TASKS["terrain_ride"])


class Clocked:
    """In place of a batch: so many steps and impacts."""

    def __init__(self, steps, impacts):
        self.steps, self.count, self.instructions = steps, impacts, None

    def impacts(self):
        return self.count


def test_costs_are_times_over_steps_and_ratios_per_impact(monkeypatch):
    monkeypatch.setattr(costs, "per_call", lambda *_: [[3e-6, 4e-6, 8e-6], [1e-6, 2e-6, 2e-6]])
    cost = costs.compare("gust", Clocked(1000, None), Clocked(500, None), 3, 1.0)
    assert tuple(cost.time) == pytest.approx((3.0, 4.0, 8.0)) and tuple(cost.other_time) == pytest.approx((2, 4, 4))
    assert tuple(cost.ratio) == pytest.approx((1.0, 1.5, 2.0))  # per step, as 3/1, 4/2 and 8/2 halved
    cost = costs.compare("gust", Clocked(1000, 4.0), Clocked(1000, 2.0), 3, 1.0)
    assert tuple(cost.ratio) == pytest.approx((1.0, 1.5, 2.0))  # per impact


def test_a_call_begins_again_where_it_began():
    batch = Batch(TOY, None, 8, steps=3, ages=5)
    assert sorted(batch.begin["steps"]) == [0, 0, 1, 1, 2, 3, 3, 4]
    first, second = batch.results(), batch.results()
    assert [a.tobytes() for a in first] == [b.tobytes() for b in second]
    batch()
    assert (batch.world.states["steps"] == batch.begin["steps"] + 3).all()
    assert batch.steps == 24 and batch.impacts() is None


def test_fields_of_the_records_can_be_given():
    batch = Batch(TOY, None, 4, steps=1, ages=0, action=(0.0,), fields={"x": 2.0})
    assert (batch.begin["x"] == 2.0).all()


def test_finished_rows_stay_and_the_others_run(monkeypatch):
    found = finished(TOY, 1, 1e-4, rows=64)
    assert [some.live for some in found] == [64, 16, 1] and tuple(found[0].ratio) == (1.0, 1.0, 1.0)
    monkeypatch.setattr(Batch, "results", lambda batch: [batch.begin])  # as if nothing had been stepped
    with pytest.raises(ArithmeticError, match="a finished row has changed, or one that runs has not"):
        finished(TOY, 1, 1e-4, rows=64)


def test_metrics_are_timed_for_one_row_and_for_all():
    one, many = judging(TOY, 20, 1, 1e-4, rows=16)
    assert (one.rows, many.rows) == (1, 16)
    assert one.share / one.time.median == pytest.approx(many.share / many.time.median)
