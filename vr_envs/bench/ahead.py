"""Works in as many processes as there are cores: compilation before the measurements, and what takes long."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from multiprocessing import get_context
from typing import TypeVar

from tqdm import tqdm

T = TypeVar("T")
R = TypeVar("R")


def side_by_side(
    function: Callable[[T], R], works: Sequence[T], progress: bool = False, what: str = "kernels"
) -> list[R]:
    """What a module's function returns for each of the works, called in processes of their own."""
    with (
        tqdm(total=len(works), desc=what, leave=False, disable=None if progress else True) as bar,
        ProcessPoolExecutor(os.cpu_count(), get_context("spawn")) as pool,
    ):
        futures = [pool.submit(function, work) for work in works]
        waiting = set(futures)
        while waiting:
            done, waiting = wait(waiting, timeout=1.0, return_when=FIRST_COMPLETED)
            for future in done:
                future.result()
            bar.update(len(done))
            bar.refresh()
        return [future.result() for future in futures]
