"""A factor of M at one configuration: what every solve with rows is built on.

Both factors give C with A M⁻¹ Aᵀ = Cᵀ C, so that W is never formed from an inverse.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from ..errors import SingularMassError
from ..laws.rank_tolerances import SMALLEST_PIVOT, UNFILLED_ROW, WEIGHTLESS
from ..tolerances import NONZERO
from . import lapack
from .algorithms import cholesky_solve, singular_mass, symmetric

__all__ = ["FilledFactor", "SparseFactor", "of_unit_length", "pivots_are_safe"]

# Joints with this part in a motion without mass, a unit vector, are named.
MOVES = 0.1


class SparseFactor:
    """Pinocchio's M = U D Uᵀ, already in ``data``."""

    def __init__(self, model: pin.Model, data: pin.Data) -> None:
        self._model, self._data = model, data

    def half(self, *rows: np.ndarray) -> np.ndarray:
        """(nv, m) C = D^-½ U⁻¹ Aᵀ for rows A (m, nv), given in parts."""
        # Not LAPACK's dtrtrs: OpenBLAS starts threads for it, at any size.
        half = lapack.solve_triangle(lapack.dtrsm, self._data.U, np.concatenate(rows).T, diag=1)
        half /= np.sqrt(self._data.D)[:, None]
        return half

    def solve(self, impulse: np.ndarray) -> np.ndarray:
        """(nv,) M⁻¹ I."""
        return cholesky_solve(self._model, self._data, impulse)


class FilledFactor:
    """A Cholesky factor of M + ρ AᵀA, for a singular M that bilateral rows make whole.

    With A Δv = c prescribed, M Δv = I + Aᵀλ and (M + ρ AᵀA) Δv = I + ρ Aᵀc + Aᵀλ have
    the same solution; ``singular`` says that M is so at every configuration, or that pivots
    have come near rounding. Also for what
    the sparse Cholesky does not take: mimic joints, or a single degree of freedom.
    """

    def __init__(
        self,
        model: pin.Model,
        mass_matrix: np.ndarray,
        rows: np.ndarray,
        *,
        singular: bool = False,
    ) -> None:
        import scipy.linalg

        self._model = model
        mass_matrix = symmetric(np.atleast_2d(mass_matrix))
        self._unit_rows, self._lengths = of_unit_length(np.diagonal(mass_matrix), rows)
        filled = mass_matrix + self._unit_rows.T @ self._unit_rows
        self._scale = 1.0 / np.sqrt(np.maximum(np.diagonal(filled), NONZERO))
        try:
            self._lower = scipy.linalg.cholesky(
                filled * self._scale * self._scale[:, None], lower=True
            )
        except np.linalg.LinAlgError:
            raise self._singular(filled) from None
        least = np.diagonal(self._lower).min() ** 2
        if singular:
            # Rounding grows from pivot to pivot: what the rows leave singular is told by all.
            scaled = filled * self._scale * self._scale[:, None]
            least = min(least, np.linalg.eigvalsh(scaled)[0])
        if least < SMALLEST_PIVOT:
            raise self._singular(filled)

    def filled_impulse(self, impulse: np.ndarray, wanted: np.ndarray) -> np.ndarray:
        """(nv,) I + ρ Aᵀc, with c (m,) the wanted change of the rows' velocities."""
        return impulse + wanted / self._lengths @ self._unit_rows

    def half(self, *rows: np.ndarray) -> np.ndarray:
        """(nv, m) C for rows A (m, nv), given in parts."""
        # Not solve_triangular: OpenBLAS starts threads for it, at any size.
        columns = self._scale[:, None] * np.vstack(rows).T
        return lapack.solve_triangle(lapack.dtrsm, self._lower, columns, lower=1)

    def solve(self, impulse: np.ndarray) -> np.ndarray:
        """(nv,) of an impulse that has been filled."""
        return self.back(self.half(impulse[None]))[:, 0]

    def back(self, half: np.ndarray) -> np.ndarray:
        """(nv, k) L⁻ᵀ of half-solved columns."""
        columns = lapack.solve_triangle(lapack.dtrsm, self._lower, half.copy(), lower=1, trans_a=1)
        return self._scale[:, None] * columns

    def _singular(self, filled: np.ndarray) -> SingularMassError:
        """The error that names the joints along which neither inertia nor constraint acts."""
        _, vectors = np.linalg.eigh(filled)
        still = np.flatnonzero(np.abs(vectors[:, 0]) > MOVES)
        model = self._model
        starts = [model.idx_vs[joint_id] for joint_id in range(1, model.njoints)]
        joints = np.searchsorted(starts, still, side="right")
        return singular_mass(model, sorted(set(joints.tolist())))


def of_unit_length(diagonal: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(m, nv) rows of unit length in the metric of an inertia, and (m,) what they are divided by.

    ``diagonal``: (nv,) of M. Rows that count as zero are of infinite length.
    """
    sizes = np.sqrt((rows**2 / _weights(diagonal, rows)).sum(axis=1))
    lengths = np.where(sizes > UNFILLED_ROW * sizes.max(initial=0.0), sizes, np.inf)
    return rows / lengths[:, None], lengths


def _weights(diagonal: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """(nv,) the diagonal of M; for a speed that moves nothing, what its rows feel elsewhere.

    A much smaller weight would cost the digits of that speed, a larger one those of others.
    """
    heavy = diagonal > WEIGHTLESS * diagonal.max()
    felt = (rows[:, heavy] ** 2 / diagonal[heavy]).sum(axis=1)
    felt = np.where(felt > 0.0, felt, np.inf)
    weights = np.where(heavy, diagonal, (rows**2 / felt[:, None]).max(axis=0, initial=0.0))
    return np.where(weights > 0.0, weights, diagonal.max() or 1.0)


def pivots_are_safe(data: pin.Data, least: float = SMALLEST_PIVOT) -> bool:
    """Whether all pivots of the sparse factor in ``data`` are above this part of M's diagonal."""
    return bool((least * data.M.diagonal() < data.D).all())
