"""Who is measured: one environment in several forms, each a call that moves all its rows by one step.

Actions are drawn before the clock starts, uniformly over a part of their range: what a step costs can depend on what is
done, as a ball's does on how often it bounces. Resets are paid for in every form; every step returns fresh arrays.
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
from collections.abc import Callable, Iterator
from typing import Any

import gymnasium as gym
import numpy as np

from vr_envs.bench.speed.arrays.autopilot import AutopilotArrays
from vr_envs.bench.speed.arrays.autopilot_airliner import AirlinerArrays
from vr_envs.bench.speed.arrays.ball_on_bar import BallArrays
from vr_envs.bench.speed.arrays.namespace import NUMPY, Arrays
from vr_envs.bench.speed.arrays.terrain_ride import RideArrays
from vr_envs.envs.batch import BatchEnv
from vr_envs.envs.registry import limit_of, spec_of, task_of
from vr_envs.envs.scene import resolve

ACTION_SETS = 16
ACTIONS = {"full range": 1.0, "small": 0.1}  # name -> largest absolute value
COUNTED_ROWS, COUNTED_STEPS = 64, 320  # over which impacts are counted: more than two episodes
IMPACTS = "impacts_per_cycle"  # the metric of tasks whose steps have impacts
CARTPOLE = "CartPole-v1"


@dataclasses.dataclass(frozen=True)
class Case:
    """A scene of an environment, with a kind of `ACTIONS`.

    `goal`: steps per second that a batch of 1024 rows is to make; `opponent`: the scene on whole arrays, if written: a
    class with `start`, `step`, `jax` (whether JAX can compile it) and `note` (a sentence for the report, or None).
    """

    env_id: str
    scene: str | None
    actions: str = "full range"
    goal: float | None = None
    opponent: Any = None

    @property
    def label(self) -> str:
        """Short name of id, scene and, if small, actions."""
        name = f"{spec_of(self.env_id).name} {self.scene or 'default'}"
        return name if self.actions == "full range" else f"{name}, {self.actions} actions"


CASES = (
    Case("vr_envs/BallOnBar-v0", "bell", "full range", 1e6, BallArrays),
    Case("vr_envs/BallOnBar-v0", "bell", "small", 1e6, BallArrays),
    Case("vr_envs/Autopilot-v1", "lecture", "full range", 30e6, AutopilotArrays),
    Case("vr_envs/Autopilot-v1", "lecture", "small", 30e6, AutopilotArrays),
    Case("vr_envs/Autopilot-v1", "airliner", "full range", 10e6, AirlinerArrays),
    Case("vr_envs/TerrainRide-v0", "lecture", "full range", 30e6, RideArrays),
    Case("vr_envs/TerrainRide-v0", "road", "full range"),
)


def cases_of(env_ids: list[str] | None) -> list[Case]:
    """The `CASES` of some ids, all without any; of an id that has none, its default scene with each kind of actions.

    Raises:
        ValueError: unknown id.
    """
    if env_ids is None:
        return list(CASES)
    found: list[Case] = []
    for name in dict.fromkeys(spec_of(env_id).id for env_id in env_ids):
        own = [case for case in CASES if case.env_id == name]
        found += own or [Case(name, None, actions) for actions in ACTIONS]
    return found


def draw(actions: str, rows: int, width: int, seed: int = 0) -> np.ndarray:
    """`ACTION_SETS` batches of actions of a kind of `ACTIONS`, float32, (sets, rows, width).

    Raises:
        ValueError: unknown kind.
    """
    if actions not in ACTIONS:
        raise ValueError(f"actions = {actions!r}; choose one of {', '.join(ACTIONS)}")
    size = ACTIONS[actions]
    return np.random.default_rng(seed).uniform(-size, size, (ACTION_SETS, rows, width)).astype(np.float32)


def _batch(case: Case, rows: int) -> BatchEnv:
    env = gym.make_vec(
        spec_of(case.env_id).id, num_envs=rows, vectorization_mode="vector_entry_point", scene=case.scene
    ).unwrapped
    assert isinstance(env, BatchEnv)
    return env


def _stepping(env: Any, actions: Iterator[Any]) -> Callable[[], None]:
    """Step a vector environment, which resets its own rows."""
    env.reset(seed=0)
    step, following = env.step, actions.__next__

    def work() -> None:
        step(following())

    return work


def _episodes(env: Any, actions: Iterator[Any]) -> Callable[[], None]:
    """Step one environment, and reset it when an episode ends."""
    env.reset(seed=0)
    step, following = env.step, actions.__next__

    def work() -> None:
        _, _, terminated, truncated, _ = step(following())
        if terminated or truncated:
            env.reset()

    return work


def native(case: Case, rows: int) -> Callable[[], None]:
    """One step of the native batch."""
    env = _batch(case, rows)
    return _stepping(env, itertools.cycle(draw(case.actions, rows, env.world.widths[1])))


def scalar(case: Case) -> Callable[[], None]:
    """One step of `gym.make`, with its usual wrappers."""
    env = gym.make(spec_of(case.env_id).id, scene=case.scene)
    width = env.unwrapped.world.widths[1]  # type: ignore[attr-defined]
    return _episodes(env, itertools.cycle(draw(case.actions, 64, width).reshape(-1, width)))


def cartpole() -> Callable[[], None]:
    """One step of Gymnasium's CartPole, likewise."""
    return _episodes(gym.make(CARTPOLE), itertools.cycle(np.random.default_rng(0).integers(2, size=1024).tolist()))


def sync(case: Case, rows: int) -> Callable[[], None]:
    """One step of a SyncVectorEnv of `gym.make`."""
    env = gym.vector.SyncVectorEnv([lambda: gym.make(spec_of(case.env_id).id, scene=case.scene)] * rows)
    return _stepping(env, itertools.cycle(draw(case.actions, rows, env.action_space.shape[1])))  # type: ignore[index]


@functools.cache
def _opponent(opponent: Any, arrays: Arrays, env_id: str, scene: str | None) -> tuple[Callable[..., Any], ...]:
    """`start` in NumPy, where it compiles nothing, and `step`, compiled once for all kinds of actions."""
    given = resolve(task_of(env_id), scene), limit_of(env_id)
    return opponent(NUMPY, *given).start, arrays.compiled(opponent(arrays, *given).step)


def on_arrays(case: Case, rows: int, arrays: Arrays) -> Callable[[], None]:
    """One step of the case's opponent."""
    start, step = _opponent(case.opponent, arrays, case.env_id, case.scene)
    begin = start(np.arange(rows, dtype=np.uint64))
    state = {name: arrays.xp.array(values) for name, values in begin.items()}
    actions = itertools.cycle(draw(case.actions, rows, _batch(case, 1).world.widths[1]))

    def work() -> None:
        nonlocal state
        state, *_ = step(state, next(actions))

    return work


def impacts_per_step(env: BatchEnv, actions: np.ndarray, count: int, seed: int = 0) -> float | None:
    """Impacts per control interval over `count` calls of `env.step` after a reset; None if the task has none.

    Episodes that end are taken from the infos, those that still run at the end from the environment.
    """
    env.reset(seed=seed)
    env.step(actions[0])
    if IMPACTS not in env.world.metrics(np.arange(env.num_envs)):
        return None
    env.reset(seed=seed)
    impacts = steps = 0.0

    def add(rows: np.ndarray, rates: np.ndarray) -> None:
        nonlocal impacts, steps
        lengths = env.world.states["steps"][rows]
        impacts, steps = impacts + float((rates * lengths).sum()), steps + float(lengths.sum())

    ended = np.zeros(env.num_envs, np.bool_)
    for k in range(count):
        infos = env.step(actions[k % len(actions)])[-1]
        ended = infos.get(f"_{IMPACTS}", np.zeros(env.num_envs, np.bool_))
        if ended.any():
            add(ended, infos[IMPACTS][ended])
    running = np.flatnonzero(~ended)
    add(running, env.world.metrics(running)[IMPACTS])
    return impacts / steps


def impacts_of(case: Case) -> float | None:
    """`impacts_per_step` of a case."""
    env = _batch(case, COUNTED_ROWS)
    return impacts_per_step(env, draw(case.actions, COUNTED_ROWS, env.world.widths[1]), COUNTED_STEPS)
