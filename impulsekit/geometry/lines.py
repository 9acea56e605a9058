"""Nearest points of two lines."""

from __future__ import annotations

from ..laws.borrowed import borrowing
from .vectors import Vector, along, cross, dot

__all__ = ["nearest"]


@borrowing
def nearest(
    start: Vector, way: Vector, other: Vector, other_way: Vector
) -> tuple[float, float, Vector, float]:
    """Where two lines x = start + s way and y = other + u other_way come nearest.

    With c = way × other_way: s = ((other − start) × other_way)·c / |c|² and
    u = ((other − start) × way)·c / |c|² (Ericson, Real-Time Collision Detection, 2005, 5.1.8).

    Args:
        start, other: (3,) a point of each [m].
        way, other_way: (3,) their directions, which are not parallel.

    Returns:
        s, u, (3,) c and |c|².

    Example:
        >>> nearest((-1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, -2.0, 1.0), (0.0, 1.0, 0.0))[:2]
        (1.0, 2.0)
    """
    turn = cross(way, other_way)
    square = dot(turn, turn)
    apart = along(other, -1.0, start)
    s = dot(cross(apart, other_way), turn) / square
    return s, dot(cross(apart, way), turn) / square, turn, square
