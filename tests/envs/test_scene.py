"""Scenes: presets, overrides, options, labels, and what is refused."""

import json

import pytest

from vr_envs.envs.ball_on_bar import TASK
from vr_envs.envs.scene import resolve


def test_overrides_are_laid_over_the_preset_and_its_options():
    scene = resolve(TASK, {"base": "rolling", "restitution": 0.8, "scatter": {"restitution": 0.05}})
    assert scene.params.restitution == 0.8
    assert scene.options["scatter"].restitution == 0.05
    assert scene.options["scatter"].normal == resolve(TASK, "rolling").options["scatter"].normal
    assert scene.options["spin"] is not None


@pytest.mark.parametrize("scene", ["bell", "rolling", {"scatter": None}, {"spin": True, "frequency": 20}])
def test_a_resolved_scene_survives_json(scene):
    resolved = resolve(TASK, scene)
    assert resolve(TASK, json.loads(json.dumps(resolved.as_dict()))) == resolved


@pytest.mark.parametrize(
    ("scene", "label"),
    [
        (None, "bell"),
        ("rolling", "rolling"),
        ({"restitution": 0.75}, "bell"),
        ({"restitution": 0.8, "scatter": None}, "bell with restitution = 0.8, no scatter"),
        ({"base": "rolling", "scatter": {"normal": 0.001}}, "rolling with scatter.normal = 0.001"),
        ({"spin": True}, "bell with spin"),
    ],
)
def test_the_label_says_what_differs_from_the_preset(scene, label):
    assert resolve(TASK, scene).label == label


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        ({"restitution": 1.2}, r"restitution = 1.2 is not allowed.*\[0, 1\]"),
        ({"restitution": float("nan")}, "restitution = nan is not allowed"),
        ({"restitution": "high"}, "restitution = 'high' is not a number"),
        ({"restitution": True}, "restitution = True is not a number"),
        ({"restituton": 0.5}, "restituton.*did you mean 'restitution'"),
        ({"scatter": {"norm": 0.1}}, "'scatter'.*'norm'.*did you mean 'normal'"),
        ({"scatter": 5}, "'scatter' = 5"),
        ({"scatter": {"normal": -1.0}}, "scatter.normal = -1.0"),
        ({"start_min": 0.02}, "start_min"),
        ({"tilt_acceleration": 5000.0, "frequency": 1.0}, "at most 0.3 rad"),
        ({"base": "nowhere"}, "nowhere.*bell, rolling"),
    ],
)
def test_what_is_refused_says_what_was_given_and_what_is_allowed(scene, message):
    with pytest.raises(ValueError, match=message):
        resolve(TASK, scene)
