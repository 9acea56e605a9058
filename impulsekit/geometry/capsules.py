"""Where two capsules meet: in one point, or side by side along a line.

A capsule is all that is within its radius of a segment, so two of them are as far apart as
their segments are, less both radii. Segments that are parallel, or all but, are near each
other along a stretch, and meet at both ends of it.
"""

from __future__ import annotations

from collections.abc import Iterator

import coal
import numpy as np
import pinocchio as pin

__all__ = ["capsule_points"]

# Points nearer to each other than this are one [m].
ONE_POINT = 3e-6
TINY = 1e-12


def capsule_points(
    a: coal.Capsule, placement_a: pin.SE3, b: coal.Capsule, placement_b: pin.SE3, margin: float
) -> tuple[np.ndarray, list[tuple[np.ndarray, float]]] | None:
    """The normal (3,) from b to a, and the points where they meet with their gaps [m].

    None where their segments cut each other, and no direction is theirs.
    """
    ends = [
        place.translation + np.outer((-shape.halfLength, shape.halfLength), place.rotation[:, 2])
        for shape, place in ((a, placement_a), (b, placement_b))
    ]
    pairs = sorted(_near(*ends), key=lambda pair: float(np.linalg.norm(pair[0] - pair[1])))
    way = pairs[0][0] - pairs[0][1]
    length = float(np.linalg.norm(way))
    if length < TINY:
        return None
    normal = way / length
    found: list[tuple[np.ndarray, float]] = []
    for here, there in pairs:
        gap = float(np.linalg.norm(here - there)) - a.radius - b.radius
        middle = 0.5 * (here + there) + 0.5 * (b.radius - a.radius) * normal
        apart = all(np.abs(middle - known).max() > ONE_POINT for known, _ in found)
        if gap <= margin and apart:
            found.append((middle, gap))
    return normal, found[:2]


def _near(one: np.ndarray, other: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Points of two segments that may be nearest, or end the stretch where they are near."""
    for end in one:
        yield end, _onto(end, other)
    for end in other:
        yield _onto(end, one), end
    e, f = one[1] - one[0], other[1] - other[0]
    turn = np.cross(e, f)
    square = float(turn @ turn)
    if square > TINY**2 * float(e @ e) * float(f @ f):
        apart = other[0] - one[0]
        s, u = (float(np.cross(apart, way) @ turn) / square for way in (f, e))
        if 0.0 < s < 1.0 and 0.0 < u < 1.0:
            yield one[0] + s * e, other[0] + u * f


def _onto(point: np.ndarray, segment: np.ndarray) -> np.ndarray:
    """The point of a segment that is nearest to another."""
    way = segment[1] - segment[0]
    square = float(way @ way)
    share = float((point - segment[0]) @ way) / square if square > 0.0 else 0.0
    return segment[0] + min(max(share, 0.0), 1.0) * way
