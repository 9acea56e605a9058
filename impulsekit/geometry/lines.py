"""Nearest points of two lines."""

from __future__ import annotations

import numpy as np

from .axes import cross

__all__ = ["nearest_of_lines"]


def nearest_of_lines(
    start: np.ndarray, way: np.ndarray, other: np.ndarray, other_way: np.ndarray
) -> tuple[float, float, np.ndarray, float]:
    """Where two lines x = start + s way and y = other + u other_way come nearest.

    With c = way × other_way: s = ((other − start) × other_way)·c / |c|² and
    u = ((other − start) × way)·c / |c|² (Ericson, Real-Time Collision Detection, 2005, 5.1.8).

    Args:
        start, other: (3,) a point of each [m].
        way, other_way: (3,) their directions, which are not parallel.

    Returns:
        s, u, (3,) c and |c|².

    Example:
        >>> x, y, z = np.eye(3)
        >>> s, u, _, _ = nearest_of_lines(-x, x, z - 2.0 * y, y)
        >>> s, u
        (1.0, 2.0)
    """
    turn = cross(way, other_way)
    square = float(turn.dot(turn))
    apart = other - start
    s = float(cross(apart, other_way).dot(turn)) / square
    u = float(cross(apart, way).dot(turn)) / square
    return s, u, turn, square
