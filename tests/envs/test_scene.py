"""Scenes: presets, overrides, options, labels, and what is refused."""

import dataclasses
import json
from typing import ClassVar

import pytest

from vr_envs.envs.ball_on_bar import TASK
from vr_envs.envs.scene import resolve
from vr_envs.models.record import quantity


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
        ({"base": "nowhere"}, "nowhere.*bell, .*rolling"),
    ],
)
def test_what_is_refused_says_what_was_given_and_what_is_allowed(scene, message):
    with pytest.raises(ValueError, match=message):
        resolve(TASK, scene)


@dataclasses.dataclass(frozen=True)
class Slow:
    """An engine that knows one of the options only."""

    OPTIONS: ClassVar[tuple[str, ...]] = ("spin",)

    parts: int = quantity(4, "", "of an interval", low=1, high=100)


TWO_ENGINES = dataclasses.replace(TASK, engines={"slow": Slow, **TASK.engines})


def test_an_engine_is_laid_into_the_scene_with_its_settings():
    scene = resolve(TWO_ENGINES, {"slow": {"parts": 8}, "scatter": None})
    assert (scene.engine, scene.simulators["slow"].parts) == ("slow", 8)
    assert scene.label == "bell with no scatter, slow"
    assert resolve(TWO_ENGINES, json.loads(json.dumps(scene.as_dict()))) == scene
    assert resolve(TWO_ENGINES, scene.as_dict(), "slow") == scene
    other = resolve(TWO_ENGINES, scene.as_dict(), "rigid_body")
    assert (other.engine, other.simulators["slow"], other.options["scatter"]) == ("rigid_body", None, None)
    assert resolve(TWO_ENGINES, scene.as_dict(), "exact").label == "bell with no scatter"


@pytest.mark.parametrize(
    ("scene", "engine", "message"),
    [
        ({"slow": True, "rigid_body": True}, None, "slow and rigid_body exclude each other.*other to null"),
        (None, "slow", "'slow' does not know the option 'scatter'.*it knows spin: set 'scatter' to null"),
        (None, "fast", "has no engine 'fast'; choose one of exact, slow"),
        ({"rigid_body": {"step": 1.0}}, None, r"rigid_body.step = 1.0 is not allowed.*\[1e-06, 0.0005\] s"),
        ({"rigid_body": {"steps": 1}}, None, "'rigid_body'.*'steps'.*did you mean 'step'"),
        ({"rigid_bodies": True}, None, "did you mean 'rigid_body'"),
    ],
)
def test_an_engine_is_refused_with_what_is_allowed(scene, engine, message):
    with pytest.raises(ValueError, match=message):
        resolve(TWO_ENGINES, scene, engine)
