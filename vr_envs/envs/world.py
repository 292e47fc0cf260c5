"""The records of a task in a scene and the kernels that move them: what the scalar and the batched env share."""

from __future__ import annotations

import copy
import dataclasses
import sys
import threading
from collections.abc import Mapping
from importlib import import_module
from typing import Any

import numpy as np
from gymnasium.spaces import Box

from vr_envs.envs.rows import RUNS, admit, in_lockstep, rows_of
from vr_envs.envs.scene import Scene, resolve
from vr_envs.envs.storage import Blocks, Plain, Storage
from vr_envs.envs.task import Channel, Task
from vr_envs.envs.workspace import Results, Workspace
from vr_envs.models.record import dtype_of

NO_LIMIT = np.iinfo(np.int64).max  # control intervals


def box(channels: tuple[Channel, ...]) -> Box:
    """The float32 Box of a list of channels."""
    low, high = (np.array([getattr(c, side) for c in channels], np.float32) for side in ("low", "high"))
    return Box(low, high, dtype=np.float32)


def episode_key(generator: np.random.Generator) -> int:
    """The 64-bit key from which an episode draws its start and all its disturbances."""
    return generator.bit_generator.random_raw()  # what `generator.integers` of all 64 bits gives, ten times as fast


def simulator_of(task_name: str, scene: Scene) -> Any:
    """What moves states in `scene` in place of the kernels: `advance(state, action)`; None if the kernels do.

    It is the `SIMULATOR` of the module that the engine's folder has for the task.
    """
    if scene.engine not in scene.simulators:
        return None
    return import_module(f"vr_envs.{scene.engine}.{task_name}").SIMULATOR(scene)


class World:
    """`n` records of one task in one scene, and the kernels that move them."""

    def __init__(self, task: Task, scene: str | Mapping[str, Any] | None, n: int, **choices: str | None) -> None:
        """`n` zeroed records of `task` in `scene`; `choices` (engine, observation) as for `resolve`."""
        self.task = task
        self.scene = resolve(task, scene, **choices)
        self.params, self.options = self.scene.records()
        self.simulator = simulator_of(task.name, self.scene)
        simulated = self.simulator is not None
        lockstep = not simulated and in_lockstep(task, self.scene, n)
        self.rows = rows_of(task, simulated, lockstep)
        self._kept = Blocks if lockstep else Plain
        self.storage: Storage = self._kept(dtype_of(task.state), n)
        self.count, self._blank = n, np.zeros(1, self.storage.dtype)
        self.observation_space = box(task.observation_channels(self.scene))
        self.action_space = box(task.action_channels(self.scene))
        self.widths = (self.observation_space.shape[0], self.action_space.shape[0])
        self._compiled = False
        self._workspace: Workspace | None = None

    def __getstate__(self) -> dict[str, Any]:
        """What a copy is made from: the workspace is bound to these records."""
        return {**self.__dict__, "_workspace": None}

    def compile(self) -> None:
        """Compile the kernels, or load them from the cache; a word on stderr if that takes longer than two seconds."""
        if self._compiled:
            return
        message = f"vr_envs: compiling {self.task.name}, scene {self.scene.name}; the next run will start at once"
        timer = threading.Timer(2.0, print, (message,), {"file": sys.stderr, "flush": True})
        timer.start()
        try:
            scratch = copy.copy(self)
            scratch.storage, scratch.count, scratch._compiled = self._kept(self.storage.dtype, 1), 1, True
            scratch.reset(np.zeros(1, np.intp), np.zeros(1, np.uint64), scratch.observe())
            scratch.step(np.zeros((1, self.widths[1])), np.ones(1, np.bool_), 1)
        finally:
            timer.cancel()
        self._compiled = True

    def actions(self, given: Any, shape: tuple[int, ...]) -> np.ndarray:
        """A fresh float64 copy of the actions, (n, width)."""
        try:
            actions = np.array(given, dtype=np.float64, order="C")
        except (TypeError, ValueError) as error:
            raise ValueError(f"action {given!r} is not an array of numbers; give shape {shape}") from error
        if actions.shape != shape:
            raise ValueError(f"action has shape {actions.shape}; give {shape}, each entry in [-1, 1]")
        return actions.reshape(self.count, self.widths[1])

    def step(self, actions: np.ndarray, live: np.ndarray, limit: int) -> Results:
        """Move the rows that are `live` (see `vr_envs.envs.rows`); returns fresh results."""
        workspace = self.workspace(limit)
        workspace.actions[...] = actions
        return workspace.step(live)

    def workspace(self, limit: int) -> Workspace:
        """What steps the rows, with episodes of `limit` control intervals; the same one until the limit changes."""
        if self._workspace is None or self._workspace.limit != limit:
            self.compile()
            self._workspace = Workspace(self, limit)
        return self._workspace

    def simulate(self, acts: np.ndarray, live: np.ndarray) -> None:
        """Let the simulator move the live rows, unless an action is not finite; `acts` are `row_records`."""
        if admit(acts, live) < 0:
            for i in np.flatnonzero(live == RUNS):
                self.simulator.advance(self.storage.array[i], acts[i]["row"])

    def reset(self, rows: np.ndarray, keys: np.ndarray, obs: np.ndarray) -> None:
        """Start the given rows afresh and write their observations."""
        self.compile()
        self.storage.write(rows, self._blank)
        self.rows.reset(self.storage.array, rows, keys, obs, self.params, self.options)

    @property
    def states(self) -> np.ndarray:
        """The records: themselves where they are kept one after another, else a copy that refuses to be written to."""
        return self.storage.records

    def copy(self) -> np.ndarray:
        """A copy of the records."""
        return self.storage.read(np.arange(self.count))

    def load(self, states: Any, rows: np.ndarray) -> None:
        """Overwrite the given rows with saved records, after checking them."""
        given = np.atleast_1d(np.asarray(states))
        if given.dtype != self.storage.dtype:
            raise ValueError(f"state is not a record of {self.task.name}; give what get_state() returned, in any scene")
        if given.shape != (len(rows),):
            raise ValueError(f"state has shape {given.shape}; give {len(rows)} records")
        for field in dataclasses.fields(self.task.state):
            values, low, high = given[field.name], field.metadata["low"], field.metadata["high"]
            if values.dtype.kind == "f" and not np.isfinite(values).all():
                raise ValueError(f"state field {field.name!r} is not finite; give what get_state() returned")
            if (values < low).any() or (values > high).any():
                raise ValueError(
                    f"state field {field.name!r} is not in [{low:g}, {high:g}]; give what get_state() returned"
                )
        self.storage.write(rows, given)

    def observe(self) -> np.ndarray:
        """Fresh observations of all rows."""
        self.compile()
        obs = np.empty((self.count, self.widths[0]), np.float32)
        self.rows.observe(self.storage.array, obs, self.params, self.options)
        return obs

    def metrics(self, rows: np.ndarray) -> dict[str, np.ndarray]:
        """Domain metrics of the given rows' episodes so far, one array per name; none if the scene does without."""
        if not self.scene.judged:
            return {}
        return dict(self.task.metrics(self.storage.read(rows), self.scene))


def scenario_keys(options: Mapping[str, Any] | None, n: int) -> np.ndarray | None:
    """The episode keys that `options` ask for, checked, or None."""
    scenario = (options or {}).get("scenario")
    if scenario is None:
        return None
    # as objects: NumPy would make floats of whole numbers on both sides of 2^63
    keys = np.atleast_1d(np.array(scenario, dtype=object))
    keys = np.broadcast_to(keys, (n,)) if keys.shape == (1,) else keys
    whole = all(isinstance(k, int | np.integer) and not isinstance(k, bool) and 0 <= k < 2**64 for k in keys.flat)
    if keys.shape != (n,) or not whole:
        raise ValueError(
            f"options['scenario'] = {scenario!r}; give an integer in [0, 2^64), or one for each of {n} envs"
        )
    return keys.astype(np.uint64)


def check_options(options: Mapping[str, Any] | None, allowed: tuple[str, ...]) -> None:
    """Refuse unknown reset options, and two that contradict each other."""
    for key in options or {}:
        if key not in allowed:
            raise ValueError(f"reset option {key!r} is unknown; allowed: {', '.join(allowed)}")
    if options and options.get("scenario") is not None and options.get("state") is not None:
        raise ValueError("reset options 'scenario' and 'state' exclude each other; give one")
