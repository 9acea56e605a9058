"""Where two polyhedra touch: corners on faces, and edges that cross.

Whatever two convex polyhedra share where they touch, a point, a line or a patch, has as its
ends corners of one that lie on a face of the other and crossings of an edge of each. Both
have a gap in closed form: n·(x − o) of a corner x over a face, and n·(p_a − p_b) of the
points at which two edges are nearest, along their cross product n.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ..laws.borrowed import borrowing
from ..laws.compiled import compiled, entry
from .lines import nearest
from .polyhedron import Hull, Polyhedron, places_about_second, separate
from .vectors import Vector, along, cross, dot, row_of

__all__ = [
    "BESIDE",
    "CornerOnFace",
    "EdgesCross",
    "FeaturePoint",
    "TipOnFace",
    "borders_of",
    "inside_of",
    "touch",
    "touching_at",
]

# Faces whose cosines to a direction differ by less face it alike.
ALIKE = 1e-6
# What is beside a face or shape, or beyond the end of an edge, by less than this [m] is on it.
BESIDE = 1e-6
# Points nearer to each other than this are one [m].
ONE_POINT = 3e-6
# Edges that cross at a smaller angle (sine) end no patch; alone they are a point all the same.
SINE = 1e-3
LEAST_SINE = 1e-10
# The least part of a margin, relative to the bodies' size.
ROUNDING = 1e-13
# Faces and crossings that look further away from the normal of all have no part in it (cosine).
FACES_NORMAL = 0.5


@dataclass(frozen=True)
class CornerOnFace:
    """A corner of one body on a face of the other.

    Attributes:
        side: whose corner it is, 0 for the first body.
        corner, face: their numbers.
    """

    side: int
    corner: int
    face: int


@dataclass(frozen=True)
class EdgesCross:
    """An edge of either body: the numbers of its two corners, from the first body's."""

    first: tuple[int, int]
    other: tuple[int, int]


@dataclass(frozen=True)
class TipOnFace:
    """A tip of one body on a face of the other.

    Attributes:
        side: whose tip it is, 0 for the first body.
        tip: its number among the points, then the circles, of the round body.
        face: the number of the face.
        rolls: whether it is where the body reaches furthest; False of a point fixed on the body.
    """

    side: int
    tip: int
    face: int
    rolls: bool


@dataclass(frozen=True, eq=False)
class FeaturePoint:
    """One point at which two polyhedra touch.

    Attributes:
        feature: what touches there.
        position: (3,) halfway between the surfaces.
        gap: [m], negative where they overlap.
    """

    feature: CornerOnFace | EdgesCross
    position: np.ndarray
    gap: float


class _Solid(NamedTuple):
    """The arrays of a ``Polyhedron`` that ``touch`` takes."""

    hull: Hull
    normals: np.ndarray
    heights: np.ndarray
    loops: np.ndarray
    starts: np.ndarray
    edges: np.ndarray

    @classmethod
    def of(cls, body: Polyhedron) -> _Solid:
        """Of a polyhedron."""
        return cls(Hull.of(body), body.normals, body.heights, *body.loops, body.edges)


class _Placed(NamedTuple):
    """A polyhedron somewhere, and (k,) which of its corners are near the other."""

    solid: _Solid
    vertices: np.ndarray
    normals: np.ndarray
    heights: np.ndarray
    near: np.ndarray


class _Found(NamedTuple):
    """Points that were found, so many of them.

    Attributes:
        many: (1,). features: (n, 5) 0, side, corner and face; or 1, and the corners at the ends
            of both edges. numbers: (n, 4) where, and the gap [m].
        least, most: gaps that count [m].
    """

    many: np.ndarray
    features: np.ndarray
    numbers: np.ndarray
    least: float
    most: float


def touching_at(
    a: Polyhedron, place_a: pin.SE3, b: Polyhedron, place_b: pin.SE3, margin: float
) -> tuple[np.ndarray, list[FeaturePoint]]:
    """Where two polyhedra are no further apart than ``margin`` [m].

    Returns:
        (3,) the normal from b to a, and the points, from an origin at the second one: the ends of
        the part of the surfaces that is within the margin of the other body, or inside it. One
        normal serves all of them and they lie in one plane: those of faces that are flat on each
        other but for the margin would make rows that depend on each other but for as little, and
        ask for what cannot be.
    """
    one, two = places_about_second(place_a, place_b)
    normal, features, numbers = touch(_Solid.of(a), one, _Solid.of(b), two, margin)
    found = []
    for (kind, i, j, k, m), (*at, gap) in zip(features.tolist(), numbers.tolist(), strict=True):
        feature = CornerOnFace(i, j, k) if kind == CORNER else EdgesCross((i, j), (k, m))
        found.append(FeaturePoint(feature, np.array(at), gap))
    return normal, found


# Kinds of features.
CORNER, CROSSING = 0, 1


def _examples() -> tuple[_Solid, np.ndarray, _Solid, np.ndarray, float]:
    none, no, whole = np.zeros(0), np.zeros((0, 3)), np.zeros(0, np.int64)
    solid = _Solid(Hull(no, no, no), no, none, whole, whole, np.zeros((0, 2), np.int64))
    return solid, np.zeros((4, 3)), solid, np.zeros((4, 3)), 0.0


@entry(_examples, seconds=5.0)
def touch(
    a: _Solid, place_a: np.ndarray, b: _Solid, place_b: np.ndarray, margin: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """``touching_at``: the normal (3,), features (n, 5) and numbers (n, 4) of ``_Found``.

    Args:
        a, b: both. place_a, place_b: (4, 3) Rᵀ and the origin.
        margin: as there.
    """
    gap, x, y, z = separate(a.hull, place_a, b.hull, place_b)
    normal, n = np.array((x, y, z)), (x, y, z)
    if gap > margin:
        return normal, np.zeros((0, 5), np.int64), np.zeros((0, 4))
    one, lowest, size = _place(a, place_a, n, -1.0)
    two, highest, other = _place(b, place_b, n, 1.0)
    rounding = ROUNDING * max(size, other)
    # Of each body what touches is in the half that looks to the other.
    for placed, level, sign, thick in ((one, lowest, 1.0, size), (two, highest, -1.0, other)):
        near = min(margin - gap, 0.5 * thick) + rounding
        for i in range(len(placed.vertices)):
            placed.near[i] = sign * (dot(row_of(placed.vertices, i), n) - level) <= near
    most = len(one.vertices) + len(two.vertices) + _edges_near(one) * _edges_near(two)
    found = _Found(
        np.zeros(1, np.int64), np.zeros((most, 5), np.int64), np.zeros((most, 4)),
        gap - margin - rounding, margin,
    )  # fmt: skip
    _take_corners(found, 0, one, two, n)
    _take_corners(found, 1, two, one, (-x, -y, -z))
    _take_crossings(found, one, two, n, SINE)
    if found.many[0] == 0:
        _take_crossings(found, one, two, n, 0.0)
    count, level = found.many[0], 0.5 * (lowest + highest)
    for i in range(count):
        at = row_of(found.numbers, i)
        at = along(at, level - dot(at, n), n)
        found.numbers[i, 0], found.numbers[i, 1], found.numbers[i, 2] = at
    return normal, found.features[:count].copy(), found.numbers[:count].copy()


@compiled
def _place(
    solid: _Solid, place: np.ndarray, n: Vector, sign: float
) -> tuple[_Placed, float, float]:
    """A polyhedron at a place, how far it reaches along ±n [m], and how thick it is there [m]."""
    vertices = solid.hull.vertices.dot(place[:3]) + place[3]
    normals = solid.normals.dot(place[:3])
    heights = solid.heights + normals.dot(place[3])
    highest, lowest = -math.inf, math.inf
    for i in range(len(vertices)):
        height = dot(row_of(vertices, i), n)
        highest, lowest = max(highest, height), min(lowest, height)
    near = np.zeros(len(vertices), np.bool_)
    placed = _Placed(solid, vertices, normals, heights, near)
    return placed, highest if sign > 0.0 else lowest, highest - lowest


@borrowing
def _edges_near(body: _Placed) -> int:
    """How many edges have both ends near the other body."""
    count = 0
    for i in range(len(body.solid.edges)):
        count += body.near[body.solid.edges[i, 0]] and body.near[body.solid.edges[i, 1]]
    return count


@borrowing
def _take(found: _Found, at: Vector, gap: float, feature: tuple[int, int, int, int, int]) -> None:
    """Add a point whose gap counts, and that is not there yet."""
    n = found.many[0]
    if not found.least <= gap <= found.most:
        return
    for i in range(n):
        away = along(at, -1.0, row_of(found.numbers, i))
        if max(abs(away[0]), abs(away[1]), abs(away[2])) <= ONE_POINT:
            return
    for k in range(5):
        found.features[n, k] = feature[k]
    found.numbers[n, 0], found.numbers[n, 1], found.numbers[n, 2] = at
    found.numbers[n, 3] = gap
    found.many[0] += 1


@compiled
def _take_corners(found: _Found, side: int, own: _Placed, ground: _Placed, towards: Vector) -> None:
    """Take the corners of a body on faces of the other that look ``towards`` it."""
    best = -math.inf
    for face in range(len(ground.normals)):
        best = max(best, dot(row_of(ground.normals, face), towards))
    least = max(FACES_NORMAL, best - ALIKE)
    starts, loops = ground.solid.starts, ground.solid.loops
    for corner in range(len(own.vertices)):
        if not own.near[corner]:
            continue
        at, over, face = row_of(own.vertices, corner), -math.inf, -1
        for k in range(len(ground.normals)):
            normal = row_of(ground.normals, k)
            if dot(normal, towards) > least:
                above = dot(normal, at) - ground.heights[k]
                if above > over:
                    over, face = above, k
        if face < 0:
            continue
        normal = row_of(ground.normals, face)
        borders = np.empty((starts[face + 1] - starts[face], 6))
        _write_borders(ground.vertices, loops, starts[face], normal, borders)
        if inside_of(borders, 0, len(borders), at) < -BESIDE:
            continue
        _take(found, along(at, -0.5 * over, normal), over, (CORNER, side, corner, face, 0))


@borrowing
def _take_crossings(found: _Found, a: _Placed, b: _Placed, normal: Vector, least: float) -> None:
    """Take points where edges cross at more than an angle (sine)."""
    for one in range(len(a.solid.edges)):
        i, j = a.solid.edges[one, 0], a.solid.edges[one, 1]
        if not (a.near[i] and a.near[j]):
            continue
        start = row_of(a.vertices, i)
        way, length = _unit(along(row_of(a.vertices, j), -1.0, start))
        for two in range(len(b.solid.edges)):
            k, m = b.solid.edges[two, 0], b.solid.edges[two, 1]
            if not (b.near[k] and b.near[m]):
                continue
            there = row_of(b.vertices, k)
            across, reach = _unit(along(row_of(b.vertices, m), -1.0, there))
            turn = cross(way, across)
            sine = math.sqrt(dot(turn, turn))
            if sine < LEAST_SINE or sine <= least:
                continue
            facing = dot(turn, normal) / sine
            if abs(facing) < FACES_NORMAL:
                continue
            s, u, _, _ = nearest(start, way, there, across)
            if min(min(s, length - s), min(u, reach - u)) < -BESIDE:
                continue
            here, below = along(start, s, way), along(there, u, across)
            sign = 1.0 if facing >= 0.0 else -1.0
            gap = sign * dot(turn, along(here, -1.0, below)) / sine
            middle = along(here, 0.5, along(below, -1.0, here))
            _take(found, middle, gap, (CROSSING, i, j, k, m))


@borrowing
def _unit(way: Vector) -> tuple[Vector, float]:
    """A direction, and how long it is."""
    length = math.sqrt(dot(way, way))
    return (way[0] / length, way[1] / length, way[2] / length), length


@borrowing
def inside_of(borders: np.ndarray, first: int, last: int, point: Vector) -> float:
    """How far a point of a face's plane is inside its boundary [m], negative outside.

    From some of many borders (b, 6), see ``borders_of``; infinite where these are none.
    """
    least = math.inf
    for k in range(first, last):
        corner = borders[k, 3], borders[k, 4], borders[k, 5]
        least = min(least, dot(row_of(borders, k), along(point, -1.0, corner)))
    return least


def borders_of(body: Polyhedron, face: int) -> np.ndarray:
    """By edge of a face, (k, 6) the direction inwards, in its plane, and a corner [m]."""
    loop = body.faces[face]
    borders = np.empty((len(loop), 6))
    _write_borders(body.vertices, loop, 0, body.normals[face].tolist(), borders)
    return borders


@borrowing
def _write_borders(
    vertices: np.ndarray, loops: np.ndarray, start: int, normal: Vector, borders: np.ndarray
) -> None:
    """Write ``borders_of`` a face whose corners stand in ``loops`` from ``start`` on."""
    count = len(borders)
    for k in range(count):
        corner = row_of(vertices, loops[start + k])
        way, _ = _unit(along(row_of(vertices, loops[start + (k + 1) % count]), -1.0, corner))
        borders[k, 0], borders[k, 1], borders[k, 2] = cross(normal, way)
        borders[k, 3], borders[k, 4], borders[k, 5] = corner
