"""What a policy is, and the policies that know nothing of the system."""

from __future__ import annotations

from typing import Protocol

import numpy as np


class Policy(Protocol):
    """Maps observations (n, observation width) to actions (n, action width), both as the environment scales them."""

    def reset(self, n: int) -> None:
        """Forget everything; the next call has `n` rows at the start of their episodes."""

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        """Actions in [-1, 1] for a batch of observations."""
        ...


class Constant:
    """The same action always."""

    def __init__(self, action: np.ndarray) -> None:
        """`action`: shape (action width,), each in [-1, 1]."""
        self.action = np.asarray(action, np.float32)

    def reset(self, n: int) -> None:
        """Nothing to forget."""

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        """The constant action for every row."""
        return np.broadcast_to(self.action, (len(observations), len(self.action)))


class Random:
    """Uniform actions, from a seed."""

    def __init__(self, width: int, seed: int = 0) -> None:
        """`width`: number of actions; `seed`: of the sequence, which begins anew at each reset."""
        self.width, self.seed = width, seed
        self.reset(0)

    def reset(self, n: int) -> None:
        """Begin the sequence anew."""
        self._generator = np.random.default_rng(self.seed)

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        """Independent uniform actions in [-1, 1]."""
        return self._generator.uniform(-1.0, 1.0, (len(observations), self.width)).astype(np.float32)
