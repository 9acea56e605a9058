"""Axes of contacts, and products of single vectors."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin

from ..laws.borrowed import borrowing
from . import vectors
from .vectors import Vector

__all__ = ["contact_axes", "cross", "place_numbers", "rows_of_axes"]


def contact_axes(normal: np.ndarray) -> np.ndarray:
    """(3, 3) columns t₁, t₂, n: a right-handed triad on a unit normal.

    t₁ is the world axis that is most across the normal, made perpendicular to it.
    """
    # In plain floats: an array operation costs more than these sums.
    return np.array(rows_of_axes(*normal.tolist()))


@borrowing
def rows_of_axes(x: float, y: float, z: float) -> tuple[Vector, Vector, Vector]:
    """``contact_axes`` of the normal x, y, z, row by row."""
    if abs(x) <= abs(y) and abs(x) <= abs(z):
        a, b, c = 1.0 - x * x, -y * x, -z * x
    elif abs(y) <= abs(z):
        a, b, c = -x * y, 1.0 - y * y, -z * y
    else:
        a, b, c = -x * z, -y * z, 1.0 - z * z
    length = math.sqrt(a * a + b * b + c * c)
    a, b, c = a / length, b / length, c / length
    return (a, y * c - z * b, x), (b, z * a - x * c, y), (c, x * b - y * a, z)


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(3,) a × b; numpy's own is slow for one pair."""
    return np.array(vectors.cross(a.tolist(), b.tolist()))


def place_numbers(placement: pin.SE3) -> np.ndarray:
    """(12,) the rotation row by row, and the translation, as the core takes places."""
    return np.concatenate([placement.rotation.ravel(), placement.translation])
