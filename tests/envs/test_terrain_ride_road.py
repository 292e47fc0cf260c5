"""Roads of the ride's scenes: files, rules."""

import dataclasses
import json
import math
from pathlib import Path

import numpy as np
import pytest

from vr_envs.envs.registry import task_of
from vr_envs.envs.scene import resolve
from vr_envs.envs.world import World
from vr_envs.models.road_options import Obstacle, Profile, Road, Wheel

TASK = task_of("vr_envs/TerrainRide-v0")
FILE = str(Path(__file__).resolve().parents[2] / "docs" / "road_profile.csv")


def test_a_scene_takes_the_path_of_a_profile_and_holds_its_numbers():
    scene = resolve(TASK, {"profile": FILE, "road": {"iso_class": "flat", "knot_spacing": 0.1}})
    assert scene.options["profile"] == Profile(**Profile.read(FILE))
    again = resolve(TASK, json.loads(json.dumps(scene.as_dict())))
    assert again.options == scene.options
    assert again.params == scene.params


@pytest.mark.parametrize(
    ("scene", "told"),
    [
        ({"profile": "no such file.csv"}, "'no such file.csv' cannot be read: .*; give the path of a CSV file"),
        ({"profile": FILE}, "road.knot_spacing = 0.2 is not allowed; it must not exceed profile.spacing = 0.1"),
        (
            {"profile": {"height": [0.0] * 4097}},
            "profile.height = 4097 numbers is not allowed; give a list of 1 to 4096",
        ),
        ({"wheel": {"radius": 5.0}, "road": {"knot_spacing": 0.1}}, "wheel.radius = 5 .* 30 road.knot_spacing = 3"),
        ({"obstacle": {"kind": "kurb"}}, "obstacle.kind = 'kurb' is not allowed; choose one of bump, pothole, kerb"),
        ({"road": None, "wheel": True}, "is not allowed without a road; give road = true, or"),
    ],
)
def test_a_road_that_cannot_be_is_refused(scene, told):
    with pytest.raises(ValueError, match=told):
        resolve(TASK, scene)


def at_the_limits():
    """Everything on the road at once, and one field at one end of its range, or of another kind."""
    usual = {
        "road": {"knot_spacing": 0.1},
        "profile": {"spacing": 0.1, "height": [0.0, 0.1, -0.1]},
        "bumps": True,
        "obstacle": {"length": 3.0, "every": 20.0},
        "wheel": True,
    }
    for name, cls in (("road", Road), ("profile", Profile), ("obstacle", Obstacle), ("wheel", Wheel)):
        for field in dataclasses.fields(cls):
            for value in field.metadata["choices"] or (field.metadata["low"], field.metadata["high"]):
                values = [value] * 4096 if field.name == "height" and name == "profile" else value
                yield {**usual, name: {**({} if usual[name] is True else usual[name]), field.name: values}}


@pytest.mark.filterwarnings("error")
def test_the_ends_of_every_range_are_finite_rides_or_refused():
    walked = 0
    for scene in at_the_limits():
        try:
            world = World(TASK, scene, 4)
        except ValueError as error:
            assert "is not allowed" in str(error)
            continue
        rows = np.empty((4, world.widths[0]), np.float32)
        world.reset(np.arange(4), np.arange(4, dtype=np.uint64), rows)
        for _ in range(20):
            rows, rewards, _, _ = world.step(np.zeros((4, world.widths[1])), np.ones(4, np.bool_), 10**6)
            assert all(row in world.observation_space for row in rows), world.scene.label
            assert ((rewards >= 0.0) & (rewards <= 1.0)).all(), world.scene.label
        assert np.isfinite(world.states["knots"]).all() and math.isfinite(world.states["travel"].sum())
        walked += 1
    assert walked > 20
