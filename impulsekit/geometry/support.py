"""How far convex shapes reach: their support functions h(m) = max of m·x over all x of the shape.

Every shape is summed up (in Minkowski's sense) of corners that may carry discs, an ellipsoid and
a ball, of which each has h in closed form (Ericson, Real-Time Collision Detection, 2005, ch. 9):

    h(m) = max_k (p_k·m + r_k |m − (u·m) u|) + |E m| + ρ |m|
"""

from __future__ import annotations

import math
from typing import NamedTuple

import coal
import numpy as np
import pinocchio as pin

from ..laws.borrowed import borrowing
from .vectors import along, dot, row_of

__all__ = ["NOTHING", "NO_ROWS", "Shape", "furthest", "support_of"]

# Directions this near to the normal of a half-space are along it.
SAME_WAY = 1e-6


class Shape(NamedTuple):
    """A shape in the frame of its body, as ``furthest`` takes it.

    Arrays of what it lacks are empty.

    Attributes:
        centre: (3,) a point about which ``furthest`` is measured [m].
        points: (k, 3) corners, beside the centre [m].
        discs: (k,) radius of the disc that each of them carries [m].
        axis: (3,) unit, of the discs.
        ellipsoid: (3, 3) E.
        normal: (3,) unit, of a half-space, which reaches without end in all other directions.
        ball: ρ [m].
        reach: how far what turns with the body lies from its centre [m]; a ball about it doesn't.
        radius: of a ball about the centre that holds the shape [m].
    """

    centre: np.ndarray
    points: np.ndarray
    discs: np.ndarray
    axis: np.ndarray
    ellipsoid: np.ndarray
    normal: np.ndarray
    ball: float
    reach: float
    radius: float


NOTHING, NO_ROWS = np.zeros(0), np.zeros((0, 3))


@borrowing
def furthest(shape: Shape, direction: np.ndarray) -> float:
    """h [m] beside the centre, in a direction (3,) of any length in the frame of the body."""
    way = direction[0], direction[1], direction[2]
    if len(shape.normal) > 0:
        normal = shape.normal[0], shape.normal[1], shape.normal[2]
        up = dot(normal, way)
        beside = along(way, -up, normal)
        across = max(abs(beside[0]), abs(beside[1]), abs(beside[2]))
        return 0.0 if across <= SAME_WAY * up else math.inf
    beside_axis = 0.0
    if len(shape.discs) > 0:
        axis = shape.axis[0], shape.axis[1], shape.axis[2]
        beside = along(way, -dot(axis, way), axis)
        beside_axis = math.sqrt(dot(beside, beside))
    h = -math.inf
    for k in range(len(shape.points)):
        far = dot(row_of(shape.points, k), way)
        if len(shape.discs) > 0:
            far += shape.discs[k] * beside_axis
        h = max(h, far)
    if len(shape.ellipsoid) > 0:
        turned, rows = 0.0, shape.ellipsoid
        for k in range(3):
            turned += dot(row_of(rows, k), way) ** 2
        h += math.sqrt(turned)
    if shape.ball > 0.0:
        h += shape.ball * math.sqrt(dot(way, way))
    return h


def _shape(
    centre: np.ndarray,
    points: np.ndarray,
    ball: float,
    discs: np.ndarray = NOTHING,
    axis: np.ndarray = NOTHING,
    ellipsoid: np.ndarray = NO_ROWS,
    normal: np.ndarray = NOTHING,
) -> Shape:
    """A shape with the balls that hold it."""
    far = np.sqrt(np.einsum("ij,ij->i", points, points))
    reach = float((far + discs if len(discs) else far).max())
    if len(ellipsoid):
        reach += float(np.linalg.norm(ellipsoid, 2))
    radius = np.inf if len(normal) else reach + ball
    return Shape(centre, points, discs, axis, ellipsoid, normal, ball, reach, radius)


def support_of(shape: coal.CollisionGeometry, placement: pin.SE3) -> Shape:
    """A shape that stands somewhere on a body.

    Of what is neither a polyhedron nor round in a known way it is the box about it.
    """
    turn, at = placement.rotation, placement.translation
    round_by = float(shape.getSweptSphereRadius())
    up = turn[:, 2].copy()
    if isinstance(shape, coal.Halfspace):
        normal = turn.dot(np.array(shape.n).reshape(3))
        on_it = at + (float(shape.d) + round_by) * normal
        return _shape(on_it, np.zeros((1, 3)), 0.0, normal=normal)
    if isinstance(shape, coal.Sphere):
        return _shape(at.copy(), np.zeros((1, 3)), shape.radius + round_by)
    if isinstance(shape, coal.Capsule):
        return _shape(
            at.copy(), np.outer((-1.0, 1.0), shape.halfLength * up), shape.radius + round_by
        )
    if isinstance(shape, coal.Cylinder):
        ends = np.outer((-1.0, 1.0), shape.halfLength * up)
        return _shape(at.copy(), ends, round_by, np.full(2, shape.radius), up)
    if isinstance(shape, coal.Cone):
        ends = np.outer((-1.0, 1.0), shape.halfLength * up)
        return _shape(at.copy(), ends, round_by, np.array([shape.radius, 0.0]), up)
    if isinstance(shape, coal.Ellipsoid):
        radii = np.array(shape.radii).reshape(3)
        return _shape(at.copy(), np.zeros((1, 3)), round_by, ellipsoid=radii[:, None] * turn.T)
    if isinstance(shape, coal.ConvexBase):
        corners = np.array([shape.point(i) for i in range(shape.num_points)]).reshape(-1, 3)
    else:
        if isinstance(shape, coal.Box):
            half, middle = np.array(shape.halfSide).reshape(3), np.zeros(3)
        else:
            shape.computeLocalAABB()
            low = np.array(shape.aabb_local.min_).reshape(3)
            high = np.array(shape.aabb_local.max_).reshape(3)
            half, middle = 0.5 * (high - low), 0.5 * (high + low)
        signs = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
        corners = middle + np.array(signs) * half
    centre = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    points = (corners - centre).dot(turn.T)
    return _shape(turn.dot(centre) + at, points, round_by)
