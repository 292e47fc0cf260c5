"""Compilation before the measurements, by as many processes as there are cores; what they compile is in the cache."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from multiprocessing import get_context
from typing import TypeVar

from tqdm import tqdm

T = TypeVar("T")


def side_by_side(function: Callable[[T], object], works: Sequence[T], progress: bool = False) -> None:
    """Call a module's function with each of the works, in processes of their own."""
    with (
        tqdm(total=len(works), desc="kernels", leave=False, disable=None if progress else True) as bar,
        ProcessPoolExecutor(os.cpu_count(), get_context("spawn")) as pool,
    ):
        waiting = {pool.submit(function, work) for work in works}
        while waiting:
            done, waiting = wait(waiting, timeout=1.0, return_when=FIRST_COMPLETED)
            for future in done:
                future.result()
            bar.update(len(done))
            bar.refresh()
