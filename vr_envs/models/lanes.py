"""Eight numbers side by side, for which a kernel compiles as it does for one.

A kernel that is given *lanes* in place of a float moves eight of them in one processor instruction, and each lane has
just the operations that the kernel has for one float, in the same order: the same bytes, and the formula stands once.
Nothing is left to the compiler's judgement of what can be vectorised.

What a kernel must keep to for that: no branch on a number. `where` chooses; `&`, `|` and `negate` connect conditions;
`any_lane` and `all_lanes` make one plain truth of them, so that what is rare can be skipped where no lane needs it;
`lane` and `lane_count` serve what can only be done record by record. All of these take plain numbers too, as one lane.
`+ - * /`, comparisons, `min`, `max`, `abs`, `math.sqrt` and `math.copysign` work on lanes as they do on numbers.
Exponentials and the like are in `elementary`, records of lanes in `lane_records`.
"""

from __future__ import annotations

import math
import operator
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.datamodel import models
from numba.core.errors import TypingError
from numba.core.typeconv.castgraph import Conversion
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import lower_builtin, lower_cast, register_model

from vr_envs.models.jit import intrinsic

WIDTH = 8
_I32 = ir.IntType(32)
_register: Any = infer_global  # Numba does not say what it returns


class Lanes(types.Type):
    """Numba's type of `WIDTH` numbers of the type `scalar`."""

    def __init__(self, scalar: types.Type) -> None:
        """Lanes of float64, int64, uint64 or boolean."""
        self.scalar = scalar
        super().__init__(f"lanes({scalar})")

    def unify(self, typingctx: Any, other: types.Type) -> types.Type | None:
        """A variable that is a number here and lanes there is lanes."""
        if isinstance(other, types.Number | types.Boolean | Lanes):
            return common_type((self, other))
        return None

    def can_convert_from(self, typingctx: Any, other: types.Type) -> Conversion | None:
        """From a number, and from lanes that a number of this type would be made from."""
        if isinstance(other, types.Number | types.Boolean):
            return Conversion.safe
        if isinstance(other, Lanes) and _RANK[self.scalar] > _RANK[other.scalar]:
            return Conversion.promote
        return None


BOOL, INT, KEY, FLOAT = (Lanes(t) for t in (types.boolean, types.int64, types.uint64, types.float64))
_RANK = {types.boolean: 0, types.int64: 1, types.uint64: 2, types.float64: 3}


def scalar_of(given: types.Type) -> types.Type:
    """The type of one lane, of lanes or a number."""
    given = types.unliteral(given)
    if isinstance(given, Lanes):
        return given.scalar
    if isinstance(given, types.Boolean):
        return types.boolean
    if isinstance(given, types.Integer):
        return types.uint64 if given.name.startswith("u") else types.int64
    return types.float64


def common_type(given: tuple[types.Type, ...]) -> Lanes:
    """The lanes in which numbers and lanes meet: floats if there is one, else keys, integers, truths."""
    widest = max((scalar_of(t) for t in given), key=_RANK.__getitem__)
    if widest == types.uint64 and any(scalar_of(t) == types.int64 for t in given):
        raise TypingError("a key and a signed integer meet: to Numba's numbers that is a float; convert one of them")
    return {lanes.scalar: lanes for lanes in (BOOL, INT, KEY, FLOAT)}[widest]


def are_lanes(*given: types.Type) -> bool:
    """Whether any of these types is of lanes."""
    return any(isinstance(t, Lanes) for t in given)


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, lanes: Lanes) -> None:
        element = manager.lookup(lanes.scalar).get_value_type()
        super().__init__(manager, lanes, ir.VectorType(element, WIDTH))


@lower_cast(types.Number, Lanes)
@lower_cast(types.Boolean, Lanes)
def _spread(context: Any, builder: Any, source: Any, target: Lanes, value: Any) -> Any:
    """The same number in all lanes."""
    number = context.cast(builder, value, source, target.scalar)
    blank = ir.Constant(context.get_value_type(target), ir.Undefined)
    first = builder.insert_element(blank, number, ir.Constant(_I32, 0))
    return builder.shuffle_vector(first, blank, ir.Constant(ir.VectorType(_I32, WIDTH), [0] * WIDTH))


@lower_cast(Lanes, Lanes)
def _convert(context: Any, builder: Any, source: Lanes, target: Lanes, value: Any) -> Any:
    pair, wanted = (source.scalar, target.scalar), context.get_value_type(target)
    if source == target or pair in ((types.int64, types.uint64), (types.uint64, types.int64)):
        return value
    if pair[0] == types.boolean:
        value = builder.zext(value, context.get_value_type(INT))
        return builder.sitofp(value, wanted) if target == FLOAT else value
    if pair[0] == types.float64:
        return builder.fptosi(value, wanted)
    return builder.uitofp(value, wanted) if source == KEY else builder.sitofp(value, wanted)


def _operation(function: Any, result: Lanes | None, build: dict[Any, Any], operands: Lanes | None = None) -> None:
    """Teach Numba an operation on lanes: `build[scalar](builder, *values)` gives its instructions."""

    class Template(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            if not are_lanes(*args) or not all(isinstance(a, Lanes | types.Number | types.Boolean) for a in args):
                return None
            meet = operands or common_type(args)
            return signature(result or meet, *[meet] * len(args)) if meet.scalar in build else None

    _register(function)(Template)

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return build[sig.args[0].scalar](builder, *args)

    for count in (1, 2, 3):
        lower_builtin(function, *[Lanes] * count)(lower)


def _named(float_name: str | None, int_name: str | None, key_name: str | None = None) -> dict[Any, Any]:
    """Instructions by the builder's names for them."""
    names = {types.float64: float_name, types.int64: int_name, types.uint64: key_name or int_name}
    return {t: lambda builder, *v, n=n: getattr(builder, n)(*v) for t, n in names.items() if n is not None}


for _op, _inplace, _instructions in (
    (operator.add, operator.iadd, _named("fadd", "add")),
    (operator.sub, operator.isub, _named("fsub", "sub")),
    (operator.mul, operator.imul, _named("fmul", "mul")),
    (operator.lshift, operator.ilshift, _named(None, "shl")),
    (operator.rshift, operator.irshift, _named(None, "ashr", "lshr")),
):
    _operation(_op, None, _instructions)
    _operation(_inplace, None, _instructions)
for _op in (operator.truediv, operator.itruediv):
    _operation(_op, FLOAT, _named("fdiv", None), FLOAT)
_operation(operator.neg, None, _named("fneg", "neg"))
for _op, _inplace, _name in (
    (operator.and_, operator.iand, "and_"),
    (operator.or_, operator.ior, "or_"),
    (operator.xor, operator.ixor, "xor"),
):
    _bitwise = {t: lambda builder, a, b, n=_name: getattr(builder, n)(a, b) for t in list(_RANK)[:3]}
    _operation(_op, None, _bitwise)
    _operation(_inplace, None, _bitwise)


def _compare(sign: str) -> dict[Any, Any]:
    floats = "fcmp_unordered" if sign == "!=" else "fcmp_ordered"
    names = {types.float64: floats, types.int64: "icmp_signed", types.uint64: "icmp_unsigned"}
    return {t: lambda builder, a, b, n=n: getattr(builder, n)(sign, a, b) for t, n in names.items()}


for _op, _sign in (
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.gt, ">"),
    (operator.ge, ">="),
    (operator.eq, "=="),
    (operator.ne, "!="),
):
    _operation(_op, BOOL, _compare(_sign))


def _extreme(sign: str) -> dict[Any, Any]:
    """`min` and `max` as Numba has them for numbers: a later argument wins where it is strictly beyond."""

    def build(builder: Any, *values: Any, beyond: Any) -> Any:
        found = values[0]
        for value in values[1:]:
            found = builder.select(beyond(builder, value, found), value, found)
        return found

    return {t: lambda builder, *v, c=c: build(builder, *v, beyond=c) for t, c in _compare(sign).items()}


_operation(min, None, _extreme("<"))
_operation(max, None, _extreme(">"))


def _intrinsic_of(name: str) -> Any:
    """An instruction of LLVM that it has for vectors too."""

    def build(builder: Any, *values: Any) -> Any:
        kind = values[0].type
        suffix = f"v{WIDTH}f64" if isinstance(kind, ir.VectorType) else "f64"
        declared = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(kind, [kind] * len(values)), f"llvm.{name}.{suffix}"
        )
        return builder.call(declared, values)

    return build


_operation(abs, None, {types.float64: _intrinsic_of("fabs")})
_operation(math.sqrt, FLOAT, {types.float64: _intrinsic_of("sqrt")}, FLOAT)
_operation(math.copysign, FLOAT, {types.float64: _intrinsic_of("copysign")}, FLOAT)


def _like(argument: types.Type, kind: types.Type) -> types.Type:
    """`kind`, or lanes of it where the argument is of lanes."""
    return common_type((kind,)) if are_lanes(argument) else kind


@intrinsic
def floor(typingctx, x):  # type: ignore[no-untyped-def]
    """The greatest whole number not above x, as a float (`math.floor` makes an integer of it)."""
    kind = _like(x, types.float64)
    return kind(kind), lambda context, builder, sig, args: _intrinsic_of("floor")(builder, *args)


@intrinsic
def where(typingctx, mask, a, b):  # type: ignore[no-untyped-def]
    """`a` where the mask holds, elsewhere `b`; both have been evaluated."""
    if are_lanes(mask, a, b):
        kind, condition = common_type((a, b)), BOOL
    else:
        kind, condition = typingctx.unify_types(types.unliteral(a), types.unliteral(b)), types.boolean

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        truth = args[0] if condition == BOOL else context.is_true(builder, condition, args[0])
        return builder.select(truth, args[1], args[2])

    return kind(condition, kind, kind), build


@intrinsic
def negate(typingctx, mask):  # type: ignore[no-untyped-def]
    """Where the mask does not hold."""
    kind = _like(mask, types.boolean)
    return kind(kind), lambda context, builder, sig, args: builder.not_(args[0])


def _conversion(target: types.Type, name: str, doc: str) -> Any:
    def typed(typingctx, x):  # type: ignore[no-untyped-def]
        kind = _like(x, target)

        def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            return context.cast(builder, args[0], sig.args[0], kind)

        return kind(types.unliteral(x)), build

    typed.__name__, typed.__qualname__, typed.__doc__ = name, name, doc
    return intrinsic(typed)


to_float = _conversion(types.float64, "to_float", "An integer as a float.")
to_int = _conversion(types.int64, "to_int", "A float cut to an integer of 64 bits, a truth as 0 or 1.")
to_key = _conversion(types.uint64, "to_key", "An integer as one of 64 bits without sign.")


def _pattern(source: types.Type, target: types.Type, name: str, doc: str) -> Any:
    def typed(typingctx, x):  # type: ignore[no-untyped-def]
        kind = _like(x, target)

        def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            return builder.bitcast(args[0], context.get_value_type(kind))

        return kind(_like(x, source)), build

    typed.__name__, typed.__qualname__, typed.__doc__ = name, name, doc
    return intrinsic(typed)


bits_of_float = _pattern(types.float64, types.int64, "bits_of_float", "The bits of a float as an integer.")
float_of_bits = _pattern(types.int64, types.float64, "float_of_bits", "The float that has these bits.")


def _truth(name: str, doc: str, sign: str, pattern: int) -> Any:
    def typed(typingctx, mask):  # type: ignore[no-untyped-def]
        def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            if sig.args[0] != BOOL:
                return args[0]
            bits = ir.IntType(WIDTH)
            return builder.icmp_unsigned(sign, builder.bitcast(args[0], bits), ir.Constant(bits, pattern))

        return types.boolean(_like(mask, types.boolean)), build

    typed.__name__, typed.__qualname__, typed.__doc__ = name, name, doc
    return intrinsic(typed)


any_lane = _truth("any_lane", "Whether the mask holds in any lane, a plain truth.", "!=", 0)
all_lanes = _truth("all_lanes", "Whether the mask holds in every lane, a plain truth.", "==", (1 << WIDTH) - 1)
