"""The one decorator for compiled kernels.

Numba's own disk cache notices an edit of the file a function stands in, but not an edit of a function
that it calls from another file, and it cannot recognise a closure again in the next process. Here
the cache is valid for one text of all kernel sources in the package and of the files beside the kernel's own, so a
stale kernel is never loaded.
"""

from __future__ import annotations

import hashlib
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numba
import numba.extending
from llvmlite import ir
from numba.core import cgutils
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.datamodel.models import UniTupleModel

PACKAGE = Path(__file__).resolve().parent.parent
KERNEL_FOLDERS = ("models", "envs")


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
        number = int(hashlib.sha256(repr((self._source_stamp, key)).encode()).hexdigest()[:12], 16)
        name = self._data_name(number)
        self._save_data(name, data)
        self._save_index({**self._load_index(), key: name})


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


def _load_elements(self: Any, builder: Any, ptr: Any, align: Any = None) -> Any:
    value = ir.Constant(self.get_value_type(), ir.Undefined)
    for i in range(self._count):
        place = cgutils.gep_inbounds(builder, ptr, 0, i)
        value = builder.insert_value(value, self._elem_model.load_from_data_pointer(builder, place, align), i)
    return value


# Numba loads a tuple of one type whole, which a record cannot be; one of several types it loads like this
UniTupleModel.load_from_data_pointer = _load_elements


@cache
def _repeated(function: Any) -> Any:
    @kernel
    def repeat(arguments):  # type: ignore[no-untyped-def]
        while True:
            yield function(*arguments)

    return repeat


def bound(function: Any, *arguments: Any) -> Callable[[], Any]:
    """The call `function(*arguments)` of a kernel with its arguments converted once, as a function of nothing.

    Converting records and arrays at every call costs 2 to 4 us, ten times a call of this (a compiled generator, which
    keeps them converted). Arrays are shared, records copied. No two threads may call it at once.
    """
    return _repeated(function)(arguments).__next__
