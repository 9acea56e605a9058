"""Collision geometry as the core's shapes."""

from __future__ import annotations

from typing import Any

import coal
import numpy as np
import pinocchio as pin

from .._core import (
    Shape,
    ball_shape,
    box_shape,
    capsule_shape,
    cone_shape,
    cylinder_shape,
    ellipsoid_shape,
    half_space_shape,
    polytope_shape,
)
from ..errors import InputError
from .axes import place_numbers
from .collision import Solid, Solids
from .polyhedron import hull_of

__all__ = ["core_shape", "core_shapes"]


def core_shapes(pieces: Solids) -> list[Shape]:
    """The pieces of a body as shapes in the axes of its joint."""
    return [core_shape(solid, placement) for solid, placement in pieces]


def core_shape(solid: Solid, placement: pin.SE3) -> Shape:
    """A piece at its placement in its joint.

    Raises:
        InputError: what is no convex body.
    """
    shape: Any = solid.geometry
    at = place_numbers(placement)
    around = float(shape.getSweptSphereRadius())
    if isinstance(shape, coal.Sphere):
        return ball_shape(float(shape.radius) + around, at)
    if isinstance(shape, coal.Capsule):
        return capsule_shape(float(shape.radius) + around, float(shape.halfLength), at)
    if isinstance(shape, coal.Cylinder):
        return cylinder_shape(float(shape.radius), float(shape.halfLength), around, at)
    if isinstance(shape, coal.Cone):
        return cone_shape(float(shape.radius), float(shape.halfLength), around, at)
    if isinstance(shape, coal.Box):
        return box_shape(np.array(shape.halfSide).ravel(), around, at)
    if isinstance(shape, coal.Ellipsoid):
        return ellipsoid_shape(np.array(shape.radii).ravel(), around, at)
    if isinstance(shape, coal.Halfspace):
        return half_space_shape(np.array(shape.n).ravel(), float(shape.d) + around, at)
    if isinstance(shape, coal.ConvexBase):
        points = np.array([shape.point(i) for i in range(shape.num_points)])
        hull = solid.polyhedron or hull_of(points)
        if hull is None:
            return polytope_shape(points.ravel(), _both_sides(points), around, at)
        loops = [loop.tolist() for loop in hull.faces]
        return polytope_shape(hull.vertices.ravel(), loops, around, at)
    raise InputError(f"Collision: a geometry of kind {type(shape).__name__} is no convex body")


def _both_sides(points: np.ndarray) -> list[list[int]]:
    """The corners of a flat hull in turn, seen from either side."""
    from scipy.spatial import ConvexHull, QhullError

    arms = points - points.mean(axis=0)
    try:
        loop = ConvexHull(arms @ np.linalg.svd(arms)[2][:2].T).vertices.tolist()
    except (QhullError, ValueError):
        raise InputError("Collision: a hull has no area") from None
    return [loop, loop[::-1]]
