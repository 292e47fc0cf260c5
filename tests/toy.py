"""A two-number system with a known solution, registered as `toy/FirstOrder-v0`, to test what serves every task.

dx/dt = (push * action - x) / lag, exactly over one interval. The score is best where x = 0; an episode ends where
|x| reaches `bound`. The documents' law here is `proportional`, the stronger one `cancel`.
"""

from __future__ import annotations

import dataclasses
import math
import sys
import types
from typing import ClassVar

import gymnasium as gym
import numpy as np

from vr_envs.envs.batch import BatchEnv
from vr_envs.envs.scalar import ScalarEnv
from vr_envs.envs.scene import Scene
from vr_envs.envs.task import Channel, Task
from vr_envs.models.jit import kernel
from vr_envs.models.noise import uniform
from vr_envs.models.record import quantity

LIMIT = 20
DT = 0.1
ID = "toy/FirstOrder-v0"


@dataclasses.dataclass(frozen=True)
class Params:
    lag: float = quantity(1.0, "s", "time constant", low=0.01, high=100.0)
    push: float = quantity(2.0, "", "steady state for action 1", low=0.0, high=10.0)
    start: float = quantity(1.0, "", "largest |x| at the start", low=0.0, high=10.0)
    bound: float = quantity(100.0, "", "|x| at which the episode ends", low=0.0, high=1e9)


@dataclasses.dataclass(frozen=True)
class Bias:
    size: float = quantity(0.5, "", "constant action added by the world", low=-1.0, high=1.0)
    sign: float = quantity(1.0, "", "its sign", low=-1.0, high=1.0)


@dataclasses.dataclass(frozen=True)
class State:
    key: int = quantity(0, "", "episode key", kind="key")
    steps: int = quantity(0, "", "control intervals done")
    x: float = quantity(0.0, "", "position")
    squares: float = quantity(0.0, "", "sum of x^2")


@kernel
def start(state, params, bias):
    state.x = params.start * (2.0 * uniform(state.key, 0) - 1.0)
    state.squares = 0.0


@kernel
def advance(state, action, params, bias):
    target = params.push * action[0]
    if bias is not None:
        target += params.push * bias.size * bias.sign
    state.x = target + (state.x - target) * math.exp(-DT / params.lag)
    state.squares += state.x * state.x


@kernel
def outcome(state, action, params, bias):
    return 1.0 / (1.0 + state.x * state.x), abs(state.x) >= params.bound


@kernel
def observe(state, row, params, bias):
    row[0] = min(1.0, max(-1.0, state.x / 10.0))


def metrics(states, scene):
    rms = np.sqrt(states["squares"] / states["steps"])
    return {"is_success": rms < 0.5, "rms": rms, "final": states["x"].copy()}


TASK = Task(
    name="toy",
    params=Params,
    options={"bias": Bias},
    state=State,
    scenes={"plain": {}, "biased": {"bias": True}, "narrow": {"bound": 0.5}},
    default_scene="plain",
    levels={"nominal": {}, "light": {"start": 0.1, "bias": {"size": 0.1}}, "severe": {"bias": {"size": 0.9}}},
    start=start,
    advance=advance,
    outcome=outcome,
    observe=observe,
    observation_channels=lambda scene: (Channel("x", "", "position / 10"),),
    action_channels=lambda scene: (Channel("push", "", "share of the full push", -1.0, 1.0),),
    metrics=metrics,
    dt=lambda scene: DT,
)


class ToyEnv(ScalarEnv):
    task = TASK


class ToyBatchEnv(BatchEnv):
    task = TASK


class Proportional:
    TUNABLE: ClassVar = {"gain": (0.0, 8.0, 1.0), "offset": (-1.0, 1.0, 0.0)}

    def __init__(self, scene: Scene, gain: float = 1.0, offset: float = 0.0) -> None:
        self.gain, self.offset = gain, offset

    def reset(self, n: int) -> None:
        self.rows = n

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        return np.clip(self.offset - self.gain * 10.0 * observations / 2.0, -1.0, 1.0)


class Cancel:
    TUNABLE: ClassVar = {}

    def __init__(self, scene: Scene) -> None:
        self.decay, self.push = math.exp(-DT / scene.params.lag), scene.params.push

    def reset(self, n: int) -> None:
        self.rows = n

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        x = 10.0 * observations.astype(float)
        return np.clip(-x * self.decay / (1.0 - self.decay) / self.push, -1.0, 1.0)


def install() -> None:
    """Register the environment, and its laws where the ladder looks for them."""
    if ID not in gym.registry:
        gym.register(
            ID, entry_point="tests.toy:ToyEnv", vector_entry_point="tests.toy:ToyBatchEnv", max_episode_steps=LIMIT
        )
    laws = types.ModuleType("vr_envs.controllers.toy")
    vars(laws).update(BASELINE="proportional", LAWS={"proportional": Proportional, "cancel": Cancel})
    sys.modules["vr_envs.controllers.toy"] = laws


def toy_in(monkeypatch, folder) -> str:
    """Install the toy with its tuned gains in `folder`; its id."""
    install()
    monkeypatch.setattr("vr_envs.controllers.ladder.TUNED", folder)
    return ID
