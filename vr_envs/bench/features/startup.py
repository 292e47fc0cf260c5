"""What a program waits for before its first step, and what it loads: each measured in a process of its own."""

from __future__ import annotations

import dataclasses
import json
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import vr_envs
from vr_envs.bench.timing import Spread

HEAVY = ("numba", "scipy", "pymunk", "matplotlib", "pygame", "torch", "vr_envs.render")
STAGES = ("gymnasium", "vr_envs", "numba", "make", "first step", "picture")

_PROGRAM = f"""
import json, sys, time
from importlib import import_module

found = []

def stage(name, work):
    wall, cpu, before = time.perf_counter(), time.process_time(), set(sys.modules)
    made = work()
    heavy = [m for m in {HEAVY} if m in sys.modules and m not in before]
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    found.append(dict(name=name, wall=wall, cpu=cpu, modules=len(set(sys.modules) - before), heavy=heavy))
    return made

def first_step():
    env.reset(seed=0)
    return env.step(env.action_space.sample())

env_id, rows, looks = sys.argv[1], int(sys.argv[2]), sys.argv[3] == "look"
gym = stage("gymnasium", lambda: import_module("gymnasium"))
stage("vr_envs", lambda: import_module("vr_envs"))
stage("numba", lambda: import_module("numba"))
mode = "rgb_array" if looks else None
env = stage("make", lambda: gym.make_vec(env_id, rows) if rows else gym.make(env_id, render_mode=mode))
stage("first step", first_step)
if looks:
    stage("picture", lambda: env.render())
print(json.dumps(found))
"""


@dataclasses.dataclass(frozen=True)
class Stage:
    """Seconds, by the clock and of CPU time, and the modules that a stage of a program's start has loaded."""

    name: str
    wall: float
    cpu: float
    modules: int
    heavy: list[str]


@dataclasses.dataclass(frozen=True)
class Start:
    """The stages of one start, and what it said on stderr."""

    stages: dict[str, Stage]
    said: str

    def cpu(self, *names: str) -> float:
        """CPU seconds of some stages together."""
        return sum(self.stages[name].cpu for name in names)


def start(env_id: str, rows: int = 0, look: bool = False, environment: Mapping[str, str] | None = None) -> Start:
    """A new process that imports, makes an environment (or a batch of `rows`), resets, steps once and perhaps looks.

    Raises:
        RuntimeError: the process has failed; it says how.
    """
    path = [str(Path(vr_envs.__file__).parent.parent), os.environ.get("PYTHONPATH", "")]
    variables = {**os.environ, "PYTHONPATH": os.pathsep.join(part for part in path if part), **(environment or {})}
    done = subprocess.run(
        [sys.executable, "-c", _PROGRAM, env_id, str(rows), "look" if look else "-"],
        capture_output=True, text=True, env=variables,
    )  # fmt: skip
    if done.returncode != 0:
        raise RuntimeError(f"{env_id} does not start in a new process: {done.stderr.strip()[-500:]}")
    stages: list[dict[str, Any]] = json.loads(done.stdout.splitlines()[-1])
    return Start({stage["name"]: Stage(**stage) for stage in stages}, done.stderr)


@dataclasses.dataclass(frozen=True)
class Warm:
    """CPU seconds of a start whose kernels are in the cache: gymnasium, vr_envs, numba, and the kernels themselves.

    `kernels` is from `gym.make` to the end of the first step.
    """

    env_id: str
    rows: int
    gymnasium: Spread
    vr_envs: Spread
    numba: Spread
    kernels: Spread


def warm_start(env_id: str, rows: int, repeats: int) -> Warm:
    """The start of an id, `repeats` times; a first one, which may compile, is not counted."""
    start(env_id, rows)
    starts = [start(env_id, rows) for _ in range(repeats)]
    parts = (("gymnasium",), ("vr_envs",), ("numba",), ("make", "first step"))
    return Warm(env_id, rows, *(Spread.of([s.cpu(*names) for s in starts]) for names in parts))


@dataclasses.dataclass(frozen=True)
class Cold:
    """Seconds from `gym.make` to the end of the first step with no kernel in the cache, and whether a word was said."""

    env_id: str
    cpu: float
    wall: float
    said: bool


def cold_start(env_id: str) -> Cold:
    """The start of an id with an empty cache."""
    with TemporaryDirectory() as folder:
        first = start(env_id, environment={"NUMBA_CACHE_DIR": folder})
    names = ("make", "first step")
    wall = sum(first.stages[name].wall for name in names)
    return Cold(env_id, first.cpu(*names), wall, "compiling" in first.said)
