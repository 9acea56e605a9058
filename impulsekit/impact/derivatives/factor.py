"""A Cholesky factor of the mass matrix for many right-hand sides at once.

Where M alone is singular and bilateral rows A make it whole, M + AᵀA of rows of unit
length takes its place: with A d prescribed both have the same solution.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dpotrf, dtrtri

from ...errors import InputError
from ...laws.rank_tolerances import SMALLEST_PIVOT
from ..factor import of_unit_length

__all__ = ["Factor"]

_NONE = np.ones(0)


class Factor:
    """M = L Lᵀ, or M filled up by rows A (m, nv).

    Args:
        regular, singular: whether M is so at every configuration.
    """

    def __init__(
        self, mass_matrix: np.ndarray, rows: np.ndarray, *, regular: bool, singular: bool = False
    ) -> None:
        self._unit: np.ndarray | None = None
        self._lengths = _NONE
        if regular:
            self._lower, failed = dpotrf(mass_matrix, lower=1)
            if not failed:
                self._inverse, _ = dtrtri(self._lower, lower=1)
                return
        if not singular and self._decompose(mass_matrix):
            return
        self._unit, self._lengths = of_unit_length(np.diagonal(mass_matrix), rows)
        if not self._decompose(mass_matrix + self._unit.T @ self._unit):
            raise InputError("derivatives: nothing resists some motion of this robot")

    def _decompose(self, matrix: np.ndarray) -> bool:
        # Cholesky does not mind how a matrix is scaled, only its pivots have to be compared.
        self._lower, failed = dpotrf(matrix, lower=1)
        pivots = self._lower.diagonal()
        if failed or not (pivots * pivots >= SMALLEST_PIVOT * matrix.diagonal()).all():
            return False
        # Not triangular solves: OpenBLAS starts threads for them, which cost far more at
        # these sizes; for products it does not.
        self._inverse, _ = dtrtri(self._lower, lower=1)
        return True

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
        return self._inverse.T.dot(self._inverse.dot(right))

    def back(self, half: np.ndarray) -> np.ndarray:
        """(nv, w) L⁻ᵀ C of half-solved columns."""
        return self._inverse.T.dot(half)

    def half(self, *rows: np.ndarray) -> np.ndarray:
        """(nv, m) L⁻¹ Gᵀ, whose columns have the lengths of rows in the metric of M⁻¹."""
        return self._inverse.dot((rows[0] if len(rows) == 1 else np.concatenate(rows)).T)
