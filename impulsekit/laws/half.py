"""Half of M⁻¹: with M = U D Uᵀ and C = D^-½ U⁻¹ Jᵀ the Delassus matrix is Cᵀ C."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .borrowed import borrowing

__all__ = ["Factor", "from_half", "halve", "is_safe", "solve_mass"]


class Factor(NamedTuple):
    """M = U D Uᵀ, in rows of (nv, nv).

    Attributes:
        factor: (nv, nv) Uᵀ, strictly below its diagonal of ones.
        pivots: (nv,) D.
        mass: (nv, nv) M; only its diagonal is read.
        branch: (nv,) the first speed of the branch at the world that each speed belongs to.
        least: pivots below this share of M's diagonal are rounding error.
    """

    factor: np.ndarray
    pivots: np.ndarray
    mass: np.ndarray
    branch: np.ndarray
    least: float


@borrowing
def is_safe(factor: Factor) -> bool:
    """Whether no pivot is rounding error."""
    for i in range(len(factor.pivots)):
        if not factor.pivots[i] > factor.least * factor.mass[i, i]:
            return False
    return True


@borrowing
def solve_mass(factor: Factor, x: np.ndarray) -> None:
    """x ← M⁻¹ x."""
    halve(factor, x)
    from_half(factor, x)


@borrowing
def halve(factor: Factor, x: np.ndarray) -> None:
    """x ← D^-½ U⁻¹ x."""
    for k in range(len(x) - 1, -1, -1):
        if x[k] != 0.0:
            for i in range(factor.branch[k], k):
                x[i] -= factor.factor[k, i] * x[k]
            x[k] /= math.sqrt(factor.pivots[k])


@borrowing
def from_half(factor: Factor, x: np.ndarray) -> None:
    """x ← U^-T D^-½ x."""
    for k in range(len(x)):
        x[k] /= math.sqrt(factor.pivots[k])
        for i in range(factor.branch[k], k):
            x[k] -= factor.factor[k, i] * x[i]
