"""From an environment id, as a person types it, to its registration and its task."""

from __future__ import annotations

import difflib

import gymnasium as gym
from gymnasium.envs.registration import EnvSpec, load_env_creator

from vr_envs.envs.task import Task

NAMESPACE = "vr_envs"


def ids() -> list[str]:
    """Every registered id of this package, in order of registration."""
    return [name for name, spec in gym.registry.items() if spec.namespace == NAMESPACE]


def spec_of(env_id: str) -> EnvSpec:
    """The registration of `env_id`; module prefix, namespace and version may be left out (the newest is taken).

    Raises:
        ValueError: unknown id; it lists the ids.
    """
    name = env_id.rpartition(":")[2]
    if name in gym.registry:
        return gym.registry[name]
    own = [gym.registry[i] for i in ids()]
    short = name.removeprefix(f"{NAMESPACE}/")
    matches = [s for s in own if short in (s.name, f"{s.name}-v{s.version}")]
    if matches:
        return max(matches, key=lambda s: s.version or 0)
    close = difflib.get_close_matches(short, [s.name for s in own], n=1)
    hint = f"; did you mean {close[0]}?" if close else "."
    raise ValueError(f"there is no environment {env_id!r}{hint} Ids: {', '.join(ids())}")


def task_of(env_id: str) -> Task:
    """The task behind an environment id.

    Raises:
        ValueError: unknown id, or one that is not of this suite.
    """
    spec = spec_of(env_id)
    creator = load_env_creator(spec.entry_point) if isinstance(spec.entry_point, str) else spec.entry_point
    task = getattr(creator, "task", None)
    if not isinstance(task, Task):
        raise ValueError(f"{env_id!r} is not an environment of this suite. Ids: {', '.join(ids())}")
    return task


def limit_of(env_id: str) -> int:
    """Number of control intervals after which an episode of `env_id` is cut.

    Raises:
        ValueError: unknown id, or an id without a time limit.
    """
    steps = spec_of(env_id).max_episode_steps
    if steps is None:
        raise ValueError(f"{env_id!r} is registered without max_episode_steps; a score per possible step needs one")
    return steps
