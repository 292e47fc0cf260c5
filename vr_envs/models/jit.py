"""The one decorator for compiled kernels.

Numba's own disk cache notices an edit of the file a function stands in, but not an edit of a function
that it calls from another file, and it cannot recognise a closure again in the next process. Here
the cache is valid for one text of all kernel sources in the package and of the files beside the kernel's own, so a
stale kernel is never loaded.
"""

from __future__ import annotations

import contextlib
import glob
import hashlib
import time
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numba
import numba.extending
import numpy as np
from numba import types
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.imputils import impl_ret_borrowed

PACKAGE = Path(__file__).resolve().parent.parent
KERNEL_FOLDERS = ("models", "envs")
_OLD = 86400.0  # s, the age of kernels that no other process is about to load


@cache
def source_stamp() -> str:
    """Hash of the text of every file that may contain a kernel."""
    return "".join(_folder_stamp(PACKAGE / folder) for folder in KERNEL_FOLDERS)


@cache
def _folder_stamp(folder: Path) -> str:
    """Hash of the text of every Python file of a folder."""
    digest = hashlib.sha256()
    for path in sorted(folder.glob("*.py")):
        digest.update(path.name.encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()


@cache
def _sources_changed() -> float:
    """When a file that may contain a kernel has changed last (s, of the system's clock)."""
    paths = (path for folder in KERNEL_FOLDERS for path in (PACKAGE / folder).glob("*.py"))
    return max(path.stat().st_mtime for path in paths)


@cache
def _file_stamp(path: str) -> str:
    """Hash of a file's text; of nothing where there is no such file."""
    return hashlib.sha256(Path(path).read_bytes() if Path(path).exists() else b"").hexdigest()


def _closed_over(function: Any) -> tuple[str, ...]:
    """The kernels that a function closes over, and those that they close over: names, and stamps of their files."""
    found: tuple[str, ...] = ()
    for cell in function.__closure__ or ():
        inner = cell.cell_contents.py_func
        name = f"{inner.__module__}.{inner.__qualname__} {_file_stamp(inner.__code__.co_filename)}"
        found += (name, *_closed_over(inner))
    return found


class _CacheFile(IndexDataCacheFile):
    def __init__(self, cache_path: str, filename_base: str, source_stamp: str) -> None:
        super().__init__(cache_path, filename_base, source_stamp)
        # an index of another version is not unpickled, which fails where it names a type that is gone
        self._version = f"{self._version} {source_stamp}"

    def save(self, key: Any, data: Any) -> None:
        """Save under a name that belongs to this key and source alone: concurrent processes cannot mix kernels."""
        if not self._load_index():
            self._remove_old()
        number = int(hashlib.sha256(repr((self._source_stamp, key)).encode()).hexdigest()[:12], 16)
        name = self._data_name(number)
        self._save_data(name, data)
        # read again: another process may have added to it
        self._save_index({**self._load_index(), key: name})

    def _remove_old(self) -> None:
        """Remove this module's kernels of earlier sources, unless another process may be about to load them."""
        before = min(_sources_changed(), time.time() - _OLD)
        module = glob.escape(self._index_name.partition(".")[0])
        for path in Path(self._cache_path).glob(f"{module}.*.nb[ci]"):
            with contextlib.suppress(OSError):  # another process was quicker
                if path.stat().st_mtime < before:
                    path.unlink()


class _KernelCache(FunctionCache):
    def __init__(self, function: Any) -> None:
        super().__init__(function)
        folder = Path(function.__code__.co_filename).parent  # a kernel may stand outside the package
        stamp = source_stamp(), _folder_stamp(folder)
        self._cache_file = _CacheFile(
            self._cache_path, self._impl.filename_base, hashlib.sha256(repr(stamp).encode()).hexdigest()
        )

    def _index_key(self, sig: Any, codegen: Any) -> tuple[Any, ...]:
        return (sig, codegen.magic_tuple(), _closed_over(self._py_func))


def kernel(function: Any) -> Any:
    """Compile `function` in nopython mode: strict IEEE arithmetic, no GIL, one thread, cached on disk.

    The variables that a kernel closes over, if any, must themselves be kernels.
    """
    dispatcher: Any = numba.njit(nogil=True, error_model="numpy")(function)
    try:
        dispatcher._cache = _KernelCache(function)
    except RuntimeError:  # no folder can be written: neither the package's nor the user's cache
        warnings.warn("vr_envs: no writable folder for compiled kernels; set NUMBA_CACHE_DIR to one", stacklevel=2)
    return dispatcher


def intrinsic(function: Any) -> Any:
    """Numba's decorator of that name; callers do not give the typing context, and are not told to."""
    return numba.extending.intrinsic(function)


class _Cell(NamedTuple):
    """A record as an array of one: what a generator keeps is then its address, not the record number by number."""

    array: Any


def _in_cells(value: Any) -> Any:
    """A copy of a tuple in which records are in cells, at any depth; all else is as it was."""
    if isinstance(value, np.void):
        return _Cell(np.array([value]))
    return tuple(_in_cells(part) for part in value) if isinstance(value, tuple) else value


def _opened_type(kind: Any) -> Any:
    if getattr(kind, "instance_class", None) is _Cell:
        return kind.dtype.dtype
    return types.Tuple([_opened_type(part) for part in kind]) if hasattr(kind, "__iter__") else kind


@intrinsic
def _opened(typingctx, arguments):  # type: ignore[no-untyped-def]
    """The arguments with records out of their cells."""

    def opened(context: Any, builder: Any, kind: Any, value: Any) -> Any:
        if getattr(kind, "instance_class", None) is _Cell:
            array = context.make_array(kind.dtype)(context, builder, builder.extract_value(value, 0))
            return builder.bitcast(array.data, context.get_value_type(kind.dtype.dtype))
        if hasattr(kind, "__iter__"):
            parts = [opened(context, builder, part, builder.extract_value(value, k)) for k, part in enumerate(kind)]
            return context.make_tuple(builder, _opened_type(kind), parts)
        return value

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return impl_ret_borrowed(context, builder, sig.return_type, opened(context, builder, sig.args[0], args[0]))

    return _opened_type(arguments)(arguments), build


@cache
def _repeated(function: Any) -> Any:
    @kernel
    def repeat(arguments):  # type: ignore[no-untyped-def]
        while True:
            yield function(*_opened(arguments))

    return repeat


def bound(function: Any, *arguments: Any) -> Callable[[], Any]:
    """The call `function(*arguments)` of a kernel with its arguments converted once, as a function of nothing.

    Converting records and arrays at every call costs 2 to 4 us, ten times a call of this (a compiled generator, which
    keeps them converted). Arrays are shared, records copied. No two threads may call it at once.
    """
    return _repeated(function)(_in_cells(arguments)).__next__
