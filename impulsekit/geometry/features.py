"""Where two polyhedra touch: corners on faces, and edges that cross.

Whatever two convex polyhedra share where they touch, a point, a line or a patch, has as its
ends corners of one that lie on a face of the other and crossings of an edge of each. Both
have a gap in closed form: n·(x − o) of a corner x over a face, and n·(p_a − p_b) of the
points at which two edges are nearest, along their cross product n.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from .axes import cross
from .lines import nearest_of_lines
from .polyhedron import Polyhedron, separation

__all__ = [
    "BESIDE",
    "CornerOnFace",
    "EdgesCross",
    "FeaturePoint",
    "beside",
    "borders_of",
    "inside",
    "touching_features",
]

# Faces whose cosines to a direction differ by less face it alike.
ALIKE = 1e-6
# A corner beside a face, or a crossing beyond the end of an edge, by less than this [m] is on it.
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


def touching_features(
    a: Polyhedron, b: Polyhedron, margin: float
) -> tuple[np.ndarray, list[FeaturePoint]]:
    """Where two polyhedra are no further apart than ``margin`` [m].

    Returns:
        (3,) the normal from b to a, and the points: the ends of the part of the surfaces that
        is within the margin of where they touch first. One normal serves all of them and they
        lie in one plane: those of faces that are flat on each other but for 1e-6 m would make
        rows that depend on each other but for as little, and ask for what cannot be.
    """
    gap, normal = separation(a, b)
    if gap > margin:
        return normal, []
    along_a, along_b = a.vertices.dot(normal), b.vertices.dot(normal)
    size = max(float(np.ptp(along_a)), float(np.ptp(along_b)))
    near = margin + ROUNDING * size
    on_a = np.flatnonzero(along_a <= along_a.min() + near)
    on_b = np.flatnonzero(along_b >= along_b.max() - near)
    found: list[FeaturePoint] = []
    for side, corners in ((0, on_a), (1, on_b)):
        own, ground = (a, b) if side == 0 else (b, a)
        towards = normal if side == 0 else -normal
        for point in _corners_on_faces(side, own, corners, ground, towards):
            _take(found, point, gap - near, margin)
    crossings = list(_crossings(a, on_a, b, on_b, normal))
    for sine, point in crossings:
        if sine > SINE:
            _take(found, point, gap - near, margin)
    if not found:
        for _, point in crossings:
            _take(found, point, gap - near, margin)
    level = 0.5 * float(along_a.min() + along_b.max())
    return normal, [
        replace(p, position=p.position + (level - p.position.dot(normal)) * normal) for p in found
    ]


def beside(body: Polyhedron, face: int, point: np.ndarray) -> float:
    """How far a point of a face's plane is inside its boundary [m], negative outside."""
    return inside(borders_of(body, face), point)


def inside(borders: tuple[np.ndarray, np.ndarray], point: np.ndarray) -> float:
    """``beside`` of a point (3,), from the ``borders_of`` a face."""
    inwards, corners = borders
    return float(np.einsum("ij,ij->i", inwards, point - corners).min())


def borders_of(body: Polyhedron, face: int) -> tuple[np.ndarray, np.ndarray]:
    """By edge of a face, (k, 3) the direction inwards, in its plane, and (k, 3) a corner [m]."""
    corners = body.vertices[body.faces[face]]
    ways = np.concatenate([corners[1:], corners[:1]]) - corners
    ways /= np.sqrt(np.einsum("ij,ij->i", ways, ways))[:, None]
    # n × way points inwards.
    x, y, z = body.normals[face].tolist()
    return ways.dot(np.array(((0.0, z, -y), (-z, 0.0, x), (y, -x, 0.0)))), corners


def _take(found: list[FeaturePoint], point: FeaturePoint, least: float, most: float) -> None:
    """Add a point whose gap is between the two [m], and that is not there yet."""
    if least <= point.gap <= most and all(
        np.abs(point.position - known.position).max() > ONE_POINT for known in found
    ):
        found.append(point)


def _corners_on_faces(
    side: int, own: Polyhedron, corners: np.ndarray, ground: Polyhedron, towards: np.ndarray
) -> Iterator[FeaturePoint]:
    looks = ground.normals.dot(towards)
    facing = np.flatnonzero(looks > max(FACES_NORMAL, float(looks.max()) - ALIKE))
    if not facing.size:
        return
    for corner in corners.tolist():
        at = own.vertices[corner]
        over = ground.normals[facing].dot(at) - ground.heights[facing]
        face = int(facing[over.argmax()])
        if beside(ground, face, at) < -BESIDE:
            continue
        normal, gap = ground.normals[face], float(over.max())
        middle = at - 0.5 * gap * normal
        yield FeaturePoint(CornerOnFace(side, corner, face), middle, gap)


def _crossings(
    a: Polyhedron, on_a: np.ndarray, b: Polyhedron, on_b: np.ndarray, normal: np.ndarray
) -> Iterator[tuple[float, FeaturePoint]]:
    """Points where edges cross, with the sine of the angle between them."""
    own = a.edges[np.isin(a.edges, on_a).all(axis=1)]
    others = b.edges[np.isin(b.edges, on_b).all(axis=1)]
    for i, j in own.tolist():
        start = a.vertices[i]
        way = a.vertices[j] - start
        length = float(np.sqrt(way.dot(way)))
        way = way / length
        for k, m in others.tolist():
            there = b.vertices[k]
            across = b.vertices[m] - there
            reach = float(np.sqrt(across.dot(across)))
            across = across / reach
            turn = cross(way, across)
            sine = float(np.sqrt(turn.dot(turn)))
            if sine < LEAST_SINE:
                continue
            n = turn / sine
            n = n if n.dot(normal) >= 0.0 else -n
            if n.dot(normal) < FACES_NORMAL:
                continue
            s, u, _, _ = nearest_of_lines(start, way, there, across)
            if min(s, length - s, u, reach - u) < -BESIDE:
                continue
            here, below = start + s * way, there + u * across
            gap = float(n.dot(here - below))
            yield sine, FeaturePoint(EdgesCross((i, j), (k, m)), 0.5 * (here + below), gap)
