"""Collision geometry as the core's shapes."""

from __future__ import annotations

from typing import Any

import coal
import numpy as np
import pinocchio as pin

from .. import _core
from .axes import place_numbers
from .collision import Solid, Solids

__all__ = ["core_shape", "core_shapes"]


def core_shapes(pieces: Solids) -> list[_core.Shape]:
    """The pieces of a body as shapes in the axes of its joint."""
    return [core_shape(solid, placement) for solid, placement in pieces]


def core_shape(solid: Solid, placement: pin.SE3) -> _core.Shape:
    """A piece at its placement in its joint.

    Raises:
        TypeError: what is no convex body, such as a triangle.
    """
    shape: Any = solid.geometry
    at = place_numbers(placement)
    around = float(shape.getSweptSphereRadius())
    if isinstance(shape, coal.Sphere):
        return _core.ball_shape(float(shape.radius) + around, at)
    if isinstance(shape, coal.Capsule):
        return _core.capsule_shape(float(shape.radius) + around, float(shape.halfLength), at)
    if isinstance(shape, coal.Cylinder):
        return _core.cylinder_shape(float(shape.radius), float(shape.halfLength), around, at)
    if isinstance(shape, coal.Cone):
        return _core.cone_shape(float(shape.radius), float(shape.halfLength), around, at)
    if isinstance(shape, coal.Box):
        return _core.box_shape(np.array(shape.halfSide).ravel(), around, at)
    if isinstance(shape, coal.Ellipsoid):
        return _core.ellipsoid_shape(np.array(shape.radii).ravel(), around, at)
    if isinstance(shape, coal.Halfspace):
        return _core.half_space_shape(np.array(shape.n).ravel(), float(shape.d) + around, at)
    if (polyhedron := solid.polyhedron) is None:
        raise TypeError(f"no convex body: {type(shape).__name__}")
    loops = [loop.tolist() for loop in polyhedron.faces]
    return _core.polytope_shape(polyhedron.vertices.ravel(), loops, around, at)
