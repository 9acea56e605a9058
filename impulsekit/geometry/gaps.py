"""Gaps: of a point over a plane, of a joint before a limit, of two bodies."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..laws.borrowed import borrowing

if TYPE_CHECKING:
    from .collision import Solids

__all__ = ["AT_STOP", "before_limit", "is_closed", "nearest_points", "over_plane"]

# A joint this near its limit, relative to the limit's size, is at its stop.
AT_STOP = 1e-9
# Beside a separating axis of polyhedra, coal's distance is longer by more than its own error
# [m] where the nearest points are corners, or a corner and an edge.
ERROR_OF_COAL = 1e-6
# Points of a flat pair whose gaps differ by less belong to one patch [m].
ONE_PATCH = 1e-9

# (3,) position in the world and (3,) normal from the second body to the first.
Nearest = tuple[np.ndarray, np.ndarray]


def over_plane(point: np.ndarray, normal: np.ndarray, origin: np.ndarray) -> float:
    """n·(p − o): how far a point (3,) is over a plane [m], negative below it."""
    return float(normal.dot(point - origin))


@borrowing
def before_limit(value: float, limit: float, sign: float) -> float:
    """How far a joint is before its lower (sign 1) or upper (−1) limit [rad, m]."""
    return sign * (value - limit)


@borrowing
def is_closed(gap: float, size: float) -> bool:
    """Whether a joint is at a limit, or a rope stretched, but for rounding.

    Args:
        gap: before the limit, or how much of the rope is slack [rad, m].
        size: the limit, or the length of the rope.
    """
    return gap <= AT_STOP * max(1.0, abs(size))


def nearest_points(first: Solids, other: Solids, margin: float) -> tuple[float, list[Nearest]]:
    """The distance of two bodies [m], negative where they overlap, and where they are nearest.

    Within ``margin`` these are the points at which they count as touching.
    """
    from .collision import gap_and_normal, meeting_points

    points = list(meeting_points(first, other, margin))
    if points:
        return min(p.gap for p in points), [(p.position, p.normal) for p in points]
    best: tuple[float, list[Nearest]] = (np.inf, [])
    for piece in first:
        for second in other:
            gap, normal = gap_and_normal(*piece, *second)
            found = [
                (p.position, p.normal) for p in meeting_points([piece], [second], gap + ONE_PATCH)
            ]
            both_flat = piece[0].polyhedron is not None and second[0].polyhedron is not None
            if both_flat or not found:
                distance, position, direction = _by_coal(piece, second)
                if not found:
                    found = [(position, normal)]
                if both_flat and distance > gap + ERROR_OF_COAL:
                    gap, found = distance, [(position, direction)]
            if gap < best[0]:
                best = float(gap), found
    return best


def _by_coal(one: tuple[Any, ...], two: tuple[Any, ...]) -> tuple[float, np.ndarray, np.ndarray]:
    """coal's distance [m], the middle of the nearest points, and the normal from the second."""
    import coal

    request, result = coal.DistanceRequest(), coal.DistanceResult()
    request.enable_signed_distance = True
    ends = [
        (solid.geometry, coal.Transform3s(place.rotation, place.translation))
        for solid, place in (one, two)
    ]
    distance = float(coal.distance(*ends[0], *ends[1], request, result))
    points = np.array(result.getNearestPoint1()), np.array(result.getNearestPoint2())
    return distance, 0.5 * (points[0] + points[1]), -np.array(result.normal)
