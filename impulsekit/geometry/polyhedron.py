"""Convex bodies with flat faces: corners, edges and faces, and how far two of them are apart.

Two convex polyhedra are apart if and only if some face normal of one of them, or some cross
product of an edge of each, separates them (the separating axis theorem; Ericson, Real-Time
Collision Detection, 2005, ch. 5). The largest separation along these axes is their distance
where that is between a corner and a face or between two edges, a lower bound of it elsewhere,
and minus the depth of their overlap. It comes to rounding, as coal's distance does not.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import coal
import numpy as np
import pinocchio as pin

from ..laws.borrowed import borrowed, borrowing
from ..laws.compiled import entry
from .vectors import Vector, cross, dot, row_of

__all__ = [
    "Polyhedron",
    "can_be_separated",
    "endless_face",
    "hull_of",
    "places_about_second",
    "polyhedron_of",
    "separate",
    "separation_at",
]

# Facets of a hull whose normals differ by less belong to one face.
SAME_FACE = 1e-9
# Edges closer to parallel than this have no cross product.
PARALLEL = 1e-12
# A face's normal is taken where an axis of edges separates by no more than this beyond it [m].
AS_GOOD = 1e-12
# So many products are the most that are worked out for one distance.
MOST_PRODUCTS = 2_000_000


@dataclass(frozen=True, eq=False)
class Polyhedron:
    """A convex polyhedron somewhere.

    Attributes:
        vertices: (k, 3) its corners [m].
        normals: (f, 3) of its faces, outwards.
        heights: (f,) n·x on each face [m].
        directions: (d, 3) of its edges, each up to its sign once.
        axes: (a, 3) of its faces' normals, likewise.
        faces: by face, its corners in turn, seen from outside against the clock.
        edges: (e, 2) the corners at the ends of its edges.
    """

    vertices: np.ndarray
    normals: np.ndarray
    heights: np.ndarray
    directions: np.ndarray
    axes: np.ndarray
    faces: tuple[np.ndarray, ...]
    edges: np.ndarray

    @property
    def is_endless(self) -> bool:
        """Whether it is an ``endless_face``."""
        return not len(self.vertices)

    @cached_property
    def loops(self) -> tuple[np.ndarray, np.ndarray]:
        """(l,) the corners of all faces, one after the other, and (f + 1,) where each begins."""
        counts = [len(loop) for loop in self.faces]
        return np.concatenate(self.faces), np.concatenate(([0], np.cumsum(counts)))

    def at(self, place: pin.SE3) -> Polyhedron:
        """The same one, moved."""
        turn = place.rotation.T
        vertices = self.vertices.dot(turn) + place.translation
        normals = self.normals.dot(turn)
        heights = self.heights + normals.dot(place.translation)
        directions, axes = self.directions.dot(turn), self.axes.dot(turn)
        return Polyhedron(vertices, normals, heights, directions, axes, self.faces, self.edges)


def polyhedron_of(shape: coal.CollisionGeometry) -> Polyhedron | None:
    """The polyhedron that a shape is, in its own frame; None for what is curved or flat."""
    if not isinstance(shape, coal.Box | coal.ConvexBase) or shape.getSweptSphereRadius() > 0.0:
        return None
    if isinstance(shape, coal.Box):
        return _box(np.array(shape.halfSide).reshape(3))
    return hull_of(np.array([shape.point(i) for i in range(shape.num_points)]))


def endless_face(normal: np.ndarray, height: float) -> Polyhedron:
    """The face of a half-space: without corners and borders.

    Args:
        normal: (3,) outwards. height: n·x on it [m].
    """
    none, own = np.zeros((0, 3)), normal[None, :]
    loop, no_edges = np.zeros(0, dtype=int), np.zeros((0, 2), dtype=int)
    return Polyhedron(none, own, np.array([height]), none, own, (loop,), no_edges)


def can_be_separated(a: Polyhedron, b: Polyhedron) -> bool:
    """Whether they are simple enough for ``separation_at``."""
    count = len(a.directions) * len(b.directions) + len(a.axes) + len(b.axes)
    return count * (len(a.vertices) + len(b.vertices)) <= MOST_PRODUCTS


def separation_at(
    a: Polyhedron, place_a: pin.SE3, b: Polyhedron, place_b: pin.SE3
) -> tuple[float, np.ndarray]:
    """The gap of two polyhedra [m], and its normal (3,) from b to a.

    The gap is negative by the depth where they overlap, and no larger than their distance
    where they are apart. It is worked out about an origin at the second one.
    """
    places = places_about_second(place_a, place_b)
    gap, *normal = separate(Hull.of(a), places[0], Hull.of(b), places[1])
    return float(gap), np.array(normal)


def places_about_second(place_a: pin.SE3, place_b: pin.SE3) -> np.ndarray:
    """(2, 4, 3) Rᵀ and the origin of both, about that of the second [m]."""
    places = np.zeros((2, 4, 3))
    places[0, :3], places[1, :3] = place_a.rotation.T, place_b.rotation.T
    places[0, 3] = place_a.translation - place_b.translation
    return places


class Hull(NamedTuple):
    """The arrays of a ``Polyhedron`` that ``separate`` takes."""

    vertices: np.ndarray
    axes: np.ndarray
    directions: np.ndarray

    @classmethod
    def of(cls, body: Polyhedron) -> Hull:
        """Of a polyhedron."""
        return cls(body.vertices, body.axes, body.directions)


def _examples() -> tuple[Hull, np.ndarray, Hull, np.ndarray]:
    hull = Hull(*np.zeros((3, 2, 3)))
    return hull, np.zeros((4, 3)), hull, np.zeros((4, 3))


@borrowing
def _between(one: np.ndarray, two: np.ndarray, axis: Vector) -> tuple[float, float]:
    """How far apart corners are along an axis: the first above the others, and below."""
    low_one, high_one = _span(one, axis)
    low_two, high_two = _span(two, axis)
    return low_one - high_two, low_two - high_one


@borrowing
def _span(corners: np.ndarray, axis: Vector) -> tuple[float, float]:
    """From where to where corners reach along an axis."""
    low, high = math.inf, -math.inf
    for i in range(len(corners)):
        height = dot(row_of(corners, i), axis)
        low, high = min(low, height), max(high, height)
    return low, high


@entry(_examples, seconds=2.0)
def separate(
    a: Hull, place_a: np.ndarray, b: Hull, place_b: np.ndarray
) -> tuple[float, float, float, float]:
    """``separation_at`` of two polyhedra at places (4, 3), Rᵀ and the origin: gap and normal."""
    a, place_a, b, place_b = borrowed(a), borrowed(place_a), borrowed(b), borrowed(place_b)
    one, two = a.vertices.dot(place_a[:3]) + place_a[3], b.vertices.dot(place_b[:3]) + place_b[3]
    if not abs(one.sum() + two.sum()) < math.inf:
        # NaN has to reach the result.
        return math.nan, math.nan, math.nan, math.nan
    best, found, sign = -math.inf, (0.0, 0.0, 0.0), 1.0
    for hull, place in ((a, place_a), (b, place_b)):
        axes = hull.axes.dot(place[:3])
        for k in range(len(axes)):
            axis = row_of(axes, k)
            above, below = _between(one, two, axis)
            if max(above, below) > best:
                best, found, sign = max(above, below), axis, 1.0 if above >= below else -1.0
    gap, of_edges = best, -math.inf
    first, second = a.directions.dot(place_a[:3]), b.directions.dot(place_b[:3])
    for i in range(len(first)):
        for j in range(len(second)):
            x, y, z = cross(row_of(first, i), row_of(second, j))
            size = math.sqrt(x * x + y * y + z * z)
            if not size > PARALLEL:
                continue
            axis = (x / size, y / size, z / size)
            above, below = _between(one, two, axis)
            if max(above, below) > of_edges:
                of_edges = max(above, below)
                gap = max(gap, of_edges)
                if of_edges > best + AS_GOOD:
                    found, sign = axis, 1.0 if above >= below else -1.0
    return gap, sign * found[0], sign * found[1], sign * found[2]


def _box(half: np.ndarray) -> Polyhedron:
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    loops = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    normals = np.array([s * axis for axis in np.eye(3) for s in (-1.0, 1.0)])
    return _of_faces(signs * half, normals, tuple(np.array(loop) for loop in loops))


def hull_of(points: np.ndarray) -> Polyhedron | None:
    """The convex hull of points; None where it is flat."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):
        return None
    normals = np.empty((len(hull.equations), 3))
    members: list[set[int]] = []
    for equation, corners in zip(hull.equations, hull.simplices, strict=True):
        normal, count = equation[:3], len(members)
        same = np.flatnonzero(np.abs(normals[:count] - normal).max(axis=1) < SAME_FACE)
        if len(same):
            members[int(same[0])].update(corners.tolist())
        else:
            normals[count] = normal
            members.append(set(corners.tolist()))
    normals = normals[: len(members)].copy()
    of_hull = np.array(sorted(set().union(*members)))
    number = {int(old): new for new, old in enumerate(of_hull)}
    vertices = points[of_hull]
    loops = [
        _in_turn(vertices, normal, np.array(sorted(number[i] for i in corners)))
        for normal, corners in zip(normals, members, strict=True)
    ]
    return _of_faces(vertices, normals, tuple(loops))


def _in_turn(vertices: np.ndarray, normal: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """The corners of a face against the clock."""
    arms = vertices[corners] - vertices[corners].mean(axis=0)
    first = arms[0] / np.linalg.norm(arms[0])
    angles = np.arctan2(arms.dot(np.cross(normal, first)), arms.dot(first))
    return corners[np.argsort(angles)]


def _of_faces(
    vertices: np.ndarray, normals: np.ndarray, faces: tuple[np.ndarray, ...]
) -> Polyhedron:
    middles = np.array([vertices[loop].mean(axis=0) for loop in faces])
    heights = np.einsum("ij,ij->i", normals, middles)
    pairs = {
        tuple(sorted((int(i), int(j))))
        for loop in faces
        for i, j in zip(loop, np.roll(loop, -1), strict=True)
    }
    edges = np.array(sorted(pairs))
    ways = vertices[edges[:, 1]] - vertices[edges[:, 0]]
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    return Polyhedron(vertices, normals, heights, _lines(ways), _lines(normals), faces, edges)


def _lines(vectors: np.ndarray) -> np.ndarray:
    """Unit vectors, each up to its sign once."""
    found, count = np.empty_like(vectors), 0
    for vector in vectors:
        known = found[:count]
        alike = np.abs(known - vector).max(axis=1) < SAME_FACE
        if not (alike | (np.abs(known + vector).max(axis=1) < SAME_FACE)).any():
            found[count] = vector
            count += 1
    return found[:count].copy()
