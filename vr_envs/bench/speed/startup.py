"""How long a new process waits for its first step: with no kernel compiled yet, and with all of them in the cache."""

from __future__ import annotations

import dataclasses
import json
import os
import subprocess
import sys
import tempfile

from tqdm import tqdm

FIRST_COMPILE, CACHED = 15.0, 1.0  # s: goals
_CHILD = """
import json, sys, time
import gymnasium
import numba, numpy, vr_envs.envs.registry
begin = time.process_time()
env = gymnasium.make(sys.argv[1])
env.reset(seed=0)
env.step(env.action_space.sample())
print(json.dumps([begin, time.process_time() - begin]))
"""


@dataclasses.dataclass(frozen=True)
class Startup:
    """CPU seconds of a new process: for imports, and for making, resetting and stepping one environment."""

    env_id: str
    imports: float
    compiling: float
    cached: float


def startup(env_id: str) -> Startup:
    """Of the default scene of `env_id`, in two processes with a cache of their own, empty for the first."""
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "NUMBA_CACHE_DIR": folder}
        command = [sys.executable, "-c", "import vr_envs\n" + _CHILD, env_id]
        runs = [
            json.loads(subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout)
            for _ in range(2)
        ]
    return Startup(env_id, runs[1][0], runs[0][1], runs[1][1])


def startups_of(env_ids: list[str], progress: bool = False) -> list[Startup]:
    """`startup` of each id."""
    return [startup(env_id) for env_id in tqdm(env_ids, disable=None if progress else True, desc="first steps")]
