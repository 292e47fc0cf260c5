"""Gauss-Legendre quadrature with eight points, at which an integrand is evaluated once, on lanes.

Exact for polynomials up to degree 15: over a length of one decay time or radian the error is below rounding.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir

from vr_envs.models.jit import intrinsic, kernel
from vr_envs.models.lane_records import lane
from vr_envs.models.lanes import FLOAT, WIDTH

_I32 = ir.IntType(32)


def _rule() -> tuple[tuple[float, ...], tuple[float, ...], tuple[tuple[float, ...], ...]]:
    """Points and weights on [0, 1], and for every point its Lagrange polynomial's integrals up to all points."""
    points, weights = np.polynomial.legendre.leggauss(WIDTH)
    # a Lagrange polynomial as a sum of Legendre's P_k: l_j = w_j sum_k (k + 1/2) P_k(x_j) P_k, and
    # (2k + 1) times the integral of P_k from -1 to x is P_(k+1)(x) - P_(k-1)(x), with P_(-1) = -1
    legendre = np.polynomial.legendre.legvander(points, WIDTH)
    before = np.column_stack([np.full(WIDTH, -1.0), legendre[:, : WIDTH - 1]])
    integrals = 0.5 * (legendre[:, 1:] - before) @ (weights[:, None] * legendre[:, :WIDTH]).T
    columns = tuple(tuple(float(v) for v in column) for column in 0.5 * integrals.T)
    return tuple(float(v) for v in 0.5 * (points + 1.0)), tuple(float(v) for v in 0.5 * weights), columns


_POINTS, _WEIGHTS, _COLUMNS = _rule()


@intrinsic
def _side_by_side(typingctx, numbers):  # type: ignore[no-untyped-def]
    """Lanes of `WIDTH` floats given as a tuple."""

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        found = ir.Constant(context.get_value_type(FLOAT), ir.Undefined)
        for k in range(WIDTH):
            found = builder.insert_element(found, builder.extract_value(args[0], k), ir.Constant(_I32, k))
        return found

    return FLOAT(numbers), build


@kernel
def points(begin, length):  # type: ignore[no-untyped-def]
    """The points in the interval of a `length` from `begin` on, as lanes."""
    return begin + length * _side_by_side(_POINTS)


@kernel
def integral(values, length):  # type: ignore[no-untyped-def]
    """The integral over an interval of a `length` of a function with these `values` at its points."""
    shares = _side_by_side(_WEIGHTS) * values
    halves = (lane(shares, 0) + lane(shares, 4)) + (lane(shares, 1) + lane(shares, 5))
    return length * (halves + ((lane(shares, 2) + lane(shares, 6)) + (lane(shares, 3) + lane(shares, 7))))


@kernel
def running_integral(values, length):  # type: ignore[no-untyped-def]
    """The integrals from the interval's begin up to each of its points, as lanes."""
    found = 0.0
    for k in range(WIDTH):
        found += lane(values, k) * _side_by_side(_COLUMNS[k])
    return length * found
