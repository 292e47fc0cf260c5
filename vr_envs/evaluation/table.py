"""Tables that read well as plain text and as Markdown."""

from __future__ import annotations

import math

from vr_envs.evaluation.statistics import Estimate


def markdown(head: list[str], body: list[list[str]]) -> str:
    """A Markdown table with aligned columns, the first to the left and the others to the right."""
    widths = [max(map(len, column)) for column in zip(head, *body, strict=True)]

    def line(cells: list[str]) -> str:
        padded = [c.rjust(w) if k else c.ljust(w) for k, (c, w) in enumerate(zip(cells, widths, strict=True))]
        return f"| {' | '.join(padded)} |"

    rule = [("-" * (w - 1) + ":") if k else "-" * w for k, w in enumerate(widths)]
    return "\n".join([line(head), line(rule), *map(line, body)])


def number(value: float, sign: bool = False) -> str:
    """Three decimals for what is of order one, four significant digits beyond."""
    if math.isnan(value):
        return "-"
    digits = ".3f" if abs(value) < 10 else ".4g"
    return format(round(value, 3) + 0.0, ("+" if sign else "") + digits)  # + 0.0: no minus before a zero


def interval(estimate: Estimate, sign: bool = False) -> str:
    """Value and interval; a dash where there is none."""
    if math.isnan(estimate.value):
        return "-"
    value, low, high = (number(v, sign) for v in estimate)
    return f"{value} [{low}, {high}]"
