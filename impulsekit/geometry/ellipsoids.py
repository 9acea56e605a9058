"""Ellipsoids, and one over a half-space in closed form.

The support function of the ellipsoid {Eᵀ x + c : |x| ≤ 1} is n·c + |E n|: it reaches furthest along
n at c + Eᵀ E n / |E n|.
"""

from __future__ import annotations

from dataclasses import dataclass

import coal
import numpy as np
import pinocchio as pin

from .convex import HalfSpace

__all__ = ["Ellipsoid", "ellipsoid_of", "lowest_point"]


@dataclass(frozen=True, eq=False)
class Ellipsoid:
    """An ellipsoid somewhere.

    Attributes:
        centre: (3,) [m].
        rows: (3, 3) E: its semi-axes [m], row by row.
        radius: how far it reaches around that [m].
    """

    centre: np.ndarray
    rows: np.ndarray
    radius: float

    def reach(self, n: np.ndarray) -> tuple[float, np.ndarray]:
        """How far it reaches from its centre along a unit vector (3,) [m], and (3,) to where."""
        across = self.rows.dot(n)
        depth = float(np.sqrt(across.dot(across)))
        return depth + self.radius, across.dot(self.rows) / depth + self.radius * n


def ellipsoid_of(shape: coal.Ellipsoid, place: pin.SE3) -> Ellipsoid:
    """One of coal's at a place, with or without a rounding of its own."""
    rows = np.array(shape.radii).reshape(3, 1) * place.rotation.T
    return Ellipsoid(place.translation.copy(), rows, float(shape.getSweptSphereRadius()))


def lowest_point(
    shape: coal.Ellipsoid, place: pin.SE3, ground: HalfSpace, place_of_ground: pin.SE3
) -> tuple[float, np.ndarray, np.ndarray]:
    """The gap [m], the half-space's normal (3,), and the ellipsoid's point (3,) nearest to it.

    Args:
        shape: with or without a rounding of its own.
        place, place_of_ground: where both are; normal and point are in the same frame.
    """
    # In the frame of the ground: the digits of its place in the world are not in the gap.
    body = ellipsoid_of(shape, place_of_ground.actInv(place))
    depth, down = body.reach(ground.normal)
    gap = float(ground.normal.dot(body.centre)) - depth - ground.height
    normal = place_of_ground.rotation.dot(ground.normal)
    return gap, normal, place_of_ground.act(body.centre - down)
