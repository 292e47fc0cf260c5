"""The one decorator for compiled kernels.

Numba's own disk cache notices an edit of the file a function stands in, but not an edit of a function
that it calls from another file, and it cannot recognise a closure again in the next process. Here the
cache key is the text of every kernel source in the package, so a stale kernel is never loaded.
"""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path
from typing import Any

import numba
from numba.core.caching import FunctionCache

PACKAGE = Path(__file__).resolve().parent.parent
KERNEL_FOLDERS = ("models", "envs")


@cache
def source_stamp() -> str:
    """Hash of the text of every file that may contain a kernel."""
    digest = hashlib.sha256()
    for folder in KERNEL_FOLDERS:
        for path in sorted((PACKAGE / folder).glob("*.py")):
            digest.update(path.name.encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()


class _KernelCache(FunctionCache):
    def _index_key(self, sig: Any, codegen: Any) -> tuple[Any, ...]:
        cells = self._py_func.__closure__ or ()
        inner = tuple(f"{c.cell_contents.py_func.__module__}.{c.cell_contents.py_func.__qualname__}" for c in cells)
        return (sig, codegen.magic_tuple(), source_stamp(), inner)


def kernel(function: Any) -> Any:
    """Compile `function` in nopython mode: strict IEEE arithmetic, no GIL, one thread, cached on disk.

    The variables that a kernel closes over, if any, must themselves be kernels.
    """
    dispatcher = numba.njit(nogil=True, error_model="numpy")(function)
    dispatcher._cache = _KernelCache(function)
    return dispatcher
