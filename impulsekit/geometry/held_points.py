"""Points at which two polyhedra touch, followed as the bodies move.

A corner stays on its body and moves over a plane of the other:

    g = n·(x − o),   n fixed in the body of the plane.

Two edges that cross touch where they are nearest. With e, f their directions, a ≈ b the
nearest points and w the velocity of the first body against the other there,

    n = ± e × f / |e × f|,   g = n·(a − b),   ġ = n·w,

and that place moves along the edges at σ' and τ' with w + σ' e − τ' f along n. The rows are
Rᵀ w with R = (e, n × e, n); their rates need ė = ω × e, ṅ from ė and ḟ, and the
accelerations of the material points with ω × e σ' of the way along the edge.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
import pinocchio as pin

from .axes import contact_axes, cross
from .features import CornerOnFace, EdgesCross, borders_of, inside
from .lines import nearest_of_lines
from .polyhedron import Polyhedron

__all__ = ["HeldCorner", "HeldCrossing", "HeldPoint", "held_point"]

# Edges that cross at a smaller angle (sine) than when they were taken hold of, by this part,
# have become parallel.
STILL_CROSS = 1e-3

Places = Sequence[pin.SE3]
Motions = Sequence[pin.Motion]


class HeldCorner:
    """A corner of one body on a face of the other.

    Args:
        bodies: both, in the frames of their joints.
        feature: which corner and face.
        kept: (9,) the axes t₁, t₂, n in the frame of the plane's body, row by row.
        pieces: the numbers of the two, of bodies that are several.

    Attributes:
        feature, kept, pieces: as given.
    """

    def __init__(
        self,
        bodies: tuple[Polyhedron, Polyhedron],
        feature: CornerOnFace,
        kept: Sequence[float],
        pieces: tuple[int, int] = (0, 0),
    ) -> None:
        self.feature, self.kept, self.pieces = feature, tuple(kept), pieces
        self._own, self._plane = feature.side, 1 - feature.side
        self._ground, self._face = bodies[self._plane], feature.face
        self._at = bodies[self._own].vertices[feature.corner]
        self._sign = 1.0 if feature.side == 0 else -1.0
        self._normal = self._ground.normals[self._face]
        self._height = float(self._ground.heights[self._face])
        self._axes = np.array(self.kept).reshape(3, 3)

    @classmethod
    def now(
        cls,
        bodies: tuple[Polyhedron, Polyhedron],
        feature: CornerOnFace,
        places: Places,
        pieces: tuple[int, int] = (0, 0),
    ) -> HeldCorner:
        """Taken hold of with the joints at ``places``."""
        plane = 1 - feature.side
        turn = places[plane].rotation
        normal = turn.dot(bodies[plane].normals[feature.face])
        axes = contact_axes(normal if feature.side == 0 else -normal)
        # Axes that turn with the plane.
        return cls(bodies, feature, turn.T.dot(axes).ravel().tolist(), pieces)

    def in_numbers(self) -> tuple[tuple[int, int], np.ndarray]:
        """Which body is whose, the point's and the plane's, and (16,) what a table says of it.

        The corner, the axes column by column and a point of the plane, each in the frame of its
        body's joint, and the sign of the rows.
        """
        on_plane = self._height * self._normal
        numbers = np.concatenate([self._at, self._axes.T.ravel(), on_plane, [self._sign]])
        return (self._own, self._plane), numbers

    def _over(self, places: Places) -> np.ndarray:
        """(3,) the corner in the axes of the plane's body."""
        return places[self._plane].actInv(places[self._own].act(self._at))

    def gap(self, places: Places) -> float:
        """[m]; negative inside."""
        return float(self._normal.dot(self._over(places))) - self._height

    def inside(self, places: Places) -> float:
        """How far the corner is inside the face [m], negative beside it."""
        return inside(self.borders, self._over(places))

    @cached_property
    def borders(self) -> np.ndarray:
        """``borders_of`` the face, in its body's frame."""
        return borders_of(self._ground, self._face)

    def place(self, places: Places) -> tuple[np.ndarray, np.ndarray]:
        """(3,) the point and (3, 3) its axes t₁, t₂, n."""
        return places[self._own].act(self._at), places[self._plane].rotation.dot(self._axes)

    def bias(self, places: Places, velocities: Motions, accelerations: Motions) -> np.ndarray:
        """(3,) the rates of the rows' velocities where no joint accelerates."""
        point, axes = self.place(places)
        (velocity, rate), (below, below_rate) = (
            point_motion(places[i], velocities[i], accelerations[i], point)
            for i in (self._own, self._plane)
        )
        turning = places[self._plane].rotation.dot(velocities[self._plane].angular)
        # The coinciding point moves over its body at the velocity between the two.
        rate = rate - below_rate - 2.0 * cross(turning, velocity - below)
        return self._sign * axes.T.dot(rate)


class HeldCrossing:
    """An edge of one body across an edge of the other.

    Args:
        bodies: both, in the frames of their joints.
        feature: which edges.
        kept: the sign of e × f against the normal, and the sine of the angle at which they cross
            below which they count as parallel.
        pieces: the numbers of the two, of bodies that are several.

    Attributes:
        feature, kept, pieces: as given.
    """

    def __init__(
        self,
        bodies: tuple[Polyhedron, Polyhedron],
        feature: EdgesCross,
        kept: Sequence[float],
        pieces: tuple[int, int] = (0, 0),
    ) -> None:
        self.feature, self.kept, self.pieces = feature, tuple(kept), pieces
        self._sign, self._least = self.kept
        self._ends = [
            body.vertices[list(edge)]
            for body, edge in zip(bodies, (feature.first, feature.other), strict=True)
        ]
        self._lengths = [float(np.linalg.norm(ends[1] - ends[0])) for ends in self._ends]
        self._ways = [
            (ends[1] - ends[0]) / length
            for ends, length in zip(self._ends, self._lengths, strict=True)
        ]

    @classmethod
    def now(
        cls,
        bodies: tuple[Polyhedron, Polyhedron],
        feature: EdgesCross,
        normal: np.ndarray,
        places: Places,
        pieces: tuple[int, int] = (0, 0),
    ) -> HeldCrossing:
        """Taken hold of with the joints at ``places``, (3,) normal from the second to the first."""
        e, f = cls(bodies, feature, (1.0, 0.0))._directions(places)
        turn = cross(e, f)
        sign = 1.0 if turn.dot(normal) >= 0.0 else -1.0
        least = STILL_CROSS * float(np.sqrt(turn.dot(turn)))
        return cls(bodies, feature, (sign, least), pieces)

    def _directions(self, places: Places) -> list[np.ndarray]:
        return [p.rotation.dot(way) for p, way in zip(places, self._ways, strict=True)]

    def in_numbers(self) -> np.ndarray:
        """(16,) what a table says of it.

        Of both edges an end and the direction, in the frame of the joint; both lengths, the sign
        of the normal, and the sine below which the edges are parallel.
        """
        edges = [part for pair in zip(self._ends, self._ways, strict=True) for part in pair]
        first, way, other, across = edges[0][0], edges[1], edges[2][0], edges[3]
        rest = [*self._lengths, self._sign, self._least]
        return np.concatenate([first, way, other, across, rest])

    def _met(self, places: Places) -> tuple[Any, ...]:
        """Directions, e × f with the sign of n, its square, the points, and the ways there."""
        e, f = self._directions(places)
        start, there = (place.act(ends[0]) for place, ends in zip(places, self._ends, strict=True))
        s, u, turn, square = nearest_of_lines(start, e, there, f)
        return e, f, self._sign * turn, square, start + s * e, there + u * f, s, u

    def gap(self, places: Places) -> float:
        """[m]; negative inside."""
        _, _, turn, square, here, there, _, _ = self._met(places)
        return float(turn.dot(here - there)) / float(np.sqrt(square))

    def inside(self, places: Places) -> float:
        """How far the crossing is from the ends of the edges [m], negative beyond them."""
        *_, square, _, _, s, u = self._met(places)
        if square < self._least**2:
            return -np.inf
        return min(s, self._lengths[0] - s, u, self._lengths[1] - u)

    def place(self, places: Places) -> tuple[np.ndarray, np.ndarray]:
        """(3,) the point and (3, 3) its axes t₁, t₂, n."""
        e, _, turn, square, here, there, _, _ = self._met(places)
        n = turn / np.sqrt(square)
        return 0.5 * (here + there), np.array([e, cross(n, e), n]).T

    def bias(self, places: Places, velocities: Motions, accelerations: Motions) -> np.ndarray:
        """(3,) the rates of the rows' velocities where no joint accelerates."""
        e, f, turn, square, here, there, _, _ = self._met(places)
        point, n = 0.5 * (here + there), turn / np.sqrt(square)
        spins = [place.rotation.dot(v.angular) for place, v in zip(places, velocities, strict=True)]
        (one, one_rate), (two, two_rate) = (
            point_motion(places[i], velocities[i], accelerations[i], point) for i in (0, 1)
        )
        w = one - two
        along = self._sign * float(cross(f, w).dot(turn)) / square
        along_other = self._sign * float(cross(e, w).dot(turn)) / square
        e_rate, f_rate = cross(spins[0], e), cross(spins[1], f)
        turn_rate = self._sign * (cross(e_rate, f) + cross(e, f_rate))
        n_rate = (turn_rate - n * n.dot(turn_rate)) / np.sqrt(square)
        rate = one_rate + along * e_rate - two_rate - along_other * f_rate
        across, across_rate = cross(n, e), cross(n_rate, e) + cross(n, e_rate)
        return np.array(
            [
                e.dot(rate) + e_rate.dot(w),
                across.dot(rate) + across_rate.dot(w),
                n.dot(rate) + n_rate.dot(w),
            ]
        )


HeldPoint = HeldCorner | HeldCrossing


def held_point(
    bodies: tuple[Polyhedron, Polyhedron],
    feature: CornerOnFace | EdgesCross,
    normal: np.ndarray,
    places: Places,
    pieces: tuple[int, int] = (0, 0),
) -> HeldPoint:
    """The point at which a feature touches, to be followed; arguments as above."""
    if isinstance(feature, CornerOnFace):
        return HeldCorner.now(bodies, feature, places, pieces)
    return HeldCrossing.now(bodies, feature, normal, places, pieces)


def point_motion(
    place: pin.SE3, v: pin.Motion, a: pin.Motion, point: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(3,) velocity and (3,) acceleration of a body's point; in the world, as ``point`` is."""
    at, spin = place.actInv(point), v.angular
    velocity = v.linear + cross(spin, at)
    rate = a.linear + cross(a.angular, at) + cross(spin, velocity)
    return place.rotation.dot(velocity), place.rotation.dot(rate)
