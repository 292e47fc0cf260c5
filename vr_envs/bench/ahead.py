"""Works in as many processes as there are cores: compilation before the measurements, and what takes long."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from multiprocessing import active_children, get_context
from typing import TypeVar

from tqdm import tqdm

T = TypeVar("T")
R = TypeVar("R")
_MOST = 61  # processes that Windows can wait for


def cores() -> int:
    """The cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _end_at_an_interrupt() -> None:
    """In a process of the pool: the one that waits for it tells of an interrupt."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def side_by_side(
    function: Callable[[T], R], works: Sequence[T], progress: bool = False, what: str = "kernels"
) -> list[R]:
    """What a module's function returns for each of the works, called in processes of their own.

    A program that calls this needs the usual `if __name__ == "__main__":`.

    Raises:
        RuntimeError: a work has failed, or its process has died; it says which, and the others are given up.
    """
    if not works:
        return []
    with tqdm(total=len(works), desc=what, leave=False, disable=None if progress else True) as bar:
        pool = ProcessPoolExecutor(min(len(works), cores(), _MOST), get_context("spawn"), _end_at_an_interrupt)
        futures = {pool.submit(function, work): work for work in works}
        waiting = set(futures)
        try:
            while waiting:
                done, waiting = wait(waiting, timeout=1.0, return_when=FIRST_COMPLETED)
                for future in done:
                    if (error := future.exception()) is not None:
                        raise RuntimeError(f"{futures[future]}: {type(error).__name__}: {error}") from error
                bar.update(len(done))
                bar.refresh()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for child in active_children():
                child.terminate()
            raise
        pool.shutdown()
        return [future.result() for future in futures]
