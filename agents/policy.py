"""A trained policy as a file without code in it: weights, and the architecture and spaces they belong to."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import torch
from gymnasium.spaces import Box
from safetensors import SafetensorError, safe_open
from safetensors.torch import save
from stable_baselines3.common.policies import ActorCriticPolicy

from vr_envs.evaluation.files import write_bytes

FORMAT = "vr_envs policy 1"
ACTIVATIONS: dict[str, type[torch.nn.Module]] = {
    "tanh": torch.nn.Tanh,
    "relu": torch.nn.ReLU,
    "elu": torch.nn.ELU,
}


def policy_kwargs(hidden: tuple[int, ...], activation: str) -> dict[str, Any]:
    """Arguments of Stable-Baselines3's ActorCriticPolicy for the architecture."""
    return {"net_arch": list(hidden), "activation_fn": ACTIVATIONS[activation]}


def _space(box: Box) -> dict[str, list[float]]:
    return {"low": box.low.tolist(), "high": box.high.tolist()}


def _box(space: dict[str, list[float]]) -> Box:
    return Box(np.array(space["low"], np.float32), np.array(space["high"], np.float32), dtype=np.float32)


def save_policy(network: ActorCriticPolicy, path: Path, facts: dict[str, Any]) -> None:
    """Write the weights, the spaces and `facts` to a safetensors file.

    Args:
        network: the trained network.
        path: of the file.
        facts: JSON-able; "hidden" and "activation" give the architecture, "env" and "scene" where it was trained.
    """
    assert isinstance(network.observation_space, Box) and isinstance(network.action_space, Box)
    spaces = {"observation": _space(network.observation_space), "action": _space(network.action_space)}
    weights = {name: tensor.detach().contiguous() for name, tensor in network.state_dict().items()}
    write_bytes(path, save(weights, {"format": FORMAT, "facts": json.dumps({**facts, "spaces": spaces})}))


def _network(spaces: dict[str, Box], facts: dict[str, Any]) -> ActorCriticPolicy:
    kwargs = policy_kwargs(tuple(facts["hidden"]), facts["activation"])
    return ActorCriticPolicy(spaces["observation"], spaces["action"], lambda _: 0.0, ortho_init=False, **kwargs)


def _brief(error: Exception) -> str:
    return f"{type(error).__name__}: {' '.join(str(error).split())[:200]}"


class TrainedPolicy:
    """A saved network as a policy: deterministic actions, clipped to [-1, 1], for a batch of observations."""

    def __init__(self, path: str | Path, observation_space: Box | None = None, action_space: Box | None = None) -> None:
        """Load a file that `save_policy` wrote.

        Args:
            path: of the file.
            observation_space: of the environment it is to act in; None skips the check.
            action_space: likewise.

        Raises:
            ValueError: the file is missing, no such file or damaged, or its spaces are not those given.
        """
        try:
            with safe_open(path, "pt") as file:
                header = file.metadata() or {}
                weights = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
        except (OSError, SafetensorError) as error:
            raise ValueError(f"{path}: cannot be read as a policy ({error})") from error
        if header.get("format") != FORMAT:
            raise ValueError(f"{path}: format {header.get('format')!r}; expected {FORMAT!r}")
        try:
            self.facts: dict[str, Any] = json.loads(header["facts"])
            spaces = {name: _box(self.facts["spaces"][name]) for name in ("observation", "action")}
            self.network = _network(spaces, self.facts)
            self.network.load_state_dict(weights)
        except (KeyError, TypeError, ValueError, RuntimeError) as error:
            raise ValueError(f"{path}: damaged, train the policy again ({_brief(error)})") from error
        for name, given in (("observation", observation_space), ("action", action_space)):
            if given is not None and given != spaces[name]:
                raise ValueError(f"{path}: trained for the {name} space {spaces[name]}, the environment has {given}")
        self.network.set_training_mode(False)

    def reset(self, n: int) -> None:
        """Nothing to forget."""

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        """Actions (n, action width) in [-1, 1] for observations (n, observation width)."""
        with torch.no_grad():
            batch = torch.as_tensor(np.asarray(observations, np.float32))
            actions = self.network._predict(batch, deterministic=True).numpy()
        return np.clip(actions, -1.0, 1.0)
