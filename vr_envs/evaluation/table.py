"""Tables that read well as plain text and as Markdown."""

from __future__ import annotations

import math
from collections.abc import Collection

from vr_envs.evaluation.statistics import Estimate

MOST_DECIMALS = 6


def markdown(head: list[str], body: list[list[str]], left: Collection[int] = (0,)) -> str:
    """A Markdown table with aligned columns: those numbered in `left` to the left, the others to the right.

    A bar in a cell is escaped: unescaped it would begin another cell.
    """
    head, *body = [[cell.replace("|", r"\|") for cell in cells] for cells in (head, *body)]
    widths = [max(map(len, column)) for column in zip(head, *body, strict=True)]

    def line(cells: list[str]) -> str:
        pairs = enumerate(zip(cells, widths, strict=True))
        return f"| {' | '.join(c.ljust(w) if k in left else c.rjust(w) for k, (c, w) in pairs)} |"

    rule = ["-" * w if k in left else "-" * (w - 1) + ":" for k, w in enumerate(widths)]
    return "\n".join([line(head), line(rule), *map(line, body)])


def _decimals(estimate: Estimate) -> int:
    """Enough for three significant digits of the largest number and one of the interval's half-width."""
    largest = max(map(abs, estimate))
    half = (estimate.high - estimate.low) / 2.0
    wanted = [2 - math.floor(math.log10(largest))] if largest > 0.0 else [3]
    if half > 1e-9 * largest:
        wanted.append(-math.floor(math.log10(half)))
    return min(MOST_DECIMALS, max(0, *wanted))


def interval(estimate: Estimate, sign: bool = False, bounds: bool = True) -> str:
    """Value and, with `bounds`, its interval; a dash where there is none."""
    if math.isnan(estimate.value):
        return "-"
    decimals = _decimals(estimate)
    shown = (round(number, decimals) + 0.0 for number in estimate)  # + 0.0: no minus before a zero
    value, low, high = (f"{number:{'+' if sign else ''}.{decimals}f}" for number in shown)
    return f"{value} [{low}, {high}]" if bounds else value
