"""Products of single vectors of three numbers, for compiled code and Python alike."""

from __future__ import annotations

import numpy as np

from ..laws.borrowed import borrowing
from ..laws.compiled import compiled

__all__ = ["Vector", "along", "cross", "cross_of", "dot", "row_of"]

Vector = tuple[float, float, float]


@borrowing
def cross(a: Vector, b: Vector) -> Vector:
    """a × b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@borrowing
def dot(a: Vector, b: Vector) -> float:
    """a·b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@borrowing
def along(a: Vector, factor: float, b: Vector) -> Vector:
    """a + factor b."""
    return a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]


@borrowing
def row_of(rows: np.ndarray, i: int) -> Vector:
    """A row of three numbers."""
    return rows[i, 0], rows[i, 1], rows[i, 2]


@compiled
def cross_of(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(3,) a × b of arrays."""
    return np.array(cross((a[0], a[1], a[2]), (b[0], b[1], b[2])))
