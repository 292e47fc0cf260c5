"""Eight neighbouring records of an array, whose fields a kernel reads and writes as lanes.

`lanes_at(states, i)` is to a kernel what `states[i]` is: `state.speed` are the speeds of the records i to i + 7.
"""

from __future__ import annotations

import operator
from typing import Any

from llvmlite import ir
from numba import types
from numba.core.datamodel import models
from numba.core.imputils import lower_getattr_generic, lower_setattr_generic
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, infer_getattr, infer_global, signature
from numba.extending import intrinsic, lower_builtin, overload, register_model

from vr_envs.models.lanes import BOOL, FLOAT, WIDTH, Lanes, common_type

_I8, _I32 = ir.IntType(8), ir.IntType(32)


class LaneRecord(types.Type):
    """Numba's type of `WIDTH` records of the type `record`, one after another in memory."""

    def __init__(self, record: types.Record) -> None:
        """Of a record without padding at its end."""
        self.record = record
        super().__init__(f"lanes({record})")


class LaneArray(types.Type):
    """Numba's type of an array field of `WIDTH` records: element k is read and written as lanes."""

    def __init__(self, dtype: types.Type, shape: tuple[int, ...], stride: int) -> None:
        """`shape` elements of `dtype` in each of the records, which are `stride` bytes apart."""
        self.dtype, self.shape, self.stride = dtype, shape, stride
        super().__init__(f"lanes(array({dtype}, {shape}, {stride}))")


@register_model(LaneRecord)
@register_model(LaneArray)
class _PointerModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: types.Type) -> None:
        super().__init__(manager, kind, _I8.as_pointer())


def _places(builder: Any, first: Any, stride: int, element: Any) -> list[Any]:
    """Pointers to an element in each record."""
    return [
        builder.bitcast(builder.gep(first, [ir.Constant(_I32, k * stride)]), element.as_pointer()) for k in range(WIDTH)
    ]


def _load(context: Any, builder: Any, first: Any, stride: int, dtype: types.Type) -> Any:
    lanes = common_type((dtype,))
    found = ir.Constant(context.get_value_type(lanes), ir.Undefined)
    for k, place in enumerate(_places(builder, first, stride, context.get_data_type(dtype))):
        found = builder.insert_element(found, builder.load(place), ir.Constant(_I32, k))
    return found


def _store(context: Any, builder: Any, value: Any, first: Any, stride: int, dtype: types.Type) -> None:
    if dtype == types.float32:
        value = builder.fptrunc(value, ir.VectorType(ir.FloatType(), WIDTH))
    for k, place in enumerate(_places(builder, first, stride, context.get_data_type(dtype))):
        builder.store(builder.extract_element(value, ir.Constant(_I32, k)), place)


@infer_getattr
class _RecordFields(AttributeTemplate):
    key = LaneRecord

    def generic_resolve(self, kind: LaneRecord, name: str) -> types.Type:
        field = kind.record.typeof(name)
        if isinstance(field, types.NestedArray):
            return LaneArray(field.dtype, field.shape, kind.record.size)
        return common_type((field,))


@lower_getattr_generic(LaneRecord)
def _read_field(context: Any, builder: Any, kind: LaneRecord, value: Any, name: str) -> Any:
    field, offset = kind.record.typeof(name), kind.record.offset(name)
    first = builder.gep(value, [ir.Constant(_I32, offset)])
    return first if isinstance(field, types.NestedArray) else _load(context, builder, first, kind.record.size, field)


@lower_setattr_generic(LaneRecord)
def _write_field(context: Any, builder: Any, sig: Any, args: Any, name: str) -> Any:
    kind, given = sig.args
    field, offset = kind.record.typeof(name), kind.record.offset(name)
    value = context.cast(builder, args[1], given, common_type((field,)))
    _store(context, builder, value, builder.gep(args[0], [ir.Constant(_I32, offset)]), kind.record.size, field)


@infer_getattr
class _ArrayFields(AttributeTemplate):
    key = LaneArray

    def resolve_shape(self, kind: LaneArray) -> types.Type:
        return types.UniTuple(types.intp, len(kind.shape))


@lower_getattr_generic(LaneArray)
def _read_shape(context: Any, builder: Any, kind: LaneArray, value: Any, name: str) -> Any:
    return context.get_constant_generic(builder, types.UniTuple(types.intp, len(kind.shape)), kind.shape)


@infer_global(operator.getitem)
class _GetElement(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        if isinstance(args[0], LaneArray) and isinstance(args[1], types.Integer):
            return signature(common_type((args[0].dtype,)), args[0], types.intp)
        return None


@infer_global(operator.setitem)
class _SetElement(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        if isinstance(args[0], LaneArray) and isinstance(args[1], types.Integer):
            return signature(types.none, args[0], types.intp, common_type((args[0].dtype,)))
        return None


def _element(context: Any, builder: Any, kind: LaneArray, first: Any, index: Any) -> Any:
    size = context.get_abi_sizeof(context.get_data_type(kind.dtype))
    return builder.gep(first, [builder.mul(index, ir.Constant(index.type, size))])


@lower_builtin(operator.getitem, LaneArray, types.Integer)
def _read_element(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    kind = sig.args[0]
    return _load(context, builder, _element(context, builder, kind, *args), kind.stride, kind.dtype)


@lower_builtin(operator.setitem, LaneArray, types.Integer, Lanes)
def _write_element(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    kind = sig.args[0]
    place = _element(context, builder, kind, args[0], args[1])
    _store(context, builder, args[2], place, kind.stride, kind.dtype)
    return context.get_dummy_value()


@intrinsic
def lanes_at(typingctx, records, i):  # type: ignore[no-untyped-def]
    """The records i to i + `WIDTH` - 1 of a contiguous array of them."""
    kind = LaneRecord(records.dtype)

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        array = context.make_array(sig.args[0])(context, builder, args[0])
        return builder.bitcast(builder.gep(array.data, [args[1]]), _I8.as_pointer())

    return kind(records, types.intp), build


@intrinsic
def load_lanes(typingctx, array, i):  # type: ignore[no-untyped-def]
    """The elements i to i + `WIDTH` - 1 of a contiguous array of truths, as a mask."""

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


def lane_count(x: Any) -> int:
    """How many lanes a record, number or truth has: `WIDTH`, or 1 if it is a plain one."""
    raise NotImplementedError("for kernels only")


@overload(lane_count)
def _lane_count(x):  # type: ignore[no-untyped-def]
    count = WIDTH if isinstance(x, LaneRecord | Lanes) else 1
    return lambda x: count


@intrinsic
def lane(typingctx, x, k):  # type: ignore[no-untyped-def]
    """Lane k of lanes, as a plain number; record k of records, as a plain record; of a plain one, itself."""
    plain = x.record if isinstance(x, LaneRecord) else x.scalar if isinstance(x, Lanes) else types.unliteral(x)

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = sig.args[0]
        if isinstance(kind, LaneRecord):
            place = builder.gep(args[0], [builder.mul(args[1], ir.Constant(args[1].type, kind.record.size))])
            return builder.bitcast(place, context.get_value_type(kind.record))
        return builder.extract_element(args[0], args[1]) if isinstance(kind, Lanes) else args[0]

    return plain(types.unliteral(x), types.intp), build
