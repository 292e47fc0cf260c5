"""Rows of a batch, one after the other, as arrays of lanes and back: actions on their way in, observations out."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils

from vr_envs.models.jit import intrinsic
from vr_envs.models.lane_records import SideArray
from vr_envs.models.lanes import BOOL, FLOAT, WIDTH

_I8, _I32 = ir.IntType(8), ir.IntType(32)


def _place(context: Any, builder: Any, kind: Any, array: Any, i: Any) -> Any:
    """Pointer to element i of a contiguous array."""
    return builder.gep(context.make_array(kind)(context, builder, array).data, [i])


def _scratch(builder: Any, element: Any, count: int) -> Any:
    """Room for `count` vectors on the stack."""
    vectors = cgutils.alloca_once(builder, ir.ArrayType(ir.VectorType(element, WIDTH), count))
    vectors.align = 64
    return vectors


def _at(pointer: Any, builder: Any, *index: int) -> Any:
    return builder.gep(pointer, [ir.Constant(_I32, k) for k in index])


@intrinsic
def gathered(typingctx, records, i):  # type: ignore[no-untyped-def]
    """The field `row` of the records i to i + `WIDTH` - 1 of a contiguous array, copied side by side."""
    row = records.dtype.typeof("row")
    (width,) = row.shape

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        element = context.get_data_type(row.dtype)
        rows = builder.bitcast(_place(context, builder, sig.args[0], *args), element.as_pointer())
        scratch = _scratch(builder, element, width)
        for k in range(width):
            vector = ir.Constant(ir.VectorType(element, WIDTH), ir.Undefined)
            for r in range(WIDTH):
                one = builder.load(_at(rows, builder, r * width + k))
                vector = builder.insert_element(vector, one, ir.Constant(_I32, r))
            builder.store(vector, _at(scratch, builder, 0, k))
        return builder.bitcast(scratch, _I8.as_pointer())

    return SideArray(row.dtype, row.shape, True)(records, types.intp), build


@intrinsic
def blank_rows(typingctx, records):  # type: ignore[no-untyped-def]
    """Room for the field `row` of `WIDTH` records, side by side; what stands in it is arbitrary."""
    row = records.dtype.typeof("row")

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        scratch = _scratch(builder, context.get_data_type(row.dtype), row.shape[0])
        return builder.bitcast(scratch, _I8.as_pointer())

    return SideArray(row.dtype, row.shape, True)(records), build


def _transposed(builder: Any, columns: list[Any]) -> list[Any]:
    """`WIDTH` vectors that hold element (column, row) in place (row, column), by exchanges of halves, quarters, ..."""
    vectors, half = list(columns), WIDTH // 2
    while half:
        for a in range(WIDTH):
            if not a & half:
                b = a | half
                low = [k if not k & half else WIDTH + (k & ~half) for k in range(WIDTH)]
                high = [k | half if not k & half else WIDTH + k for k in range(WIDTH)]
                masks = [ir.Constant(ir.VectorType(_I32, WIDTH), order) for order in (low, high)]
                vectors[a], vectors[b] = (builder.shuffle_vector(vectors[a], vectors[b], mask) for mask in masks)
        half //= 2
    return vectors


@intrinsic
def scatter(typingctx, rows, records, i):  # type: ignore[no-untyped-def]
    """Write rows that stand side by side to the field `row` of the records i to i + `WIDTH` - 1."""
    (width,) = rows.shape

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        element = context.get_data_type(rows.dtype)
        vector = ir.VectorType(element, WIDTH)
        target = builder.bitcast(_place(context, builder, sig.args[1], args[1], args[2]), element.as_pointer())
        source = builder.bitcast(args[0], vector.as_pointer())
        # squares of `WIDTH` columns; the last one may overlap the one before
        starts = [*range(0, width - WIDTH + 1, WIDTH), *([width - WIDTH] if width % WIDTH and width > WIDTH else [])]
        for first in starts:
            columns = [builder.load(_at(source, builder, first + k)) for k in range(WIDTH)]
            for r, values in enumerate(_transposed(builder, columns)):
                place = builder.bitcast(_at(target, builder, r * width + first), vector.as_pointer())
                builder.store(values, place, align=4)
        for k in range(width if width < WIDTH else 0):
            values = builder.load(_at(source, builder, k))
            for r in range(WIDTH):
                builder.store(
                    builder.extract_element(values, ir.Constant(_I32, r)), _at(target, builder, r * width + k)
                )
        return context.get_dummy_value()

    return types.void(rows, records, types.intp), build


@intrinsic
def load_lanes(typingctx, array, i):  # type: ignore[no-untyped-def]
    """The elements i to i + `WIDTH` - 1 of a contiguous array of truths or small numbers, as a mask: whether odd."""

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = context.make_array(sig.args[0])(context, builder, args[0]).data
        block = ir.VectorType(context.get_data_type(array.dtype), WIDTH)
        stored = builder.load(builder.bitcast(builder.gep(data, [args[1]]), block.as_pointer()), align=1)
        return builder.trunc(stored, context.get_value_type(BOOL))

    return BOOL(array, types.intp), build


@intrinsic
def store_lanes(typingctx, array, i, value):  # type: ignore[no-untyped-def]
    """Write lanes to the elements i to i + `WIDTH` - 1 of a contiguous array of floats or truths."""

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = context.make_array(sig.args[0])(context, builder, args[0]).data
        block = ir.VectorType(context.get_data_type(array.dtype), WIDTH)
        given = args[2] if sig.args[2] == FLOAT else builder.zext(args[2], block)
        builder.store(given, builder.bitcast(builder.gep(data, [args[1]]), block.as_pointer()), align=1)
        return context.get_dummy_value()

    return types.void(array, types.intp, FLOAT if array.dtype == types.float64 else BOOL), build
