"""BatchEnv: many records behind Gymnasium's vector interface, stepped by the same compiled loop as `scalar.py`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import gymnasium as gym
import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from vr_envs.envs.rows import BEGINS, RUNS
from vr_envs.envs.task import Task
from vr_envs.envs.world import NO_LIMIT, World, check_options, episode_key, scenario_keys


class BatchEnv(gym.vector.VectorEnv[np.ndarray, np.ndarray, np.ndarray]):
    """`num_envs` environments in one call, identical to a SyncVectorEnv of ScalarEnv."""

    task: ClassVar[Task]
    metadata: dict[str, Any] = {"render_modes": [], "render_fps": 30}

    def __init__(
        self,
        num_envs: int = 1,
        scene: str | Mapping[str, Any] | None = None,
        max_episode_steps: int | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        engine: str | None = None,
        observation: str | None = None,
    ) -> None:
        """See the scalar class for scenes, engines and observations.

        Args:
            num_envs: number of rows, at least 1.
            scene: preset or overrides, the same for all rows.
            max_episode_steps: control intervals after which a row is truncated; None is never.
            autoreset_mode: a member of AutoresetMode, its name ("NEXT_STEP") or its value ("NextStep").
            render_mode: None; a batch draws no pictures.
            engine: one that moves its states in kernels.
            observation: "state" or a sensor.
        """
        if not _is_count(num_envs):
            raise ValueError(f"num_envs = {num_envs!r}; give a whole number of at least 1")
        if max_episode_steps is not None and not _is_count(max_episode_steps):
            raise ValueError(f"max_episode_steps = {max_episode_steps!r}; give a whole number of at least 1, or None")
        if render_mode is not None:
            raise ValueError(
                f"render_mode = {render_mode!r}: a batch draws no pictures; use gym.make for one environment"
            )
        self.autoreset_mode = _autoreset_mode(autoreset_mode)
        self.metadata = {**self.metadata, "autoreset_mode": self.autoreset_mode}
        self.num_envs = int(num_envs)
        self.world = World(self.task, scene, self.num_envs, engine=engine, observation=observation)
        if self.world.simulator is not None:
            raise ValueError(
                f"engine {self.engine!r} moves one environment at a time, a native batch of it would be no faster; use "
                "gym.make, or several of these in gym.make_vec(..., vectorization_mode='sync')"
            )
        self.single_observation_space = self.world.observation_space
        self.single_action_space = self.world.action_space
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._limit = NO_LIMIT if max_episode_steps is None else min(int(max_episode_steps), NO_LIMIT)
        self._generators: list[np.random.Generator | None] = [None] * self.num_envs
        self._seeds: list[int] = [-1] * self.num_envs
        self._done = np.zeros(self.num_envs, np.bool_)
        self._ready = np.zeros(self.num_envs, np.bool_)
        self._begun = self._ended = False  # all rows have begun an episode; some row's has ended

    @property
    def engine(self) -> str:
        """What moves the states, as in the scalar class."""
        return self.world.scene.engine

    @property
    def np_random(self) -> tuple[np.random.Generator, ...]:  # type: ignore[override]
        """One generator per row, as a SyncVectorEnv has."""
        return tuple(self._generator(i) for i in range(self.num_envs))

    @property
    def np_random_seed(self) -> tuple[int, ...]:  # type: ignore[override]
        """One seed per row."""
        return tuple(self._seeds[i] for i in range(self.num_envs) if self._generator(i))

    def _generator(self, row: int) -> np.random.Generator:
        generator = self._generators[row]
        if generator is None:
            generator, self._seeds[row] = seeding.np_random()
            self._generators[row] = generator
        return generator

    def _keys(self, rows: np.ndarray) -> np.ndarray:
        return np.fromiter((episode_key(self._generator(i)) for i in rows), np.uint64, len(rows))

    def reset(  # type: ignore[override]
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Start episodes in all rows, or in those of `options["reset_mask"]` (the others stay as they are).

        `options` may also hold "scenario" (an episode key for all, or one each) or "state" (n saved records).
        Row i is seeded with `seed + i`.
        """
        check_options(options, ("scenario", "state", "reset_mask"))
        keys = scenario_keys(options, self.num_envs)
        rows = np.flatnonzero(self._mask((options or {}).get("reset_mask")))
        state = (options or {}).get("state")
        seeds = (
            seed
            if isinstance(seed, list | tuple)
            else [None if seed is None else seed + i for i in range(self.num_envs)]
        )
        if len(seeds) != self.num_envs:
            raise ValueError(f"{len(seeds)} seeds for {self.num_envs} envs; give one each")
        # what may refuse comes before anything has changed
        generators = {int(i): seeding.np_random(seeds[i]) for i in rows if seeds[i] is not None}
        if state is not None:
            given = np.atleast_1d(np.asarray(state))
            if len(given) not in (1, self.num_envs):
                raise ValueError(
                    f"options['state'] has {len(given)} records; give one, or one for each of {self.num_envs} envs"
                )
            self.world.load(np.broadcast_to(given, self.num_envs)[rows], rows)
        for i, (generator, used) in generators.items():
            self._generators[i], self._seeds[i] = generator, used
        if state is None:
            unseen = np.empty((self.num_envs, self.world.widths[0]), np.float32)
            self.world.reset(rows, self._keys(rows) if keys is None else keys[rows], unseen)
        self._done[rows] = False
        self._ready[rows] = True
        self._begun, self._ended = bool(self._ready.all()), bool(self._done.any())
        return self.world.observe(), {}

    def _mask(self, mask: Any) -> np.ndarray:
        if mask is None:
            return np.ones(self.num_envs, np.bool_)
        if (
            not isinstance(mask, np.ndarray)
            or mask.dtype != np.bool_
            or mask.shape != (self.num_envs,)
            or not mask.any()
        ):
            raise ValueError(
                f"options['reset_mask'] = {mask!r}; give a bool array of shape ({self.num_envs},) with a True"
            )
        return mask

    def step(self, actions: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Move every row by one control interval; every returned array is fresh.

        Raises:
            ValueError: wrong shape or non-finite actions (the message names the env); nothing is stepped.
            ResetNeeded: before the first reset, or, in DISABLED mode, while a finished row has not been reset.
        """
        if not self._begun:
            raise ResetNeeded(f"env {int(np.argmin(self._ready))} has not begun an episode; call reset() before step()")
        live = stale = None
        stopped = self._ended
        if stopped:
            if self.autoreset_mode is AutoresetMode.DISABLED:
                raise ResetNeeded(
                    f"env {int(np.argmax(self._done))} has ended; reset it with options={{'reset_mask': ...}}"
                )
            if self.autoreset_mode is AutoresetMode.NEXT_STEP:
                live, stale = np.where(self._done, np.uint8(BEGINS), np.uint8(RUNS)), self._done
        workspace = self.world.workspace(self._limit)
        workspace.take(actions, (self.num_envs, self.world.widths[1]))
        obs, rewards, terminated, truncated = workspace.step(live)
        self._ended = workspace.ended
        infos: dict[str, Any] = {}
        if self._ended:
            self._done = done = terminated | truncated
            rows = np.flatnonzero(done)
            infos = self._end_infos(done, rows)
            if self.autoreset_mode is AutoresetMode.SAME_STEP:
                infos = self._final(done, rows, obs, infos)
                self.world.reset(rows, self._keys(rows), obs)
        elif stopped:
            self._done = np.zeros(self.num_envs, np.bool_)
        if stale is not None:
            rows = np.flatnonzero(stale)
            self.world.reset(rows, self._keys(rows), obs)
        return obs, rewards, terminated, truncated, infos

    def _end_infos(self, done: np.ndarray, rows: np.ndarray) -> dict[str, Any]:
        """Metrics of the `rows` that are `done`, in the layout of `VectorEnv._add_info`."""
        infos: dict[str, Any] = {}
        found = self.world.metrics(rows)
        masks = np.broadcast_to(done, (len(found), self.num_envs)).copy()  # one each, cheaper than one by one
        for mask, (name, values) in zip(masks, found.items(), strict=True):
            infos[name] = column = np.zeros(self.num_envs, values.dtype)
            column[rows] = values
            infos[f"_{name}"] = mask
        return infos

    def _final(self, done: np.ndarray, rows: np.ndarray, obs: np.ndarray, infos: dict[str, Any]) -> dict[str, Any]:
        final_obs = np.empty(self.num_envs, dtype=object)
        for i in rows:
            final_obs[i] = obs[i].copy()
        return {"final_obs": final_obs, "_final_obs": done.copy(), "final_info": infos, "_final_info": done.copy()}

    def get_state(self) -> np.ndarray:
        """A copy of all records, shape (num_envs,)."""
        return self.world.copy()

    def set_state(self, states: Any) -> None:
        """Go to records that `get_state` returned."""
        self.world.load(states, np.arange(self.num_envs))
        self._done[:] = False
        self._ready[:] = True
        self._begun, self._ended = True, False


def _is_count(number: Any) -> bool:
    return isinstance(number, int | np.integer) and not isinstance(number, bool) and int(number) >= 1


def _autoreset_mode(given: str | AutoresetMode) -> AutoresetMode:
    if isinstance(given, AutoresetMode):
        return given
    for mode in AutoresetMode:
        if given in (mode.name, mode.value):
            return mode
    raise ValueError(f"autoreset_mode = {given!r}; choose one of {', '.join(m.name for m in AutoresetMode)}")
