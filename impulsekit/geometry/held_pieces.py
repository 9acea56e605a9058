"""Which pieces of bodies touch at points that can be followed."""

from __future__ import annotations

from typing import TypeAlias

import coal
import pinocchio as pin

from .collision import Solid, Solids
from .convex import Convex, HalfSpace
from .ellipsoids import Ellipsoid, ellipsoid_of
from .polyhedron import Polyhedron, can_be_separated, endless_face

__all__ = [
    "Piece",
    "can_be_held",
    "have_ends",
    "have_features",
    "polyhedra_in_joint",
    "round_or_endless",
]

# A piece in the frame of its joint; None of one that has no closed form.
Piece: TypeAlias = Convex | Ellipsoid | Polyhedron | None


def can_be_held(one: Piece, two: Piece) -> bool:
    """Whether the points of two pieces can be followed: tips or corners on faces, or edges."""
    if one is None or two is None:
        return False
    if _is_endless(one) or _is_endless(two):
        return True
    if isinstance(one, Polyhedron) and isinstance(two, Polyhedron):
        return can_be_separated(one, two)
    return {type(one), type(two)} == {Convex, Polyhedron}


def have_ends(one: Piece, two: Piece) -> bool:
    """Whether two pieces may touch at several points, which lift each other in turn."""
    if isinstance(one, Polyhedron) and isinstance(two, Polyhedron):
        return True
    return any(
        isinstance(shape, Convex) and len(shape.points) + 2 * len(shape.radii) > 1
        for shape in (one, two)
    )


def have_features(one: Piece, two: Piece) -> bool:
    """Whether two pieces touch at corners and edges as ``features`` tells them."""
    return all(isinstance(shape, Polyhedron) and not shape.is_endless for shape in (one, two))


def _is_endless(shape: Piece) -> bool:
    """Whether a piece is a half-space."""
    return isinstance(shape, Polyhedron) and shape.is_endless


def round_or_endless(solid: Solid, placement: pin.SE3) -> Piece:
    """A round piece or a half-space in the frame of its joint."""
    shape = solid.convex
    if isinstance(solid.geometry, coal.Ellipsoid):
        return ellipsoid_of(solid.geometry, placement)
    if isinstance(shape, HalfSpace):
        return endless_face(shape.normal, shape.height).at(placement)
    if shape is None or shape.is_polyhedron:
        return None
    return shape.at(placement.rotation, placement.translation)


def polyhedra_in_joint(pieces: Solids) -> list[Polyhedron | None]:
    """The pieces of a body in the frame of its joint; None of those that are none."""
    return [
        None if solid.polyhedron is None else solid.polyhedron.at(placement)
        for solid, placement in pieces
    ]
