"""Every field of every scene at both ends of its allowed range: finite numbers, no exception, or a clear refusal."""

import dataclasses
import math

import numpy as np
import pytest

from vr_envs.controllers.ladder import laws_of
from vr_envs.envs.registry import ids, task_of
from vr_envs.envs.world import World

ROWS, STEPS = 8, 20


def extremes(cls):
    """(field, value) for both ends of every range and for every choice."""
    for field in dataclasses.fields(cls):
        for value in field.metadata["choices"] or (field.metadata["low"], field.metadata["high"]):
            if isinstance(value, str) or math.isfinite(value):
                yield field.name, value


def scenes_at_the_limits(task, preset):
    present = {name: cls for name, cls in task.options.items() if task.scenes[preset].get(name)}
    for name, value in extremes(task.params):
        yield {"base": preset, name: value}
    for option, cls in present.items():
        for name, value in extremes(cls):
            yield {"base": preset, option: {name: value}}


def walk(world, policies):
    """Random actions, restarted where an episode ends; the laws answer on the way."""
    rng = np.random.default_rng(0)
    rows = np.empty((ROWS, world.widths[0]), np.float32)
    world.reset(np.arange(ROWS), np.arange(ROWS, dtype=np.uint64), rows)
    for step in range(STEPS):
        for policy in policies:
            actions = policy(rows)
            assert (np.abs(actions) <= 1.0).all(), (policy, world.scene.label)
        actions = rng.uniform(-1.0, 1.0, (ROWS, world.widths[1]))
        rows, rewards, ended, _ = world.step(actions, np.ones(ROWS, np.bool_), 10**6)
        assert all(row in world.observation_space for row in rows), world.scene.label
        assert ((rewards >= 0.0) & (rewards <= 1.0)).all(), world.scene.label
        if ended.any():
            again = np.flatnonzero(ended)
            world.reset(again, again.astype(np.uint64) + np.uint64(step + 100), rows)
        world.load(world.states.copy(), np.arange(ROWS))


def check(task, scene):
    """Whether the scene is allowed; if so, it is walked through."""
    try:
        world = World(task, scene, ROWS)
    except ValueError as error:
        assert "is not allowed" in str(error) or "; give" in str(error) or ": give" in str(error), error
        return False
    policies = [law(world.scene) for law in laws_of(task, world.scene).values()]
    for policy in policies:
        policy.reset(ROWS)
    walk(world, policies)
    return True


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("env_id", "preset"), [(i, preset) for i in ids() for preset in task_of(i).scenes])
def test_the_ends_of_every_range_are_finite_rides_or_refused(env_id, preset):
    task = task_of(env_id)
    extra = {"actuation": "active"} if "actuation" in {f.name for f in dataclasses.fields(task.params)} else {}
    scenes = list(scenes_at_the_limits(task, preset))
    scenes += [{**extra, **scene} for scene in scenes if extra]
    assert sum(check(task, scene) for scene in scenes) > len(scenes) / 3


@pytest.mark.parametrize(
    ("env_id", "scene"),
    [
        ("vr_envs/TerrainRide-v0", {"actuation": "active", "force": 0.0}),
        ("vr_envs/Autopilot-v1", {"altitude_low": 0.0, "altitude_high": 0.0, "ceiling": 0.0}),
        ("vr_envs/Autopilot-v1", dict.fromkeys(("stall_speed", "speed_low", "speed_high", "top_speed"), 100.0)),
    ],
)
def test_a_span_of_nothing_is_refused(env_id, scene):
    with pytest.raises(ValueError, match="is not allowed; it must be"):
        World(task_of(env_id), scene, 1)


def test_an_hour_in_one_interval_is_refused_only_with_too_many_renewals_of_the_limits():
    task, scene = task_of("vr_envs/Autopilot-v1"), {"dt": 3600.0, "demands": None}
    assert World(task, {**scene, "refresh": 0.36}, 1).scene.params.dt == 3600.0
    with pytest.raises(ValueError, match="dt = 3600 is not allowed; it must not exceed 10000 refresh = 3590"):
        World(task, {**scene, "refresh": 0.359}, 1)
    textbook = {"base": "lecture", "demands": None, "dt": 3600.0, "textbook": {"step": 0.01}}
    with pytest.raises(ValueError, match="it must not exceed 100000 textbook.step = 1000"):
        World(task, textbook, 1)


@pytest.mark.parametrize("env_id", ids())
def test_a_saved_state_outside_its_fields_ranges_is_refused_and_changes_nothing(env_id):
    world = World(task_of(env_id), None, 2)
    world.reset(np.arange(2), np.arange(2, dtype=np.uint64), world.observe())
    before, checked = world.states.copy(), 0
    for field in dataclasses.fields(world.task.state):
        for bound, past in ((field.metadata["low"], -1.0), (field.metadata["high"], 1.0)):
            if math.isfinite(bound):
                bad = before.copy()
                bad[field.name][1] = bound + past
                with pytest.raises(ValueError, match=f"state field '{field.name}' is not in"):
                    world.load(bad, np.arange(2))
                checked += 1
    assert checked >= 2
    assert world.states.tobytes() == before.tobytes()


@pytest.mark.parametrize("env_id", ids())
@pytest.mark.parametrize("extreme", [0, 10**6, 2**62, 2**63 - 3])
def test_whole_numbers_of_a_record_index_nothing_outside_it(env_id, extreme):
    """A record with any admitted whole numbers steps on; its arrays lie between others that stay untouched."""
    task = task_of(env_id)
    world = World(task, None, 3)
    world.reset(np.arange(3), np.arange(3, dtype=np.uint64), world.observe())
    bad = world.states.copy()
    for field in dataclasses.fields(task.state):
        if field.type == "int":
            bad[field.name][1] = extreme
    world.load(bad, np.arange(3))
    neighbours = world.states[[0, 2]].tobytes()
    for _ in range(50):
        world.step(np.zeros((3, world.widths[1])), np.array([False, True, False]), 2**62)
    assert world.states[[0, 2]].tobytes() == neighbours
