"""Collision geometry of a robot as convex shapes of the core, one per piece of a body."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import coal
import numpy as np
import pinocchio as pin

from .._core import (
    Place,
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
from ..robot import Robot
from .axes import core_place

__all__ = ["shape_of", "shapes_of"]

# Triangles of a hull whose normals differ by less belong to one face.
SAME_FACE = 1e-9


def shapes_of(robot: Robot, ids: Iterable[int]) -> list[Shape]:
    """Pieces of collision geometry by index, in the axes of their joints.

    The hull of a mesh takes longer than an impact: a robot keeps those of its meshes.

    Raises:
        InputError: what is no convex body.
    """
    objects = robot.collision_model.geometryObjects
    return [_kept_shape(robot, i, objects[i]) for i in ids]


def _kept_shape(robot: Robot, index: int, piece: Any) -> Shape:
    if not isinstance(piece.geometry, coal.BVHModelBase):
        return shape_of(piece.geometry, piece.placement)
    read = np.array(piece.geometry.vertices()), piece.placement.homogeneous
    kept = robot._hulls.get(index)
    # A mesh that was changed since then is another one.
    if kept is None or not all(map(np.array_equal, kept[0], read)):
        kept = robot._hulls[index] = read, shape_of(piece.geometry, piece.placement)
    return kept[1]


def shape_of(geometry: coal.CollisionGeometry, placement: pin.SE3) -> Shape:
    """A geometry at its placement in its joint; for a mesh its convex hull.

    Raises:
        InputError: what is no convex body.
    """
    shape: Any = geometry
    at = core_place(placement)
    if isinstance(shape, coal.BVHModelBase):
        return _polytope(np.array(shape.vertices()), 0.0, at)
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
        return _polytope(points, around, at)
    raise InputError(f"Collision: a geometry of kind {type(shape).__name__} is no convex body")


def _polytope(points: np.ndarray, around: float, at: Place) -> Shape:
    """The convex hull of points, flat where they are."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points)
        faces = _faces(hull)
    except (QhullError, ValueError):
        arms = points - points.mean(axis=0)
        try:
            loop = ConvexHull(arms @ np.linalg.svd(arms)[2][:2].T).vertices.tolist()
        except (QhullError, ValueError, np.linalg.LinAlgError):
            raise InputError("Collision: a hull has no area") from None
        faces = [loop, loop[::-1]]
    used = np.array(sorted({corner for loop in faces for corner in loop}))
    number = {int(old): new for new, old in enumerate(used)}
    loops = [[number[corner] for corner in loop] for loop in faces]
    return polytope_shape(points[used].ravel(), loops, around, at)


def _faces(hull: Any) -> list[list[int]]:
    """The corners of each face against the clock; triangles of one plane are one face."""
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
    # Most faces of a mesh's hull are triangles, which need no sorting.
    a, b, c = (hull.points[hull.simplices[:, i]] for i in range(3))
    clockwise = (np.cross(b - a, c - a) * hull.equations[:, :3]).sum(axis=1) < 0.0
    hull.simplices[clockwise] = hull.simplices[clockwise][:, ::-1]
    triangles = {frozenset(loop): loop for loop in hull.simplices.tolist()}
    return [
        triangles.get(frozenset(corners))
        or _in_turn(hull.points, normal, np.array(sorted(corners))).tolist()
        for normal, corners in zip(normals, members, strict=False)
    ]


def _in_turn(points: np.ndarray, normal: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """The corners of a face against the clock."""
    arms = points[corners] - points[corners].mean(axis=0)
    first = arms[0] / np.linalg.norm(arms[0])
    angles = np.arctan2(arms.dot(np.cross(normal, first)), arms.dot(first))
    return corners[np.argsort(angles)]
