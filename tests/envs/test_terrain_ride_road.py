"""Roads of the ride's scenes: files, rules."""

import json
from pathlib import Path

import pytest

from vr_envs.envs.registry import task_of
from vr_envs.envs.scene import resolve
from vr_envs.models.road_options import Profile

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
