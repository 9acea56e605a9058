"""Zeros in time of what falls within a step."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .closing import GAP, Node, error_of, lowest_of, root_finder, zero_finder

__all__ = ["PIECES", "States", "falling_root", "first_zero"]

# Between nodes a solution bends little: a window is at most one radian of its fastest motion.
PIECES = 4

States = Callable[[float], tuple[np.ndarray, np.ndarray]]

# Of functions of time: those that give nodes, and those that give values alone.
_first_zero = zero_finder(lambda node, t: node(t))
_root = root_finder(lambda value, t: Node(t, value(t), 0.0))


def falling_root(function: Callable[[float], float], start: float, end: float) -> float:
    """Where a function that is positive at the start, and not at the end, comes to zero."""
    return float(_root(function, start, end, GAP, 0.0))


def first_zero(
    times: np.ndarray,
    values: np.ndarray,
    rates: np.ndarray,
    node: Callable[[int, float], Node],
    rounding: Callable[[int, float], float],
) -> tuple[float, int]:
    """The first time at which one of several smooth functions falls to zero, and which.

    Infinity and -1 where none does.

    Args:
        times: (k,) nodes, evenly in pairs. values, rates: (k, m) there.
        node: of a function, at a time.
        rounding: the rounding error of a function, of values of a size.
    """
    double, piece = (times[2::2] - times[:-2:2])[:, None], np.diff(times)[:, None]
    ends = values[:-2:2], values[1::2], values[2::2]
    errors = np.repeat(error_of(double, *ends, rates[:-2:2], rates[2::2]), 2, axis=0)
    near = lowest_of(piece, values[:-1], values[1:], rates[:-1], rates[1:], errors) <= 0.0
    for k in np.flatnonzero(near.any(axis=1)).tolist():
        best, found = np.inf, -1
        for i in np.flatnonzero(near[k]).tolist():
            a, b = (
                Node(float(times[n]), float(values[n, i]), float(rates[n, i])) for n in (k, k + 1)
            )
            size = rounding(i, max(abs(a.gap), abs(b.gap)))
            t = _first_zero(lambda t, i=i: node(i, t), a, b, float(errors[k, i]), size)
            if t < best:
                best, found = t, i
        if found >= 0:
            return best, found
    return np.inf, -1
