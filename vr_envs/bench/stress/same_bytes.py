"""The same bytes: on repeat, in batches of any size, in any split of a batch, from restored states, in other threads.

And in other processes. What counts are the records and the observations, rewards and ends of every row and step.
"""

from __future__ import annotations

import hashlib
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier
from typing import Any, NamedTuple

import numpy as np

from vr_envs.bench.stress.trial import Failure, Outcome
from vr_envs.envs.registry import task_of
from vr_envs.envs.rows import LOCKSTEP_FROM
from vr_envs.envs.task import Task
from vr_envs.envs.world import World

SCENES = (
    ("BallOnBar", "lens"), ("Autopilot", "lecture"), ("Autopilot", "airliner"), ("TerrainRide", "road"),
    ("TerrainRide", "quarter-car"),
)  # fmt: skip
"""Every system, where most is compiled in, and where records are moved side by side."""
ROWS = LOCKSTEP_FROM + 9  # a batch that moves records side by side, and one left over
STEPS = 24
_WORKERS = 3


class Flight(NamedTuple):
    """What a world returned, over (steps, rows), and its records at the end."""

    observations: np.ndarray
    rewards: np.ndarray
    ended: np.ndarray
    records: np.ndarray


def _start(task: Task, scene: Any, keys: np.ndarray) -> World:
    world = World(task, scene, len(keys))
    world.reset(np.arange(len(keys)), keys, np.empty((len(keys), world.widths[0]), np.float32))
    return world


def _go_on(world: World, actions: np.ndarray, parts: np.ndarray | None = None) -> Flight:
    """Step through `actions` (steps, rows, width): everything that is returned, and the records at the end.

    `parts` numbers the part of each row: the parts are stepped one after the other.
    """
    rows = actions.shape[1]
    parts = np.zeros(rows, np.int64) if parts is None else parts
    seen: list[tuple[np.ndarray, ...]] = []
    for acts in actions:
        together = None
        for part in np.unique(parts):
            live = parts == part
            found = world.step(acts, live, 1 << 62)
            together = found if together is None else together
            for whole, new in zip(together, found, strict=True):
                whole[live] = new[live]
        assert together is not None
        seen.append(together[:3])
    return Flight._make([*(np.array([step[k] for step in seen]) for k in range(3)), world.copy()])


def same(one: Flight, other: Flight, rows: Any) -> bool:
    """Whether two flights are the same bytes, the other one made of these rows of the first."""
    begin = all(a[:, rows].tobytes() == b.tobytes() for a, b in zip(one[:3], other[:3], strict=True))
    return begin and one.records[rows].tobytes() == other.records.tobytes()


def _case(task: Task, scene: str, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Episode keys and actions; every second case is abrupt."""
    draw = np.random.default_rng(seed)
    width = World(task, scene, 1).widths[1]
    actions = draw.uniform(-1.0, 1.0, (STEPS, ROWS, width))
    return draw.integers(0, 2**63, ROWS).astype(np.uint64), np.sign(actions) if seed % 2 else actions


def _again(task: Task, scene: str, keys: np.ndarray, actions: np.ndarray, one: Flight, draw: Any) -> bool:
    return same(one, _go_on(_start(task, scene, keys), actions), slice(None))


def _sizes(task: Task, scene: str, keys: np.ndarray, actions: np.ndarray, one: Flight, draw: Any) -> bool:
    subsets = [draw.choice(ROWS, size, replace=False) for size in (1, 3, LOCKSTEP_FROM - 1, LOCKSTEP_FROM)]
    return all(same(one, _go_on(_start(task, scene, keys[rows]), actions[:, rows]), rows) for rows in subsets)


def _splits(task: Task, scene: str, keys: np.ndarray, actions: np.ndarray, one: Flight, draw: Any) -> bool:
    return same(one, _go_on(_start(task, scene, keys), actions, draw.integers(0, 4, ROWS)), slice(None))


def _restored(task: Task, scene: str, keys: np.ndarray, actions: np.ndarray, one: Flight, draw: Any) -> bool:
    """Half of the way, then on in another world, its rows in another order."""
    half, world, order = STEPS // 2, _start(task, scene, keys), draw.permutation(ROWS)
    _go_on(world, actions[:half])
    other = _start(task, scene, keys[::-1].copy())
    other.load(world.copy()[order], np.arange(ROWS))
    rest = Flight._make([*(a[half:] for a in one[:3]), one.records])
    return same(rest, _go_on(other, actions[half:, order]), order)


def _threads(task: Task, scene: str, keys: np.ndarray, actions: np.ndarray, one: Flight, draw: Any) -> bool:
    parts = np.array_split(draw.permutation(ROWS), _WORKERS)
    together = Barrier(_WORKERS)  # none is done before another begins

    def fly(world: World, rows: np.ndarray) -> Flight:
        together.wait()
        return _go_on(world, actions[:, rows])

    with ThreadPoolExecutor(_WORKERS) as pool:
        flights = list(pool.map(fly, [_start(task, scene, keys[rows]) for rows in parts], parts))
        return all(same(one, flight, rows) for flight, rows in zip(flights, parts, strict=True))


WAYS: dict[str, Callable[..., bool]] = {
    "once more": _again,
    "in batches of other sizes": _sizes,
    "in parts of the batch": _splits,
    "from restored states": _restored,
    "in several threads": _threads,
}


def same_everywhere(first: int, number: int, trace: np.ndarray) -> Outcome:
    """One scene each, flown in all `WAYS`."""
    outcome = Outcome()
    for seed in range(first, first + number):
        env_id, scene = SCENES[seed % len(SCENES)]
        task, draw = task_of(env_id), np.random.default_rng([seed, 1])
        keys, actions = _case(task, scene, seed)
        one = _go_on(_start(task, scene, keys), actions)
        for way, again in WAYS.items():
            outcome.count += actions.shape[0] * actions.shape[1]
            if not again(task, scene, keys, actions, one, draw):
                outcome.failures.append(Failure(seed, f"{env_id}, {scene}: other bytes {way}"))
    return outcome


def digest(seed: int) -> str:
    """Hash of a flight of every scene."""
    found = hashlib.sha256()
    for env_id, scene in SCENES:
        task = task_of(env_id)
        keys, actions = _case(task, scene, seed)
        for array in _go_on(_start(task, scene, keys), actions):
            found.update(array.tobytes())
    return found.hexdigest()


def processes(first: int, number: int, trace: np.ndarray) -> Outcome:
    """Every scene in this process and in a fresh one."""
    outcome = Outcome()
    for seed in range(first, first + number):
        outcome.count += len(SCENES) * STEPS * ROWS
        program = f"from {digest.__module__} import digest; print(digest({seed}))"
        other = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
        if other.returncode:
            outcome.failures.append(Failure(seed, f"another process ended with {other.stderr[-200:]}"))
        elif other.stdout.split()[-1] != digest(seed):
            outcome.failures.append(Failure(seed, "other bytes in another process"))
    return outcome
