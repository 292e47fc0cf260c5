"""ScalarEnv: one record behind Gymnasium's interface of one environment.

It steps the same compiled loop over rows as `batch.py`, so a batch is this environment, byte for byte.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import gymnasium as gym
import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.utils import seeding

from vr_envs.envs.task import Task
from vr_envs.envs.world import NO_LIMIT, World, check_options, episode_key, scenario_keys


class ScalarEnv(gym.Env[np.ndarray, np.ndarray]):
    """One environment. Subclasses set `task` and document it."""

    task: ClassVar[Task]
    metadata: dict[str, Any] = {"render_modes": ["rgb_array", "human"], "render_fps": 30}

    def __init__(
        self,
        scene: str | Mapping[str, Any] | None = None,
        render_mode: str | None = None,
        engine: str | None = None,
        observation: str | None = None,
    ) -> None:
        """See the class for scenes, engines and observations; `render_mode` is None, "rgb_array" or "human"."""
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            raise ValueError(f"render_mode = {render_mode!r}; choose one of {self.metadata['render_modes']} or None")
        self.world = World(self.task, scene, 1, engine=engine, observation=observation)
        self.observation_space = self.world.observation_space
        self.action_space = self.world.action_space
        self.render_mode = render_mode
        self._row = np.zeros(1, np.intp)
        self._shape = (self.world.widths[1],)
        self._limit = NO_LIMIT
        self._ready = self._restored = False
        self._painter: Any = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Start an episode; `options` may hold "scenario" (an episode key) or "state" (a saved record)."""
        check_options(options, ("scenario", "state"))
        keys = scenario_keys(options, 1)
        if options and options.get("state") is not None:
            if seed is not None:
                seeding.np_random(seed)  # may refuse, as the state may, before anything has changed
            self.set_state(options["state"])
        super().reset(seed=seed)
        self._take_limit()
        if options and options.get("state") is not None:
            obs = self.world.observe()
        else:
            keys = np.array([episode_key(self.np_random)], np.uint64) if keys is None else keys
            obs = np.empty((1, self.world.widths[0]), np.float32)
            self.world.reset(self._row, keys, obs)
            self._restored = False
        self._ready = True
        if self.render_mode == "human":
            self.render()
        return obs[0], {}

    def _take_limit(self) -> None:
        """Take the registered time limit: gym.make strikes it from the spec that the environment sees."""
        if self.spec is not None:
            self._limit = gym.registry.get(self.spec.id, self.spec).max_episode_steps or NO_LIMIT

    def step(self, action: Any) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Move by one control interval. The last step's info holds the episode's metrics.

        Raises:
            ValueError: wrong shape or non-finite action; the environment is unchanged.
            ResetNeeded: before the first reset, or after termination.
        """
        if not self._ready:
            raise ResetNeeded("the episode has ended or has not begun; call reset() before step()")
        workspace = self.world.workspace(self._limit)
        workspace.take(action, self._shape)
        obs, rewards, ended, over = workspace.move()
        terminated, truncated = ended.item(), over.item()
        info: dict[str, Any] = {}
        if terminated or (truncated and (self._restored or self.world.storage.array["steps"].item() == self._limit)):
            info = self.metrics()
            self._ready = not terminated
        if self.render_mode == "human":
            self.render()
        return obs[0].copy(), rewards.item(), terminated, self._restored and truncated, info

    @property
    def engine(self) -> str:
        """What moves the state: "exact" or another engine of the task."""
        return self.world.scene.engine

    def metrics(self) -> dict[str, Any]:
        """Domain metrics of the episode so far, as the last step's info has them.

        An environment does not see a time limit that `gym.make(..., max_episode_steps=n)` lays over the registered
        one; ask for the metrics here then.
        """
        return {name: values[0].item() for name, values in self.world.metrics(self._row).items()}

    def get_state(self) -> np.void:
        """A copy of the record: with it and the actions, the episode replays to the same bytes."""
        return self.world.copy()[0]

    def set_state(self, state: Any) -> None:
        """Go to a record that `get_state` returned.

        A TimeLimit wrapper counts from its own last reset; a restored episode is truncated by the environment
        itself, when the record has made the registered number of steps.
        """
        self.world.load(state, self._row)
        self._take_limit()
        self._ready = self._restored = True

    def render(self) -> Any:
        """A picture of the present state: (height, width, 3) uint8, or None in "human" mode."""
        if self.render_mode is None:
            gym.logger.warn('render() does nothing without a render_mode; give render_mode="rgb_array" to gym.make')
            return None
        if self._painter is None:
            from vr_envs.render import painter

            self._painter = painter(self.task.name, self.world.scene, self.render_mode)
        return self._painter.draw(self.world.states[0])

    def close(self) -> None:
        """Close the window, if one is open."""
        if self._painter is not None:
            self._painter.close()
            self._painter = None
