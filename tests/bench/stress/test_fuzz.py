"""Scenes and actions by hypothesis: refused in words, or walked twice alike with finite numbers in their spaces."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from vr_envs.bench.stress.fuzz import REFUSALS, WIDTHS, draw_scene, refused
from vr_envs.envs.registry import ids, task_of
from vr_envs.envs.scene import resolve
from vr_envs.envs.world import World

ROWS, STEPS = 3, 6


def values(field):
    low, high, choices = (field.metadata[name] for name in ("low", "high", "choices"))
    if choices is not None:
        return st.sampled_from(choices)
    if field.type == "bool":
        return st.booleans()
    if field.type == "int":
        return st.integers(int(low), int(min(high, 10**6)))
    if str(field.type).startswith("tuple") or not math.isfinite(high):
        return st.just(field.default)
    return st.floats(low, high)


def scenes(task):
    """The default preset with up to five of its fields drawn."""
    places = [(None, field) for field in dataclasses.fields(task.params)]
    for name, cls in task.options.items():
        if task.scenes[task.default_scene].get(name):
            places += [(name, field) for field in dataclasses.fields(cls)]
    places = [(option, field) for option, field in places if (task.name, option, field.name) not in WIDTHS]
    drawn = st.sampled_from(range(len(places))).flatmap(lambda k: st.tuples(st.just(k), values(places[k][1])))

    def scene(pairs):
        found = {}
        for k, value in pairs:
            option, field = places[k]
            (found if option is None else found.setdefault(option, {}))[field.name] = value
        return found

    return st.lists(drawn, max_size=5).map(scene)


@pytest.mark.parametrize("env_id", ids())
def test_any_scene_is_refused_or_walked(env_id):
    task = task_of(env_id)

    @settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
    @given(scenes(task), st.integers(0, 2**64 - 1), st.integers(0, 2**32))
    def check(scene, key, seed):
        try:
            resolve(task, scene)
        except ValueError as error:
            assert any(words in str(error) for words in REFUSALS)
            return
        flights = []
        for _ in range(2):
            world = World(task, scene, ROWS)
            rows = world.observe()
            world.reset(np.arange(ROWS), np.arange(ROWS, dtype=np.uint64) ^ np.uint64(key), rows)
            draw, seen = np.random.default_rng(seed), []
            for _ in range(STEPS):
                rows, rewards, *_ = world.step(
                    draw.uniform(-1.5, 1.5, (ROWS, world.widths[1])), np.ones(ROWS, np.bool_), 10**6
                )
                assert all(row in world.observation_space for row in rows)
                assert ((rewards >= 0.0) & (rewards <= 1.0)).all()
                world.load(world.copy(), np.arange(ROWS))  # refuses what is not finite
                seen.append((rows.tobytes(), rewards.tobytes()))
            flights.append((seen, world.copy().tobytes()))
        assert flights[0] == flights[1]

    check()


@pytest.mark.parametrize("env_id", ids())
def test_drawn_scenes_follow_from_their_seed_and_are_both_taken_and_refused(env_id):
    task = task_of(env_id)
    drawn = [draw_scene(task, task.default_scene, seed) for seed in range(200)]
    assert drawn == [draw_scene(task, task.default_scene, seed) for seed in range(200)]
    said = [refused(task, scene) for scene in drawn]
    assert 20 < sum(words is None for words in said) < 180
