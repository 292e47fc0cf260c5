"""A scene's parameters and options as one array: a kernel's call converts each argument, and one is soon converted."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils

from vr_envs.models.jit import intrinsic


def bundle(records: Sequence[np.void | None]) -> np.ndarray:
    """An array of one record with the given ones in it, in order; None keeps its place."""
    fields: list[Any] = [
        (f"{k:03}_absent", "i8") if record is None else (f"{k:03}", record.dtype) for k, record in enumerate(records)
    ]
    found = np.zeros(1, np.dtype(fields, align=True))
    for (name, _), record in zip(fields, records, strict=True):
        if record is not None:
            found[name] = record
    return found


@intrinsic
def unbundled(typingctx, bundled):  # type: ignore[no-untyped-def]
    """The records in an array made by `bundle`, a tuple; what is absent is None, as if it had been given so."""
    record = bundled.dtype
    kinds = [
        types.none if isinstance(t, types.Integer) else t for t in (record.typeof(n) for n in sorted(record.fields))
    ]

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = context.make_array(sig.args[0])(context, builder, args[0]).data
        start = builder.bitcast(data, cgutils.voidptr_t)
        values = []
        for name, kind in zip(sorted(record.fields), kinds, strict=True):
            if kind is types.none:
                values.append(context.get_dummy_value())
            else:
                place = builder.gep(start, [ir.Constant(ir.IntType(32), record.offset(name))])
                values.append(builder.bitcast(place, context.get_value_type(kind)))
        return context.make_tuple(builder, sig.return_type, values)

    return types.Tuple(kinds)(bundled), build
