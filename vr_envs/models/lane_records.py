"""Records whose fields lie side by side, eight records to a block: what lanes read in one go.

In a *block* field f of the records 0 to 7 follows field e of the records 0 to 7, so that `state.speed` of a block is
one load of a vector. A block has the size of eight records; `read_records` and `write_records` go from one to the
other. `block_at(blocks, b)` is to a kernel what `states[i]` is, for eight records; `lane(block, k)` is record k in it
as a plain one.
"""

from __future__ import annotations

import operator
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.datamodel import models
from numba.core.imputils import lower_getattr_generic, lower_setattr_generic
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, infer_getattr, infer_global, signature
from numba.extending import lower_builtin, overload, register_model

from vr_envs.models.jit import intrinsic
from vr_envs.models.lanes import INT, WIDTH, Lanes, common_type

_I8, _I32 = ir.IntType(8), ir.IntType(32)
_register: Any = infer_global  # Numba does not say what it returns
_FIELD = "lanes"


def block_dtype(record: np.dtype[Any]) -> np.dtype[Any]:
    """The dtype of a block of `WIDTH` records; all of their numbers have eight bytes."""
    return np.dtype([(_FIELD, record, (WIDTH,))])


def empty_blocks(record: np.dtype[Any], count: int) -> np.ndarray:
    """Zeroed blocks for `count` records, at the start of a cache line."""
    size, number = WIDTH * record.itemsize, -(-count // WIDTH)
    memory = np.zeros(size * number + 64, np.uint8)
    begin = -memory.ctypes.data % 64
    return memory[begin : begin + size * number].view(block_dtype(record))


def _words(blocks: np.ndarray) -> np.ndarray:
    """The numbers of blocks, (blocks, numbers of a record, `WIDTH`); shares their memory."""
    return blocks.view(np.uint64).reshape(len(blocks), -1, WIDTH)


def read_records(blocks: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """A copy of some records of blocks, by their numbers."""
    words = _words(blocks)[rows // WIDTH, :, rows % WIDTH]
    return np.ascontiguousarray(words).view(blocks.dtype[_FIELD].base).reshape(len(rows))


def write_records(blocks: np.ndarray, rows: np.ndarray, records: np.ndarray) -> None:
    """Put one record, or one each, into blocks."""
    words = np.ascontiguousarray(records).view(np.uint64).reshape(len(records), -1)
    _words(blocks)[rows // WIDTH, :, rows % WIDTH] = words


class Side(types.Type):
    """Numba's type of records of the type `record` in a block: all of them as lanes, or one as a plain record."""

    def __init__(self, record: types.Record, lanes: bool) -> None:
        """`lanes`: all `WIDTH`; otherwise one."""
        self.record, self.lanes = record, lanes
        super().__init__(f"{'block' if lanes else 'lane'}({record})")


class SideArray(types.Type):
    """Numba's type of arrays side by side, of each element `WIDTH` ones: fields of records in a block, or rows."""

    def __init__(self, dtype: types.Type, shape: tuple[int, ...], lanes: bool) -> None:
        """`shape`: of one of the arrays; `lanes`: all of them, or one."""
        self.dtype, self.shape, self.lanes = dtype, shape, lanes
        super().__init__(f"side({dtype}, {shape}, {lanes})")


@register_model(Side)
@register_model(SideArray)
class _PointerModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: types.Type) -> None:
        super().__init__(manager, kind, _I8.as_pointer())


def _value_type(dtype: types.Type, lanes: bool) -> types.Type:
    """What a kernel reads and writes of a field of this type."""
    return common_type((dtype,)) if lanes else dtype


def _vector(context: Any, dtype: types.Type) -> Any:
    return ir.VectorType(context.get_data_type(dtype), WIDTH)


def _load(context: Any, builder: Any, place: Any, dtype: types.Type, lanes: bool) -> Any:
    kind = _vector(context, dtype) if lanes else context.get_data_type(dtype)
    size = context.get_abi_sizeof(context.get_data_type(dtype))
    return builder.load(builder.bitcast(place, kind.as_pointer()), align=size)


def _store(context: Any, builder: Any, value: Any, place: Any, dtype: types.Type) -> None:
    if dtype == types.float32 and isinstance(value.type, ir.VectorType):
        value = builder.fptrunc(value, _vector(context, dtype))
    size = context.get_abi_sizeof(context.get_data_type(dtype))
    builder.store(value, builder.bitcast(place, value.type.as_pointer()), align=size)


@infer_getattr
class _Fields(AttributeTemplate):
    key = Side

    def generic_resolve(self, kind: Side, name: str) -> types.Type:
        field = kind.record.typeof(name)
        if isinstance(field, types.NestedArray):
            return SideArray(field.dtype, field.shape, kind.lanes)
        return _value_type(field, kind.lanes)


@lower_getattr_generic(Side)
def _read_field(context: Any, builder: Any, kind: Side, value: Any, name: str) -> Any:
    field, offset = kind.record.typeof(name), kind.record.offset(name)
    place = builder.gep(value, [ir.Constant(_I32, WIDTH * offset)])
    if isinstance(field, types.NestedArray):
        return place
    return _load(context, builder, place, field, kind.lanes)


@lower_setattr_generic(Side)
def _write_field(context: Any, builder: Any, sig: Any, args: Any, name: str) -> Any:
    kind, given = sig.args
    field, offset = kind.record.typeof(name), kind.record.offset(name)
    value = context.cast(builder, args[1], given, _value_type(field, kind.lanes))
    _store(context, builder, value, builder.gep(args[0], [ir.Constant(_I32, WIDTH * offset)]), field)


@infer_getattr
class _ArrayFields(AttributeTemplate):
    key = SideArray

    def resolve_shape(self, kind: SideArray) -> types.Type:
        return types.UniTuple(types.intp, len(kind.shape))


@lower_getattr_generic(SideArray)
def _read_shape(context: Any, builder: Any, kind: SideArray, value: Any, name: str) -> Any:
    return context.get_constant_generic(builder, types.UniTuple(types.intp, len(kind.shape)), kind.shape)


def _is_index(kind: Any, index: Any) -> bool:
    """Whether an array field can be indexed so: by an integer, or by as many as it has axes."""
    if not isinstance(kind, SideArray):
        return False
    if isinstance(index, types.Integer):
        return len(kind.shape) == 1
    return (
        isinstance(index, types.Tuple | types.UniTuple)
        and len(index) == len(kind.shape)
        and all(isinstance(number, types.Integer) for number in index.types)
    )


@_register(operator.getitem)
class _GetElement(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        kind, index = args
        return signature(_value_type(kind.dtype, kind.lanes), kind, index) if _is_index(kind, index) else None


@_register(operator.getitem)
class _GetElements(AbstractTemplate):
    """In each record the element whose number stands in its lane."""

    def generic(self, args: Any, kws: Any) -> Any:
        kind, index = args
        if not isinstance(kind, SideArray) or not kind.lanes or len(kind.shape) != 1 or index != INT:
            return None
        return signature(_value_type(kind.dtype, True), kind, index)


@lower_builtin(operator.getitem, SideArray, Lanes)
def _gather(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    i64 = ir.IntType(64)
    element = context.get_data_type(sig.args[0].dtype)
    numbers, vector, truths = (ir.VectorType(t, WIDTH) for t in (i64, element, ir.IntType(1)))
    pointers = ir.VectorType(element.as_pointer(), WIDTH)
    first = builder.insert_element(
        ir.Constant(numbers, ir.Undefined), builder.ptrtoint(args[0], i64), ir.Constant(_I32, 0)
    )
    first = builder.shuffle_vector(first, first, ir.Constant(ir.VectorType(_I32, WIDTH), [0] * WIDTH))
    ahead = builder.mul(args[1], ir.Constant(numbers, [8 * WIDTH] * WIDTH))
    own = ir.Constant(numbers, [8 * k for k in range(WIDTH)])
    places = builder.inttoptr(builder.add(first, builder.add(ahead, own)), pointers)
    gather = cgutils.get_or_insert_function(
        builder.module,
        ir.FunctionType(vector, [pointers, _I32, truths, vector]),
        f"llvm.masked.gather.v{WIDTH}{'f' if sig.args[0].dtype == types.float64 else 'i'}64.v{WIDTH}p0",
    )
    everywhere, blank = ir.Constant(truths, [True] * WIDTH), ir.Constant(vector, ir.Undefined)
    return builder.call(gather, [places, ir.Constant(_I32, 8), everywhere, blank])


@_register(operator.setitem)
class _SetElement(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        kind, index, _ = args
        if not _is_index(kind, index):
            return None
        return signature(types.none, kind, index, _value_type(kind.dtype, kind.lanes))


def _element(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    kind, index = sig.args[0], sig.args[1]
    if isinstance(index, types.Integer):
        number = context.cast(builder, args[1], index, types.intp)
    else:
        number = ir.Constant(ir.IntType(64), 0)
        for axis, size in enumerate(kind.shape):
            part = context.cast(builder, builder.extract_value(args[1], axis), index[axis], types.intp)
            number = builder.add(builder.mul(number, ir.Constant(number.type, size)), part)
    size = WIDTH * context.get_abi_sizeof(context.get_data_type(kind.dtype))
    return builder.gep(args[0], [builder.mul(number, ir.Constant(number.type, size))])


@lower_builtin(operator.getitem, SideArray, types.Any)
def _read_element(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    kind = sig.args[0]
    return _load(context, builder, _element(context, builder, sig, args), kind.dtype, kind.lanes)


@lower_builtin(operator.setitem, SideArray, types.Any, types.Any)
def _write_element(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    kind = sig.args[0]
    _store(context, builder, args[2], _element(context, builder, sig, args), kind.dtype)
    return context.get_dummy_value()


@intrinsic
def block_at(typingctx, blocks, b):  # type: ignore[no-untyped-def]
    """Block b of an array of them, its records as lanes."""
    kind = Side(blocks.dtype.typeof(_FIELD).dtype, True)

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        array = context.make_array(sig.args[0])(context, builder, args[0])
        return builder.bitcast(builder.gep(array.data, [args[1]]), _I8.as_pointer())

    return kind(blocks, types.intp), build


def record_at(states: Any, i: int) -> Any:
    """Record i of an array of records or of blocks, as a plain record."""
    raise NotImplementedError("for kernels only")


@overload(record_at)
def _record_at(states, i):  # type: ignore[no-untyped-def]
    if _FIELD in states.dtype.fields:
        return lambda states, i: lane(block_at(states, i // WIDTH), i % WIDTH)
    return lambda states, i: states[i]


def lane_count(x: Any) -> int:
    """How many lanes a record, number or truth has: `WIDTH`, or 1 if it is a plain one."""
    raise NotImplementedError("for kernels only")


@overload(lane_count)
def _lane_count(x):  # type: ignore[no-untyped-def]
    count = WIDTH if isinstance(x, Lanes) or (isinstance(x, Side) and x.lanes) else 1
    return lambda x: count


@intrinsic
def lane(typingctx, x, k):  # type: ignore[no-untyped-def]
    """Lane k of lanes, as a plain number; record k of a block, as a plain record; of a plain one, itself."""
    plain = types.unliteral(x)
    if isinstance(x, Lanes):
        plain = x.scalar
    elif isinstance(x, Side):
        plain = Side(x.record, False)

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = sig.args[0]
        if isinstance(kind, Lanes):
            return builder.extract_element(args[0], args[1])
        if isinstance(kind, Side) and kind.lanes:
            return builder.gep(args[0], [builder.mul(args[1], ir.Constant(args[1].type, 8))])
        return args[0]

    return plain(types.unliteral(x), types.intp), build
