"""The corners of polyhedra, each with a gap of its own.

coal tells the distance of two polyhedra to some 1e-11 m, and that of the points of a patch
to 1e-6 m. A corner, as a point moved away by a known way d along the normal n, is told to
rounding: its gap is D − d n·n', D and n' the distance and direction found there.
"""

from __future__ import annotations

from collections.abc import Sequence

import coal
import numpy as np
import pinocchio as pin

__all__ = ["corners_of", "nearest", "point_gap"]

# The way [m] a corner is moved for its gap.
AWAY = 1e-2
# A point of a patch is a corner where there is one so near [m].
NEAR = 1e-5

_POINT = coal.Sphere(0.0)
Pieces = Sequence[tuple[coal.CollisionGeometry, pin.SE3]]


def corners_of(pieces: Pieces) -> np.ndarray | None:
    """(k, 3) the corners of all pieces of a body, in its joint's frame; None for curved ones."""
    found = []
    for shape, placement in pieces:
        if isinstance(shape, coal.Box):
            signs = np.array(np.meshgrid(*[(-1.0, 1.0)] * 3)).reshape(3, -1).T
            corners = signs * np.array(shape.halfSide)
        elif isinstance(shape, coal.ConvexBase):
            corners = np.array([shape.point(i) for i in range(shape.num_points)])
        else:
            return None
        found.append(corners.dot(placement.rotation.T) + placement.translation)
    return np.vstack(found) if found else None


def nearest(corners: np.ndarray, point: np.ndarray) -> int | None:
    """Which of (k, 3) corners a point is; None for none of them."""
    away = np.linalg.norm(corners - point, axis=1)
    i = int(away.argmin())
    return i if away[i] <= NEAR else None


def point_gap(point: np.ndarray, normal: np.ndarray, pieces: Pieces) -> float:
    """How far a point is from a body [m], negative inside.

    Args:
        point: (3,) in the world.
        normal: (3,) from the body to the point, where that is near its surface.
        pieces: of the body, each with its placement in the world.
    """
    request = coal.DistanceRequest()
    request.enable_signed_distance = True
    request.gjk_tolerance = request.epa_tolerance = 1e-12
    place = coal.Transform3s(np.eye(3), point + AWAY * normal)
    gaps = []
    for shape, placement in pieces:
        result = coal.DistanceResult()
        there = coal.Transform3s(placement.rotation, placement.translation)
        further = coal.distance(_POINT, place, shape, there, request, result)
        gaps.append(float(further) + AWAY * float(normal.dot(result.normal)))
    return min(gaps)
