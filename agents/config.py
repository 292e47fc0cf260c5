"""A training configuration: YAML data, every key and value checked before anything starts."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from vr_envs.envs.scene import unknown_key
from vr_envs.models.record import checked_value, quantity


@dataclasses.dataclass(frozen=True)
class Config:
    """Everything that decides a training run. The hyper-parameters are those of PPO (Schulman et al. 2017)."""

    env: str
    """Gymnasium id with its package, as in vr_envs:vr_envs/BallOnBar-v0."""
    scene: str | dict[str, Any] | None = None
    """Preset or overrides; None is the task's default."""
    algorithm: str = quantity("ppo", "", "learning algorithm", choices=("ppo",))
    seed: int = quantity(0, "", "of the weights, the exploration and the episodes", low=0, high=2**31)
    timesteps: int = quantity(1_000_000, "steps", "control intervals, all rows together", low=1)
    num_envs: int = quantity(512, "rows", "environments in the batch", low=1, high=2**20)
    time_limit_s: float | None = quantity(None, "s", "training stops after this wall time, annealed", low=1)
    initial_action: str | tuple[float, ...] | None = None
    """Where the policy's mean starts: one number per action, a policy of the ladder that is constant, or None."""
    hidden: tuple[int, ...] = (64, 64)
    """Units of each hidden layer, of the policy and of the value function."""
    activation: str = quantity("tanh", "", "of the hidden layers", choices=("tanh", "relu", "elu"))
    n_steps: int = quantity(64, "", "control intervals per row between updates", low=1, high=2**20)
    batch_size: int = quantity(4096, "", "samples per gradient step; divides num_envs * n_steps", low=2)
    n_epochs: int = quantity(6, "", "passes over the samples per update", low=1, high=1000)
    gamma: float = quantity(0.98, "", "discount per control interval", low=0, high=0.99999)
    gae_lambda: float = quantity(0.95, "", "of generalised advantage estimation", low=0, high=1)
    learning_rate: float = quantity(1e-3, "", "of Adam, annealed linearly to 0", low=1e-9, high=1)
    ent_coef: float = quantity(0.0, "", "weight of the entropy bonus", low=0, high=1)
    clip_range: float = quantity(0.2, "", "of the probability ratio", low=1e-6, high=10)
    target_kl: float | None = quantity(None, "", "an update ends early beyond 1.5 times this", low=1e-9, high=10)
    log_std_init: float = quantity(-0.5, "", "log of the exploration's standard deviation", low=-10, high=2)

    def as_dict(self) -> dict[str, Any]:
        """Plain values; `from_mapping(config.as_dict())` gives the same configuration."""
        return {k: list(v) if isinstance(v, tuple) else v for k, v in dataclasses.asdict(self).items()}


class _Loader(yaml.SafeLoader):
    """YAML 1.1 without its two traps: here 1e-3 is a number, and a key given twice is an error."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if key in seen:
                raise ValueError(f"key {key!r} is given twice (line {key_node.start_mark.line + 1})")
            seen.add(key)
        return super().construct_mapping(node, deep)


_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"^[-+]?[0-9][0-9_]*(\.[0-9_]*)?[eE][-+]?[0-9]+$"), list("-+0123456789")
)


def parse(text: str, where: str) -> Any:
    """The data of a YAML (or JSON) text; a ValueError of one line that begins with `where` if it has none."""
    try:
        return yaml.load(text, _Loader)  # a SafeLoader: plain data only
    except (yaml.YAMLError, ValueError) as error:
        raise ValueError(f"{where}: {' '.join(str(error).split())}") from error


def _numbers(given: Any, label: str, kind: type, low: float, high: float) -> tuple[Any, ...]:
    ok = isinstance(given, list | tuple) and all(
        isinstance(x, kind | int) and not isinstance(x, bool) and low <= x <= high for x in given
    )
    if not ok:
        raise ValueError(f"{label} = {given!r} is not allowed; give a list of {kind.__name__}s in [{low:g}, {high:g}]")
    return tuple(kind(x) for x in given)


def _text(given: Any, label: str) -> str:
    if not isinstance(given, str) or not given:
        raise ValueError(f"{label} = {given!r} is not allowed; give a text")
    return given


def _value(field: dataclasses.Field[Any], given: Any) -> Any:
    name = field.name
    if given is None and field.default is None:
        return None
    if field.metadata:
        return checked_value(field, given, name)
    if name == "hidden":
        return _numbers(given, name, int, 1, 4096)
    if name == "initial_action" and not isinstance(given, str):
        return _numbers(given, name, float, -1, 1)
    if name == "scene" and isinstance(given, Mapping):
        return dict(given)
    return _text(given, name)


def from_mapping(values: Any, where: str = "config") -> Config:
    """A checked configuration.

    Raises:
        ValueError: unknown or missing key, wrong type, value out of range; it begins with `where`.
    """
    if not isinstance(values, Mapping):
        raise ValueError(f"{where}: give keys and values, not {type(values).__name__}")
    fields = {f.name: f for f in dataclasses.fields(Config)}
    for key in values:
        if key not in fields:
            raise unknown_key(key, list(fields), where)
    if "env" not in values:
        raise ValueError(f"{where}: the key 'env' is missing; give an id such as vr_envs:vr_envs/BallOnBar-v0")
    try:
        config = Config(**{key: _value(fields[key], given) for key, given in values.items()})
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None
    if config.num_envs * config.n_steps % config.batch_size:
        raise ValueError(
            f"{where}: batch_size = {config.batch_size} does not divide num_envs * n_steps = "
            f"{config.num_envs} * {config.n_steps}; the last minibatch would be a fragment"
        )
    return config


def load(path: Path, overrides: Mapping[str, Any] | None = None) -> Config:
    """The configuration in a YAML file, with `overrides` laid over it.

    Raises:
        ValueError: the file is missing or is not YAML, or see `from_mapping`.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise ValueError(f"{path}: cannot be read ({error.strerror})") from error
    values = parse(text, str(path))
    if isinstance(values, Mapping):
        values = {**values, **(overrides or {})}
    return from_mapping(values, str(path))


def dump(config: Config) -> str:
    """The configuration as YAML; `parse` and `from_mapping` give the same configuration back."""
    return yaml.safe_dump(config.as_dict(), sort_keys=False)
