"""The native batch environment as a Stable-Baselines3 VecEnv."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode
from stable_baselines3.common.vec_env import VecEnv

from vr_envs.envs.batch import BatchEnv


class BatchVecEnv(VecEnv):
    """Rows of a BatchEnv in SAME_STEP mode, with the infos that Stable-Baselines3 reads at an episode's end.

    Those are `terminal_observation`, `TimeLimit.truncated`, the episode's metrics, and `episode` with its return
    "r", length "l" and the seconds since the start "t", as the Monitor wrapper reports them.
    """

    def __init__(self, batch: BatchEnv, reward_scale: float = 1.0, stagger: int = 0) -> None:
        """Adapt `batch`.

        Args:
            batch: its `autoreset_mode` is SAME_STEP.
            reward_scale: factor on the rewards that the learner sees; `episode` keeps the environment's own.
            stagger: control intervals over which the ends of the rows' first episodes are spread evenly, so that a
                short rollout holds every part of an episode; 0 keeps the rows in step. A first episode that is cut
                for this is reported as truncated and gets no "episode" info.

        Raises:
            ValueError: another autoreset mode.
        """
        if batch.autoreset_mode is not AutoresetMode.SAME_STEP:
            raise ValueError(f"autoreset_mode = {batch.autoreset_mode}; Stable-Baselines3 needs SAME_STEP")
        self.batch = batch
        self.reward_scale = reward_scale
        self.stagger = stagger
        self._start = time.perf_counter()
        self._returns = np.zeros(batch.num_envs)
        self._lengths = np.zeros(batch.num_envs, np.int64)
        self._never = np.zeros(batch.num_envs, np.int64)
        self._cut = self._never  # length at which a row's first episode is cut; 0 is never
        super().__init__(batch.num_envs, batch.single_observation_space, batch.single_action_space)

    def reset(self) -> np.ndarray:
        """Start an episode in every row, with the seeds that `seed` set."""
        obs, _ = self.batch.reset(seed=list(self._seeds))
        self._reset_seeds()
        self._returns[:] = 0.0
        self._lengths[:] = 0
        self._cut = 1 + np.arange(self.num_envs) * self.stagger // self.num_envs if self.stagger else self._never
        return obs

    def step_async(self, actions: np.ndarray) -> None:
        """Keep the actions for `step_wait`."""
        self._actions = actions

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Move every row; a row that ended already shows the next episode's first observation."""
        obs, rewards, terminated, truncated, batch_infos = self.batch.step(self._actions)
        done = terminated | truncated
        self._returns += rewards
        self._lengths += 1
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        if done.any():
            self._end(np.flatnonzero(done), truncated & ~terminated, batch_infos, infos)
        cut = (self._lengths == self._cut) & ~done
        if cut.any():
            for i in np.flatnonzero(cut):
                infos[i] = {"terminal_observation": obs[i].copy(), "TimeLimit.truncated": True}
            obs[cut] = self.batch.reset(options={"reset_mask": cut})[0][cut]
            self._returns[cut], self._lengths[cut] = 0.0, 0
            done = done | cut
        if self._cut is not self._never and done.any():
            self._cut = np.where(done, 0, self._cut)
        return obs, (rewards * self.reward_scale).astype(np.float32), done, infos

    def _end(self, rows: np.ndarray, timed_out: np.ndarray, batch_infos: dict[str, Any], infos: list[Any]) -> None:
        elapsed = round(time.perf_counter() - self._start, 6)
        metrics = {k: v for k, v in batch_infos["final_info"].items() if not k.startswith("_")}
        for i in rows:
            infos[i] = {name: values[i] for name, values in metrics.items()}
            infos[i]["terminal_observation"] = batch_infos["final_obs"][i]
            infos[i]["TimeLimit.truncated"] = bool(timed_out[i])
            infos[i]["episode"] = {"r": round(float(self._returns[i]), 6), "l": int(self._lengths[i]), "t": elapsed}
        self._returns[rows] = 0.0
        self._lengths[rows] = 0

    def close(self) -> None:
        """Close the batch."""
        self.batch.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """The batch's attribute, once per row asked for."""
        return [getattr(self.batch, attr_name)] * len(self._rows(indices))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Not possible: the rows share one environment."""
        raise NotImplementedError("the rows of a batch share one environment; set attributes on it before adapting it")

    def env_method(self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any) -> list[Any]:
        """Not possible: the rows share one environment."""
        raise NotImplementedError("the rows of a batch share one environment; call its methods on `.batch`")

    def env_is_wrapped(self, wrapper_class: type[gym.Wrapper], indices: Any = None) -> list[bool]:
        """A batch accepts no wrappers."""
        return [False] * len(self._rows(indices))

    def _rows(self, indices: Any) -> Sequence[int]:
        return range(self.num_envs) if indices is None else np.atleast_1d(indices).tolist()
