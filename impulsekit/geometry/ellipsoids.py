"""An ellipsoid over a half-space, in closed form.

The support function of the ellipsoid {R diag(r) x + c : |x| ≤ 1} is n·c + |diag(r) Rᵀ n|.
"""

from __future__ import annotations

import coal
import numpy as np
import pinocchio as pin

from .convex import HalfSpace

__all__ = ["lowest_point"]


def lowest_point(
    shape: coal.Ellipsoid, place: pin.SE3, ground: HalfSpace, place_of_ground: pin.SE3
) -> tuple[float, np.ndarray, np.ndarray]:
    """The gap [m], the half-space's normal (3,), and the ellipsoid's point (3,) nearest to it.

    Args:
        shape: with or without a rounding of its own.
        place, place_of_ground: where both are; normal and point are in the same frame.
    """
    # In the frame of the ground: the digits of its place in the world are not in the gap.
    away = place_of_ground.actInv(place)
    radii, round_by = np.array(shape.radii).reshape(3), float(shape.getSweptSphereRadius())
    across = radii * away.rotation.T.dot(ground.normal)
    depth = float(np.linalg.norm(across))
    gap = float(ground.normal.dot(away.translation)) - depth - round_by - ground.height
    down = away.rotation.dot(radii * across) / depth + round_by * ground.normal
    normal = place_of_ground.rotation.dot(ground.normal)
    return gap, normal, place_of_ground.act(away.translation - down)
