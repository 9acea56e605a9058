"""A Cholesky factor of the mass matrix for many right-hand sides at once.

Where M alone is singular and bilateral rows A make it whole, M + AᵀA of rows of unit
length takes its place: with A d prescribed both have the same solution.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg.blas import dtrsm
from scipy.linalg.lapack import dpotrf, dpotrs

from ...errors import InputError

__all__ = ["Factor"]

SMALLEST_PIVOT = 1e-13
_NONE = np.ones(0)


class Factor:
    """M = L Lᵀ, or M filled up by rows A (m, nv); ``regular`` where M is so everywhere."""

    def __init__(self, mass_matrix: np.ndarray, rows: np.ndarray, *, regular: bool) -> None:
        self._unit: np.ndarray | None = None
        self._lengths = _NONE
        if regular:
            self._lower, failed = dpotrf(mass_matrix, lower=1, clean=0)
            if not failed:
                return
        if self._decompose(mass_matrix):
            return
        diagonal = np.diagonal(mass_matrix)
        weights = np.maximum(diagonal, 1e-9 * diagonal.max(initial=0.0))
        sizes = np.sqrt((rows**2 / weights).sum(axis=1))
        live = sizes > 1e-12 * sizes.max(initial=0.0)
        self._lengths = np.where(live, sizes, np.inf)
        self._unit = rows / self._lengths[:, None]
        if not self._decompose(mass_matrix + self._unit.T @ self._unit):
            raise InputError("derivatives: nothing resists some motion of this robot")

    def _decompose(self, matrix: np.ndarray) -> bool:
        # Cholesky does not mind how a matrix is scaled, only its pivots have to be compared.
        self._lower, failed = dpotrf(matrix, lower=1)
        pivots = self._lower.diagonal()
        return not failed and bool((pivots * pivots >= SMALLEST_PIVOT * matrix.diagonal()).all())

    @property
    def is_filled(self) -> bool:
        """Whether rows had to make up for what M lacks."""
        return self._unit is not None

    def filled(self, force: np.ndarray, wanted: np.ndarray) -> np.ndarray:
        """(nv, w) the right-hand side that goes with A d = wanted (m, w)."""
        if self._unit is None:
            return force
        return force + self._unit.T @ (wanted / self._lengths[:, None])

    def solve(self, right: np.ndarray) -> np.ndarray:
        """(nv, w) of right-hand sides that have been filled."""
        solution, _ = dpotrs(self._lower, right, lower=1)
        return solution

    def back(self, half: np.ndarray) -> np.ndarray:
        """(nv, w) L⁻ᵀ C of half-solved columns."""
        return dtrsm(1.0, self._lower, half, lower=1, trans_a=1)

    def half(self, rows: np.ndarray) -> np.ndarray:
        """(nv, m) L⁻¹ Gᵀ, whose columns have the lengths of rows in the metric of M⁻¹."""
        return dtrsm(1.0, self._lower, rows.T, lower=1)
