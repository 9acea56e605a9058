"""Convex shapes as hulls of points and circles with a radius around them.

    ball      a point                       radius
    capsule   two points                    radius
    cylinder  two circles on one axis
    cone      a point and a circle
    polyhedron  its corners

The support function of all of them is

    h(d) = max(maxᵢ d·pᵢ, maxⱼ d·cⱼ + rⱼ |d × a|) + radius,

d a unit vector, p the points, c, r and a the middles, radii and axis of the circles.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import coal
import numpy as np

from .polyhedron import Polyhedron

__all__ = ["Convex", "HalfSpace", "convex_of"]

# Heights that differ by less than this share of the highest are equal.
LEVEL = 1e-12
# Heights below this count as this [m]: what was added up for them is not smaller.
SMALLEST = 1e-3
_NONE = np.empty((0, 3))
_X, _Z = np.eye(3)[[0, 2]]


@dataclass(frozen=True, eq=False)
class Convex:
    """A convex shape somewhere.

    Attributes:
        points: (p, 3) [m].
        centres, radii: (c, 3), (c,) of its circles [m].
        axis: (3,) of all its circles.
        across: (3,) across the axis, fixed in the shape: where points of a rim are told from
            that nothing else tells.
        radius: how far it reaches around the hull [m].
        normals, heights: (f, 3), (f,) of its faces, outwards, and n·x on each [m].
        starts, ways: (l, 3) its edges, and the axes of its sides, as lines [m], unit vectors.
        slant: of a cone the share of its axis in the normal of its side, else None.
        is_polyhedron: whether faces are all that bounds it.
    """

    points: np.ndarray
    centres: np.ndarray
    radii: np.ndarray
    axis: np.ndarray
    across: np.ndarray
    radius: float
    normals: np.ndarray
    heights: np.ndarray
    starts: np.ndarray
    ways: np.ndarray
    slant: float | None = None
    is_polyhedron: bool = False

    def at(self, turn: np.ndarray, shift: np.ndarray) -> Convex:
        """The same one turned by (3, 3) and shifted by (3,)."""
        back = turn.T
        normals = self.normals.dot(back)
        return Convex(
            self.points.dot(back) + shift,
            self.centres.dot(back) + shift,
            self.radii,
            turn.dot(self.axis),
            turn.dot(self.across),
            self.radius,
            normals,
            self.heights + normals.dot(shift),
            self.starts.dot(back) + shift,
            self.ways.dot(back),
            self.slant,
            self.is_polyhedron,
        )

    def shrunk(self, factor: float) -> Convex:
        """The same one, smaller by a factor about its middle."""
        ends = np.concatenate((self.points, self.centres))
        rest = (1.0 - factor) * ends.mean(axis=0)
        return replace(
            self,
            points=factor * self.points + rest,
            centres=factor * self.centres + rest,
            radii=factor * self.radii,
            radius=factor * self.radius,
            heights=factor * self.heights + self.normals.dot(rest),
            starts=factor * self.starts + rest,
        )

    @property
    def girth(self) -> float:
        """How far its surface is at most from its lines [m]."""
        return self.radius + float(self.radii.max(initial=0.0))

    def support(self, directions: np.ndarray) -> np.ndarray:
        """(k,) how far the shape reaches along (k, 3) unit vectors [m]."""
        reach = np.full(len(directions), -np.inf)
        if len(self.points):
            reach = directions.dot(self.points.T).max(axis=1)
        if len(self.centres):
            out = directions - np.outer(directions.dot(self.axis), self.axis)
            sine = np.sqrt(np.einsum("ij,ij->i", out, out))
            around = directions.dot(self.centres.T) + sine[:, None] * self.radii
            reach = np.maximum(reach, around.max(axis=1))
        return reach + self.radius

    def has(self, point: np.ndarray) -> bool:
        """Whether a point is known to lie in the shape; of round ones it may, and False."""
        if not len(self.normals) or self.slant is not None:
            return False
        if float((self.normals.dot(point) - self.heights).max()) > INSIDE:
            return False
        if self.is_polyhedron:
            return True
        out = point - self.centres[0]
        out = out - out.dot(self.axis) * self.axis
        return float(np.sqrt(out.dot(out))) <= float(self.radii[0])

    def farthest(self, direction: np.ndarray) -> np.ndarray:
        """(3,) the point that reaches furthest along a unit vector, of several one amid them."""
        found: list[tuple[float, np.ndarray]] = [(float(p.dot(direction)), p) for p in self.points]
        if len(self.centres):
            out = direction - direction.dot(self.axis) * self.axis
            sine = float(np.sqrt(out.dot(out)))
            out = out / sine if sine > _FLAT else np.zeros(3)
            for centre, r in zip(self.centres, self.radii, strict=True):
                found.append((float(centre.dot(direction)) + r * sine, centre + r * out))
        top = max(height for height, _ in found)
        size = LEVEL * max(SMALLEST, abs(top))
        best = [p for height, p in found if height >= top - size]
        return np.mean(best, axis=0) + self.radius * direction


# A point within this [m] of a face is on it.
INSIDE = 1e-13
# Faces as flat as this (sine) against a direction have no point that reaches further.
_FLAT = 1e-12


@dataclass(frozen=True, eq=False)
class HalfSpace:
    """All below a plane: normal (3,) outwards, and n·x on the plane [m]."""

    normal: np.ndarray
    height: float


def convex_of(
    shape: coal.CollisionGeometry, polyhedron: Polyhedron | None
) -> Convex | HalfSpace | None:
    """The shape in its own frame; None for what is no hull of points and circles."""
    none = np.empty(0)
    if isinstance(shape, coal.Halfspace):
        thick = float(shape.getSweptSphereRadius())
        return HalfSpace(np.array(shape.n).reshape(3), float(shape.d) + thick)
    if polyhedron is not None:
        starts = polyhedron.vertices[polyhedron.edges[:, 0]]
        ways = polyhedron.vertices[polyhedron.edges[:, 1]] - starts
        ways = ways / np.linalg.norm(ways, axis=1)[:, None]
        faces = polyhedron.normals
        points, heights = polyhedron.vertices, polyhedron.heights
        across = ways[0]
        return Convex(
            points, _NONE, none, _Z, across, 0.0, faces, heights, starts, ways, None, True
        )
    radius = float(shape.getSweptSphereRadius())
    line = np.zeros((1, 3)), _Z[None, :]
    if isinstance(shape, coal.Sphere):
        radius += shape.radius
        return Convex(np.zeros((1, 3)), _NONE, none, _Z, _X, radius, _NONE, none, _NONE, _NONE)
    if isinstance(shape, coal.Capsule):
        ends = np.outer((-shape.halfLength, shape.halfLength), _Z)
        return Convex(ends, _NONE, none, _Z, _X, radius + shape.radius, _NONE, none, *line)
    if radius > 0.0 or not isinstance(shape, coal.Cylinder | coal.Cone):
        return None
    half, r = float(shape.halfLength), float(shape.radius)
    if isinstance(shape, coal.Cylinder):
        rims = np.outer((-half, half), _Z)
        faces = np.array((-_Z, _Z))
        radii, heights = np.array((r, r)), np.array((half, half))
        return Convex(_NONE, rims, radii, _Z, _X, 0.0, faces, heights, *line)
    slant = r / float(np.hypot(r, 2.0 * half))
    apex, base = np.array([half * _Z]), np.array([-half * _Z])
    radii, down, heights = np.array((r,)), np.array([-_Z]), np.array((half,))
    return Convex(apex, base, radii, _Z, _X, 0.0, down, heights, *line, slant)
