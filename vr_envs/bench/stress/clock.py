"""The time that a thread has computed, read within compiled loops, so that every single step can be timed."""

from __future__ import annotations

import time
from typing import Any

from numba import types

from vr_envs.models.jit import kernel

_THREAD = int(getattr(time, "CLOCK_THREAD_CPUTIME_ID", 0))
_clock_gettime: Any = types.ExternalFunction("clock_gettime", types.int32(types.int32, types.intp))


@kernel
def thread_time(scratch):
    """CPU time of this thread in ns (POSIX); `scratch` is an array of two int64."""
    _clock_gettime(_THREAD, scratch.ctypes.data)
    return scratch[0] * 1_000_000_000 + scratch[1]
