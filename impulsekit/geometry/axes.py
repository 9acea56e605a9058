"""Axes of contacts, and places as numbers."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin

__all__ = ["contact_axes", "cross", "place_numbers"]

# World axes that are across a normal alike but for this count as alike, in their order.
ALIKE = 1e-6


def contact_axes(normal: np.ndarray) -> np.ndarray:
    """(3, 3) columns t₁, t₂, n: a right-handed triad on a unit normal.

    t₁ is the world axis that is most across the normal, made perpendicular to it.
    """
    # In plain floats: an array operation costs more than these sums.
    x, y, z = normal.tolist()
    if abs(x) <= abs(y) + ALIKE and abs(x) <= abs(z) + ALIKE:
        a, b, c = 1.0 - x * x, -y * x, -z * x
    elif abs(y) <= abs(z) + ALIKE:
        a, b, c = -x * y, 1.0 - y * y, -z * y
    else:
        a, b, c = -x * z, -y * z, 1.0 - z * z
    length = math.sqrt(a * a + b * b + c * c)
    a, b, c = a / length, b / length, c / length
    return np.array([(a, y * c - z * b, x), (b, z * a - x * c, y), (c, x * b - y * a, z)])


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(3,) a × b; numpy's own is slow for one pair."""
    (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def place_numbers(placement: pin.SE3) -> np.ndarray:
    """(12,) the rotation row by row, and the translation, as the core takes places."""
    return np.concatenate([placement.rotation.ravel(), placement.translation])
