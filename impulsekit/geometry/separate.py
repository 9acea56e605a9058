"""How far two convex shapes are apart, and along which direction.

The largest separation s(n) = −h_a(−n) − h_b(n) is their distance where they are apart, and
minus the depth of their overlap where they are not. It is that along a normal of a face, or
one on which a point, a line or a circle of either meets one of the other: all of these are
worked out in closed form but two circles (``tangents``), and the best is taken. None of them
can be too good: s(n) is no more than the distance for any n.
"""

from __future__ import annotations

import numpy as np

from .convex import Convex
from .polyhedron import AS_GOOD, PARALLEL
from .tangents import along_circles, cone_sides, of_circle_and_points, of_circles_and_lines

__all__ = ["separate"]

# Separations closer than this are the same [m], and of shapes this near the points are looked at.
ALIKE_GAPS, TIPS = 1e-14, 1e-3
# Shapes this near [m] have no direction between their points; that of both shrunk by this factor
# about their middles is taken, if it is as good.
AMBIGUOUS = 1e-11
SHRINK = 0.99


def separate(a: Convex, b: Convex) -> tuple[float, np.ndarray]:
    """The gap of two shapes [m], and its normal (3,) from b to a."""
    faces = np.concatenate((a.normals, b.normals))
    gap, normal, settled = -np.inf, np.array((0.0, 0.0, 1.0)), False
    if len(faces):
        gap, normal = _best(a, b, faces)
        settled = gap >= 0.0 and _is_nearest(a, b, gap, normal)
    for more in (_straight, _round):
        if settled:
            break
        ways = more(a, b, gap, normal)
        if len(ways):
            further, turned = _best(a, b, ways)
            if further > gap + AS_GOOD:
                gap, normal = further, turned
                settled = gap >= 0.0 and _is_nearest(a, b, gap, normal)
    if abs(gap) < AMBIGUOUS and not settled:
        # Where tips touch, many directions are as good, and rounding would choose.
        _, middle = separate(a.shrunk(SHRINK), b.shrunk(SHRINK))
        same, turned = _best(a, b, middle[None, :])
        if same >= gap - abs(gap) - AS_GOOD:
            return same, turned
    return gap, normal


def _best(a: Convex, b: Convex, ways: np.ndarray) -> tuple[float, np.ndarray]:
    """The largest separation along unit vectors up to their sign (k, 3), and which it is."""
    above = -a.support(-ways) - b.support(ways)
    below = -a.support(ways) - b.support(-ways)
    gaps = np.maximum(above, below)
    i = int(gaps.argmax())
    alike = np.flatnonzero(gaps >= gaps[i] - ALIKE_GAPS)
    if len(alike) > 1 and abs(float(gaps[i])) < TIPS:
        # Close tips are nearly as far apart along other directions; the points tell.
        signs = np.where(above[alike] >= below[alike], 1.0, -1.0)
        i = int(alike[int(np.argmin([_miss(a, b, n) for n in signs[:, None] * ways[alike]]))])
    return float(gaps[i]), ways[i] if above[i] >= below[i] else -ways[i]


def _miss(a: Convex, b: Convex, normal: np.ndarray) -> float:
    """How far the points that reach furthest are off the normal of each other [m]."""
    way = a.farthest(-normal) - b.farthest(normal)
    way = way - way.dot(normal) * normal
    return float(np.sqrt(way.dot(way)))


def _is_nearest(a: Convex, b: Convex, gap: float, normal: np.ndarray) -> bool:
    """Whether the point of one that reaches furthest has its foot on the other.

    Then no two points are nearer. Where it has not, they may still be nearest.
    """
    for own, other, way in ((a, b, normal), (b, a, -normal)):
        if other.has(own.farthest(-way) - gap * way):
            return True
    return False


def _straight(a: Convex, b: Convex, gap: float, normal: np.ndarray) -> np.ndarray:
    """(k, 3) where points and lines of two shapes meet each other, and points their circles."""
    found = []
    spots_a, spots_b = (np.concatenate((s.points, s.centres)) for s in (a, b))
    found.append((spots_a[:, None, :] - spots_b[None, :, :]).reshape(-1, 3))
    for own, spots in ((a, spots_b), (b, spots_a)):
        for start, way in zip(own.starts, own.ways, strict=True):
            away = spots - start
            found.append(away - np.outer(away.dot(way), way))
        for centre, r in zip(own.centres, own.radii, strict=True):
            found.append(of_circle_and_points(centre, own.axis, float(r), spots))
        if own.slant is not None:
            other = b if own is a else a
            found.append(cone_sides(own.points[0], own.axis, own.slant, other))
    if len(a.ways) and len(b.ways):
        found.append(np.cross(a.ways[:, None, :], b.ways[None, :, :]).reshape(-1, 3))
    ways = np.concatenate(found)
    size = np.linalg.norm(ways, axis=1)
    keep = size > PARALLEL
    return ways[keep] / size[keep, None]


def _round(a: Convex, b: Convex, gap: float, normal: np.ndarray) -> np.ndarray:
    """(k, 3) where circles of two shapes meet lines and circles of the other.

    What is nearest, or overlaps least, is within ``near`` of each other.
    """
    way = a.farthest(-normal) - b.farthest(normal)
    near = max(abs(gap), float(np.sqrt(way.dot(way))))
    found = []
    for own, other in ((a, b), (b, a)):
        for centre, r in zip(own.centres, own.radii, strict=True):
            away = other.starts - centre
            away = away - np.einsum("ij,ij->i", away, other.ways)[:, None] * other.ways
            reach = np.einsum("ij,ij->i", away, away) <= (r + near + other.girth) ** 2
            if reach.any():
                lines = other.starts[reach], other.ways[reach]
                found.append(of_circles_and_lines(centre, own.axis, float(r), *lines))
    between = (a.centres[:, None, :] - b.centres[None, :, :]).reshape(-1, 3)
    if len(between):
        radii = np.array([(r1, r2) for r1 in a.radii for r2 in b.radii])
        reach = np.einsum("ij,ij->i", between, between) <= (radii.sum(axis=1) + near) ** 2
        if reach.any():
            found.append(along_circles(between[reach], radii[reach], a.axis, b.axis))
    return np.concatenate(found) if found else np.empty((0, 3))
