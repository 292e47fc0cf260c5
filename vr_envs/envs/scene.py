"""Scenes: a preset's name or a dict of overrides becomes one checked, fully resolved set of parameters.

A scene is JSON-able: `"bell"`, `{"restitution": 0.8}` (over the default preset) or
`{"base": "bell", "scatter": None, "spin": True}`. An option is None (absent: compiled away), True (present with
its defaults), a dict of overrides of its fields, or, where its class can read files, the path of one. An engine other
than the exact one is laid in like an option.
"""

from __future__ import annotations

import dataclasses
import difflib
import functools
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vr_envs.models.record import checked, pack

if TYPE_CHECKING:
    from vr_envs.envs.task import Task


@dataclasses.dataclass(frozen=True)
class Scene:
    """A resolved scene: `params` and one entry per option and per simulator (None when absent), as dataclass instances.

    `engine` names what moves the state; its settings are the entry of that name.
    """

    name: str
    params: Any
    options: dict[str, Any]
    simulators: dict[str, Any]
    engine: str
    observation: str
    label: str
    """The preset's name, and what differs from the preset."""

    def records(self) -> tuple[np.void, tuple[np.void | None, ...]]:
        """The records that kernels take: (params, options in kernel order); packed once, not to be written to."""
        return self._records

    @functools.cached_property
    def _records(self) -> tuple[np.void, tuple[np.void | None, ...]]:
        return pack(self.params), tuple(None if o is None else pack(o) for o in self.options.values())

    @property
    def judged(self) -> bool:
        """Whether episodes have metrics: not if the task has an option `metrics` that is absent here."""
        return self.options.get("metrics", ...) is not None

    @property
    def added(self) -> dict[str, Any]:
        """Options and simulators together."""
        return {**self.options, **self.simulators}

    def as_dict(self) -> dict[str, Any]:
        """Every resolved value, JSON-able; `resolve(task, scene.as_dict())` gives the same scene."""
        added = {k: None if o is None else dataclasses.asdict(o) for k, o in self.added.items()}
        return {"base": self.name, **dataclasses.asdict(self.params), **added}


def unknown_key(key: str, allowed: list[str], where: str) -> ValueError:
    """The error for a key that `where` does not have: it names the closest match and all that are allowed."""
    close = difflib.get_close_matches(str(key), allowed, n=1)
    hint = f"; did you mean {close[0]!r}?" if close else "."
    return ValueError(f"{where} has no key {key!r}{hint} Allowed: {', '.join(allowed)}")


def _field_names(cls: type) -> list[str]:
    return [f.name for f in dataclasses.fields(cls)]


def _merge(task: Task, merged: dict[str, Any], overrides: Mapping[str, Any], where: str) -> None:
    """Lay `overrides` over `merged`; dicts of an option are laid over that option's earlier dict."""
    params = _field_names(task.params)
    allowed = ["base", *params, *task.additions]
    for key, value in overrides.items():
        if key == "base":
            continue
        if key in params:
            merged[key] = value
        elif key not in task.additions:
            raise unknown_key(key, allowed, where)
        elif value is None or value is False:
            merged[key] = None
        elif value is True or isinstance(value, Mapping):
            earlier = merged.get(key) or {}
            merged[key] = {**earlier, **({} if value is True else value)}
        elif isinstance(value, str) and hasattr(task.additions[key], "read"):
            merged[key] = task.additions[key].read(value)
        else:
            file = ", the path of a file" if hasattr(task.additions[key], "read") else ""
            raise ValueError(f"{where}: option {key!r} = {value!r}; give null, true{file} or a dict of its fields")
    for group in task.rivals:
        given = [name for name in group if overrides.get(name) not in (None, False)]
        if len(given) > 1:
            raise ValueError(f"{' and '.join(given)} exclude each other; give one and set the other to null")
        merged.update(dict.fromkeys(set(group) - set(given)) if given else {})


def _choose(kind: str, given: str | None, names: tuple[str, ...], merged: dict[str, Any], task: Task) -> str:
    """Which of the `names` of a kind ("engine", "observation") is in `merged`; the first needs no entry.

    `given`, if not None, is put in place of what is there.
    """
    if given is not None:
        if given not in names:
            raise ValueError(f"{task.name} has no {kind} {given!r}; choose one of {', '.join(names)}")
        for name in names[1:]:
            merged[name] = (merged.get(name) or {}) if name == given else None
    present = [name for name in names[1:] if merged.get(name) is not None]
    if len(present) > 1:
        raise ValueError(f"{' and '.join(present)} exclude each other; give one and set the other to null")
    return present[0] if present else names[0]


def _check_support(task: Task, scene: Scene) -> None:
    """Refuse an option that the engine of the scene does not know."""
    known = getattr(task.engines.get(scene.engine), "OPTIONS", None)
    if known is not None:
        for name, record in scene.options.items():
            if record is not None and name not in known:
                raise ValueError(
                    f"engine {scene.engine!r} does not know the option {name!r} of {task.name}; it knows "
                    f"{', '.join(known)}: set {name!r} to null, or use the engine {task.engine_names[0]!r}"
                )


def resolve(
    task: Task,
    scene: str | Mapping[str, Any] | None = None,
    engine: str | None = None,
    observation: str | None = None,
) -> Scene:
    """Resolve and check a scene of `task`; None is the task's default preset.

    Args:
        task: whose scene it is.
        scene: a preset's name or a dict of overrides.
        engine: a name, in place of the engine that the scene has; settings that the scene has for it stay.
        observation: "state" or a sensor's name, likewise.

    Raises:
        ValueError: unknown name (of a preset, key, engine or observation), wrong type, not finite or out of range;
            it names what was given and what is allowed.
    """
    overrides: Mapping[str, Any] = {} if scene is None or isinstance(scene, str) else scene
    if not isinstance(overrides, Mapping):
        raise ValueError(f"scene = {scene!r} is not allowed; give a preset's name or a dict of overrides")
    base = scene if isinstance(scene, str) else overrides.get("base", task.default_scene)
    if not isinstance(base, str) or base not in task.scenes:
        raise ValueError(f"{task.name} has no scene {base!r}; choose one of {', '.join(task.scenes)}")
    merged: dict[str, Any] = {}
    _merge(task, merged, task.scenes[base], f"preset {base!r}")
    _merge(task, merged, overrides, f"scene of {task.name}")
    engine_name = _choose("engine", engine, task.engine_names, merged, task)
    observed = _choose("observation", observation, task.observation_names, merged, task)
    added: dict[str, Any] = {}
    for name, cls in task.additions.items():
        values = merged.pop(name, None)
        if values is not None:
            for key in values:
                if key not in _field_names(cls):
                    raise unknown_key(key, _field_names(cls), f"option {name!r} of {task.name}")
        added[name] = None if values is None else checked(cls, values, f"{name}.")
    options = {name: added[name] for name in task.options}
    simulators = {name: added[name] for name in task.simulators}
    resolved = Scene(base, checked(task.params, merged, ""), options, simulators, engine_name, observed, base)
    task.validate(resolved)
    _check_support(task, resolved)
    if engine is None and observation is None and (scene is None or isinstance(scene, str)):
        return resolved
    return dataclasses.replace(resolved, label=_label(resolved, resolve(task, base)))


def _label(scene: Scene, preset: Scene) -> str:
    """The preset's name with the values that differ from it."""
    changes = []
    for key, value in scene.as_dict().items():
        usual = preset.as_dict()[key]
        if isinstance(value, dict) and isinstance(usual, dict):
            changes += [f"{key}.{k} = {_brief(v)}" for k, v in value.items() if v != usual[k]]
        elif value != usual:
            changes.append(
                f"no {key}" if value is None else key if isinstance(value, dict) else f"{key} = {_brief(value)}"
            )
    return f"{scene.name} with {', '.join(changes)}" if changes else scene.name


def _brief(value: Any) -> str:
    if isinstance(value, tuple):
        return f"{len(value)} numbers"
    return f"{value:g}" if isinstance(value, float) else str(value)
