"""The factor of M at one configuration: what every solve with rows is built on.

Both forms give C with A M⁻¹ Aᵀ = Cᵀ C, so that W is never formed from an inverse. Which of them
is taken is decided here, for impacts, motions, and what is asked of an impact afterwards.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
import pinocchio as pin

from ..tolerances import NONZERO
from . import lapack
from .rank_tolerances import FAINT_PIVOT, SMALLEST_PIVOT
from .singular import MOVES, joints_of, of_unit_length, pivots_are_safe, singular_mass

__all__ = ["DenseFactor", "Factor", "MassFactor", "SparseFactor"]

# Bound once: on a small robot the look-up of a name counts.
_decompose, _solve = pin.cholesky.decompose, pin.cholesky.solve


class Factor(Protocol):
    """A factor of M, or of M filled up by the bilateral rows."""

    @property
    def is_filled(self) -> bool:
        """Whether rows had to make up for what M lacks."""

    def filled(self, impulse: np.ndarray, wanted: np.ndarray) -> np.ndarray:
        """(nv,) or (nv, w) the right-hand side that goes with A Δv = wanted, (m,) or (m, w)."""

    def half(self, *rows: np.ndarray) -> np.ndarray:
        """(nv, m) C for rows A (m, nv), given in parts."""

    def solve(self, impulse: np.ndarray) -> np.ndarray:
        """(nv,) Δv of an impulse that has been filled."""


class MassFactor:
    """Factors of one model's M, from ``data.M`` at one configuration after the other.

    Attributes:
        is_dense: whether the model is one that Pinocchio's sparse Cholesky does not take.
        is_sparse: whether it is used, where pivots allow it.
    """

    def __init__(
        self,
        model: pin.Model,
        data: pin.Data,
        *,
        singular: bool,
        regular: bool = False,
        least_pivot: float = SMALLEST_PIVOT,
    ) -> None:
        """``singular``, ``regular``: whether M is so at every configuration, whatever pivots say.

        ``least_pivot``: pivots below this share of the diagonal are not left to the sparse factor.
        """
        self._model, self._data = model, data
        self._singular, self._regular, self._least_pivot = singular, regular, least_pivot
        # Pinocchio's sparse Cholesky takes neither mimic joints nor a model with one row.
        self.is_dense = model.nv < 2 or len(model.mimicking_joints) > 0
        self.is_sparse = not (self.is_dense or singular)
        # Pivots depend on the order of elimination: faint ones say nothing by themselves.
        self._all_told = singular or (not self.is_dense and least_pivot == FAINT_PIVOT)
        self._sparse = SparseFactor(model, data)

    def decompose(self) -> bool:
        """Whether the sparse factor, which is written to ``data``, has no pivot near rounding."""
        _decompose(self._model, self._data)
        return self._regular or pivots_are_safe(self._data, self._least_pivot)

    def at(self, rows: np.ndarray | None) -> Factor:
        """The factor of M in ``data``, filled up by rows (m, nv) where M is singular.

        Raises:
            SingularMassError: rows do not make up for what M lacks.
        """
        if self.is_sparse and self.decompose():
            return self._sparse
        # Pinocchio fills the upper triangle; with one degree of freedom it gives a number.
        masses = np.atleast_2d(self._data.M).T
        return DenseFactor(self._model, masses, rows, singular=self._all_told)


class SparseFactor:
    """Pinocchio's M = U D Uᵀ, already in ``data``."""

    is_filled = False

    def __init__(self, model: pin.Model, data: pin.Data) -> None:
        self._model, self._data = model, data

    def filled(self, impulse: np.ndarray, wanted: np.ndarray) -> np.ndarray:
        """The same: nothing had to be filled."""
        return impulse

    def half(self, *rows: np.ndarray) -> np.ndarray:
        """(nv, m) C = D^-½ U⁻¹ Aᵀ for rows A (m, nv), given in parts."""
        # Not LAPACK's dtrtrs: OpenBLAS starts threads for it, at any size.
        half = lapack.solve_triangle(lapack.dtrsm, self._data.U, np.concatenate(rows).T, diag=1)
        half /= np.sqrt(self._data.D)[:, None]
        return half

    def solve(self, impulse: np.ndarray) -> np.ndarray:
        """(nv,) M⁻¹ I."""
        return _solve(self._model, self._data, impulse)


class DenseFactor:
    """M = L Lᵀ, or M + ρ AᵀA = L Lᵀ for a singular M that bilateral rows make whole.

    With A Δv = c prescribed, M Δv = I + Aᵀλ and (M + ρ AᵀA) Δv = I + ρ Aᵀc + Aᵀλ have
    the same solution. Also for what the sparse Cholesky does not take, and for many right-hand
    sides at once.

    Args:
        model: whose joints are named.
        mass_matrix: (nv, nv) M; its lower triangle is read.
        rows: (m, nv) A; None without any.
        regular: whether M is so at every configuration, and pivots need not be looked at.
        singular: whether M is singular at every configuration, or its pivots are near rounding.

    Raises:
        SingularMassError: it names the joints along which neither inertia nor constraint acts.
    """

    def __init__(
        self,
        model: pin.Model,
        mass_matrix: np.ndarray,
        rows: np.ndarray | None = None,
        *,
        regular: bool = False,
        singular: bool = False,
    ) -> None:
        self._unit_rows: np.ndarray | None = None
        self._inverse: np.ndarray | None = None
        matrix = mass_matrix
        if not singular and self._decompose(matrix, regular):
            return
        if rows is not None and len(rows):
            self._unit_rows, self._lengths = of_unit_length(matrix.diagonal(), rows)
            matrix = matrix + self._unit_rows.T.dot(self._unit_rows)
        if not self._decompose(matrix, trusted=False) or _is_singular(matrix):
            still = np.linalg.eigh(matrix)[1][:, 0]
            raise singular_mass(model, joints_of(model, np.abs(still) > MOVES))

    def _decompose(self, matrix: np.ndarray, trusted: bool) -> bool:
        """Write L; whether no pivot is rounding, where they are not trusted."""
        self._lower, failed = lapack.dpotrf(matrix, lower=1)
        if failed or trusted:
            return not failed
        pivots = self._lower.diagonal()
        return bool((pivots * pivots >= SMALLEST_PIVOT * matrix.diagonal()).all())

    @property
    def is_filled(self) -> bool:
        """Whether rows had to make up for what M lacks."""
        return self._unit_rows is not None

    def filled(self, impulse: np.ndarray, wanted: np.ndarray) -> np.ndarray:
        """(nv,) or (nv, w) I + ρ Aᵀc, with c the wanted change of the rows' velocities."""
        if self._unit_rows is None:
            return impulse
        return impulse + self._unit_rows.T.dot((wanted.T / self._lengths).T)

    def half(self, *rows: np.ndarray) -> np.ndarray:
        """(nv, m) C = L⁻¹ Aᵀ for rows A (m, nv), given in parts."""
        # Not solve_triangular: OpenBLAS starts threads for it, at any size.
        columns = np.concatenate(rows).T
        return lapack.solve_triangle(lapack.dtrsm, self._lower, columns, lower=1)

    def solve(self, impulse: np.ndarray) -> np.ndarray:
        """(nv,) Δv of an impulse that has been filled; (nv, w) of many at once, by L⁻¹.

        Products take a third of the time of triangles, and OpenBLAS starts no threads for them.
        """
        if impulse.ndim == 1:
            return self.back(self.half(impulse[None]))[:, 0]
        if self._inverse is None:
            self._inverse, _ = lapack.dtrtri(self._lower, lower=1)
        return self._inverse.T.dot(self._inverse.dot(impulse))

    def back(self, half: np.ndarray) -> np.ndarray:
        """(nv, k) L⁻ᵀ of half-solved columns."""
        return lapack.solve_triangle(lapack.dtrsm, self._lower, half.copy(), lower=1, trans_a=1)


def _is_singular(matrix: np.ndarray) -> bool:
    """Whether what all pivots together leave is rounding: it grows from pivot to pivot."""
    scale = 1.0 / np.sqrt(np.maximum(matrix.diagonal(), NONZERO))
    least = np.linalg.eigvalsh(matrix * scale * scale[:, None])[0]
    return bool(least < SMALLEST_PIVOT)
