"""Records: a frozen dataclass in SI units becomes a NumPy structured dtype that kernels read and write.

A dataclass stores independent quantities only. What follows from them is a property named in the class
attribute `DERIVED`; it is computed once, when the record is packed, and stands in the record as a float64.
"""

from __future__ import annotations

import dataclasses
import math
from functools import cache
from typing import Any

import numpy as np

# every field takes eight bytes: a record without padding is the same bytes after every copy
_NUMBERS = "tuple[float, ...]"
_NUMPY_TYPES = {"float": "f8", "int": "i8", "bool": "i8", "key": "u8", _NUMBERS: "f8"}


def quantity(
    default: Any,
    unit: str,
    doc: str,
    *,
    low: float = -math.inf,
    high: float = math.inf,
    choices: tuple[str, ...] | None = None,
    shape: tuple[int, ...] = (),
    kind: str | None = None,
) -> Any:
    """Declare one field of a record: its default, unit, meaning and allowed range [low, high].

    A text field has `choices`; it does not enter the record, what follows from it does (`DERIVED`).
    `shape` declares an array in a state; `kind="key"` an unsigned 64-bit integer. A parameter of the type
    `tuple[float, ...]` is a list of at least one and at most `shape[0]` numbers; zeros fill its record.
    """
    metadata = {"unit": unit, "doc": doc, "low": low, "high": high, "choices": choices, "shape": shape, "kind": kind}
    return dataclasses.field(default=default, metadata=metadata)


def _kind(field: dataclasses.Field[Any]) -> str:
    return field.metadata["kind"] or str(field.type)


@cache
def dtype_of(cls: type) -> np.dtype[Any]:
    """Aligned structured dtype of a record class: its own numeric fields, inherited ones, the names in `DERIVED`.

    A record that began as its base class does would be a subtype of it to Numba, which warns of that.
    """
    own = cls.__dict__.get("__annotations__", {})
    fields = sorted((f for f in dataclasses.fields(cls) if _kind(f) != "str"), key=lambda f: f.name not in own)
    columns: list[Any] = [(f.name, _NUMPY_TYPES[_kind(f)], f.metadata["shape"]) for f in fields]
    columns += [(name, "f8") for name in getattr(cls, "DERIVED", ())]
    if not columns:  # a record of no bytes has no address once it has been pickled
        return np.dtype({"names": [], "formats": [], "itemsize": 8})
    return np.dtype(columns, align=True)


def pack(instance: Any) -> np.void:
    """The record of a dataclass instance, as a NumPy void that kernels take by reference."""
    row = np.zeros(1, dtype_of(type(instance)))
    for name in row.dtype.names or ():
        value = getattr(instance, name)
        if isinstance(value, tuple):
            row[name][0, : len(value)] = value
        else:
            row[name] = value
    return row[0]


def checked_value(field: dataclasses.Field[Any], given: Any, label: str) -> Any:
    """`given` as the type of `field`; a value of the wrong type, size or range is a ValueError that says so."""
    if _kind(field) == _NUMBERS:
        most = field.metadata["shape"][0]
        if not isinstance(given, list | tuple | np.ndarray) or not 1 <= len(given) <= most:
            size = f"{len(given)} numbers" if isinstance(given, list | tuple | np.ndarray) else repr(given)
            raise ValueError(f"{label} = {size} is not allowed; give a list of 1 to {most} numbers")
        return tuple(_checked_number(field, value, f"{label}[{i}]") for i, value in enumerate(given))
    if _kind(field) == "str":
        choices = field.metadata["choices"]
        if given not in choices:
            raise ValueError(f"{label} = {given!r} is not allowed; choose one of {', '.join(choices)}")
        return given
    if _kind(field) == "bool":
        if not isinstance(given, bool | np.bool_):
            raise ValueError(f"{label} = {given!r} is not allowed; give true or false")
        return bool(given)
    number = _checked_number(field, given, label)
    if _kind(field) == "int":
        if int(number) != number:
            raise ValueError(f"{label} = {given!r} is not a whole number")
        return int(given)
    return number


def _checked_number(field: dataclasses.Field[Any], given: Any, label: str) -> float:
    low, high, unit = field.metadata["low"], field.metadata["high"], field.metadata["unit"]
    if isinstance(given, bool | np.bool_) or not isinstance(given, int | float | np.integer | np.floating):
        raise ValueError(f"{label} = {given!r} is not a number; give {unit or 'a number'} in [{low:g}, {high:g}]")
    if not low <= given <= high or not math.isfinite(given):
        raise ValueError(
            f"{label} = {given!r} is not allowed; it must be finite and in [{low:g}, {high:g}] {unit}".rstrip()
        )
    return float(given)


def checked(cls: type, values: dict[str, Any], where: str) -> Any:
    """An instance of `cls` from `values`, each checked by `checked_value`; `where` precedes its name in errors."""
    fields = {f.name: f for f in dataclasses.fields(cls)}
    return cls(**{name: checked_value(fields[name], given, f"{where}{name}") for name, given in values.items()})
