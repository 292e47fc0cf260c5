"""A task: what turns a model into an environment. Data and compiled functions; knows no Gymnasium class."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from vr_envs.envs.scene import Scene


@dataclasses.dataclass(frozen=True)
class Channel:
    """One number of an observation or action: its name, its unit or what 1 stands for, its meaning and scaled range."""

    name: str
    unit: str
    doc: str
    low: float = -1.0
    high: float = 1.0


@dataclasses.dataclass(frozen=True)
class Metrics:
    """What is counted of an episode, and told when it ends; without it neither is done."""


@dataclasses.dataclass(frozen=True)
class Lockstep:
    """How a batch moves neighbouring records side by side, on lanes (`vr_envs.models.lanes`).

    `possible(scene)`: whether the kernels of a scene can be compiled for lanes; outcome and observe are the task's.
    `ready(state, params, *options)`: a mask, whether nothing out of the ordinary will happen to a record in the next
    control interval; in it `advance(state, action, params, *options)` does to every record what the task's does.
    """

    possible: Callable[[Scene], bool]
    ready: Any
    advance: Any


def _accept(scene: Scene) -> None:
    """No constraint between the values of a scene."""


@dataclasses.dataclass(frozen=True)
class Task:
    """Everything that the environment classes need to know of one system.

    The kernels take one record each, and every option record (or None) by position, in the order of `options`:
    `start(state, params, *options)` (the key is already in `state.key`),
    `advance(state, action, params, *options)`, `outcome(state, action, params, *options) -> (reward, terminated)`,
    `observe(state, row, params, *options)`. A state has the fields `key` (u8) and `steps` (i8), kept by the caller.

    `engines` are the ways of moving a state other than the exact one, name -> record of settings. One that is also
    an option of the kernels is theirs; another stands in place of `advance`, in `vr_envs.<engine>.<task name>`. A
    record that has the class attribute `OPTIONS` names there the options that the engine knows. `sensors` are the
    options by which the state is observed otherwise than as it is; they exclude each other. So do the options of each
    group in `rivals`: one that is laid over a preset takes the place of that in the preset. With `lockstep` a large
    batch is moved eight records at a time, to the same bytes.
    """

    name: str
    params: type
    options: dict[str, type]
    state: type
    scenes: dict[str, dict[str, Any]]
    default_scene: str
    levels: dict[str, dict[str, Any]]
    start: Any
    advance: Any
    outcome: Any
    observe: Any
    observation_channels: Callable[[Scene], tuple[Channel, ...]]
    action_channels: Callable[[Scene], tuple[Channel, ...]]
    metrics: Callable[[np.ndarray, Scene], Mapping[str, np.ndarray]]
    dt: Callable[[Scene], float]
    validate: Callable[[Scene], None] = _accept
    engines: dict[str, type] = dataclasses.field(default_factory=dict)
    sensors: tuple[str, ...] = ()
    rivals: tuple[tuple[str, ...], ...] = ()
    lockstep: Lockstep | None = None

    @property
    def engine_names(self) -> tuple[str, ...]:
        """Every engine, the exact one first."""
        return ("exact", *self.engines)

    @property
    def observation_names(self) -> tuple[str, ...]:
        """Every way of observing the state, as it is first."""
        return ("state", *self.sensors)

    @property
    def simulators(self) -> dict[str, type]:
        """The engines that are no option of the kernels."""
        return {name: cls for name, cls in self.engines.items() if name not in self.options}

    @property
    def additions(self) -> dict[str, type]:
        """Everything that a scene may add to the parameters: options and simulators."""
        return {**self.options, **self.simulators}
