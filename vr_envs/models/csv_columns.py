"""Columns of numbers from a CSV file, by name."""

from __future__ import annotations

import csv
import math
import os


def read_columns(
    path: str | os.PathLike[str], names: tuple[str, ...], what: str
) -> tuple[list[int], dict[str, list[float]]]:
    """The columns `names` of a CSV file whose first row is a header; `what` is what the file holds, for errors.

    Other columns, empty lines and lines that begin with # are left alone.

    Returns:
        The number of the line of each value, from 1, and the values by name.

    Raises:
        ValueError: the file cannot be read, a column is missing, or a line has no finite number where one should be; it
            names the file, the line and the column.
    """
    where = f"{what} {str(path)!r}"
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            reader = csv.reader(file)
            rows = [(reader.line_num, row) for row in reader if "".join(row).strip() and not row[0].startswith("#")]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ValueError(f"{where} cannot be read: {error}; give the path of a CSV file") from error
    header = [name.strip() for name in rows[0][1]] if rows else []
    for name in names:
        if header.count(name) != 1:
            raise ValueError(
                f"{where}: its header, {', '.join(header) or 'empty'}, has {header.count(name)} columns {name!r}; "
                f"give each of {', '.join(names)} once, separated by commas"
            )
    values = {name: [_number(where, line, row, header.index(name), name) for line, row in rows[1:]] for name in names}
    return [line for line, _ in rows[1:]], values


def _number(where: str, line: int, row: list[str], place: int, name: str) -> float:
    """The finite number in one cell."""
    text = row[place].strip() if place < len(row) else ""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"{where}, line {line}: {name} = {text!r} is not a finite number; give one")
    return value
