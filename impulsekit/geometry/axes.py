"""Axes of contacts, and products of single vectors."""

from __future__ import annotations

import math

import numpy as np

from . import vectors

__all__ = ["contact_axes", "cross"]


def contact_axes(normal: np.ndarray) -> np.ndarray:
    """(3, 3) columns t₁, t₂, n: a right-handed triad on a unit normal.

    t₁ is the world axis that is most across the normal, made perpendicular to it.
    """
    # In plain floats: an array operation costs more than these sums.
    x, y, z = n = normal.tolist()
    sizes = [abs(x), abs(y), abs(z)]
    least = sizes.index(min(sizes))
    along = n[least]
    a, b, c = -x * along, -y * along, -z * along
    if least == 0:
        a += 1.0
    elif least == 1:
        b += 1.0
    else:
        c += 1.0
    length = math.sqrt(a * a + b * b + c * c)
    a, b, c = a / length, b / length, c / length
    return np.array(
        ((a, y * c - z * b, x), (b, z * a - x * c, y), (c, x * b - y * a, z)),
    )


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(3,) a × b; numpy's own is slow for one pair."""
    return np.array(vectors.cross(a.tolist(), b.tolist()))
