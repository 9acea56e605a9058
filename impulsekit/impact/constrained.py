"""Δv with bilateral constraints: M Δv = I + Aᵀ λ, A v⁺ = b.

λ from W λ = b − A v_free with the Delassus matrix W = A M⁻¹ Aᵀ; neither M nor W is
inverted. Where M is singular (a massless link) but the whole is regular, M gives way
to M + ρ AᵀA: both have the same solution, since A Δv is prescribed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from ..errors import SingularMassError
from .algorithms import SMALLEST_PIVOT, cholesky_solve, crba, decompose, singular_mass, symmetric
from .bilateral import BilateralSolution, solve_bilateral
from .known import KnownImpulses
from .rows import ConstraintRows

__all__ = ["ConstrainedJump", "Outcome"]


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a solve found besides Δv.

    Attributes:
        constraint_impulses: (m,) λ by row.
        unique: (m,) whether each is determined; None where all are.
    """

    constraint_impulses: np.ndarray
    unique: np.ndarray | None


class ConstrainedJump:
    """Δv under bilateral rows, by CRBA, sparse Cholesky and the Delassus matrix."""

    def __init__(self, known: KnownImpulses, rows: ConstraintRows, *, always_regular: bool) -> None:
        self._known, self._rows = known, rows
        self._model, self._data = known.model, known.model.createData()
        self._always_regular = always_regular
        # Pinocchio's sparse Cholesky takes neither mimic joints nor a model with one row.
        self._dense = self._model.nv < 2 or any(
            joint.shortname() == "JointModelMimic" for joint in self._model.joints
        )

    def solve(self, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, Outcome]:
        """(nv,) Δv of the reached model and the impulses of the constraints.

        Raises:
            ContradictionError: dependent rows demand different things.
            SingularMassError: M is singular and the constraints do not make up for it.
        """
        model, data = self._model, self._data
        impulse = self._known.generalized_impulse(data, q)
        rows = self._rows.matrix(data, q)
        before = rows.dot(v)
        target = self._rows.target(before)
        crba(model, data, q)
        if not self._dense:
            decompose(model, data)
            if self._always_regular or (SMALLEST_PIVOT * data.M.diagonal() < data.D).all():
                half = _sparse_half_solve(data, rows, impulse)
                solution = self._multipliers(half, rows, target - before, q, v)
                total = impulse + solution.impulse.dot(rows)
                return cholesky_solve(model, data, total), _outcome(solution)
        return self._solve_dense(rows, impulse, target - before, q, v)

    def _multipliers(
        self, half: np.ndarray, rows: np.ndarray, wanted: np.ndarray, q: np.ndarray, v: np.ndarray
    ) -> BilateralSolution:
        """λ, given the half-solved rows and, last, the half-solved impulse."""
        constrained = half[:, :-1]
        data = self._data

        def magnitude() -> np.ndarray:
            gross = self._rows.magnitude(data, q)
            masses = np.diagonal(data.M)
            return (gross**2) @ (1.0 / np.maximum(masses, 1e-12 * masses.max()))

        def velocity_scale() -> np.ndarray:
            gross = self._rows.magnitude(data, q)
            return gross @ np.abs(v) + np.abs(constrained.T @ half[:, -1])

        return solve_bilateral(
            constrained,
            wanted - half[:, -1].dot(constrained),
            magnitude,
            velocity_scale,
            self._rows.names,
        )

    def _solve_dense(
        self,
        rows: np.ndarray,
        impulse: np.ndarray,
        wanted: np.ndarray,
        q: np.ndarray,
        v: np.ndarray,
    ) -> tuple[np.ndarray, Outcome]:
        """The same with M + ρ AᵀA, where M is singular or the sparse Cholesky does not serve."""
        import scipy.linalg

        mass_matrix = symmetric(np.atleast_2d(self._data.M))
        diagonal = np.diagonal(mass_matrix)
        # Rows of unit length in the metric of the inertia there is.
        weights = np.maximum(diagonal, 1e-9 * diagonal.max())
        sizes = np.sqrt((rows**2 / weights).sum(axis=1))
        unit = rows / np.where(sizes > 1e-12 * sizes.max(initial=0.0), sizes, np.inf)[:, None]
        filled = mass_matrix + unit.T @ unit
        scale = 1.0 / np.sqrt(np.maximum(np.diagonal(filled), 1e-300))
        try:
            lower = scipy.linalg.cholesky(filled * scale * scale[:, None], lower=True)
        except np.linalg.LinAlgError:
            raise self._singular(filled) from None
        if np.diagonal(lower).min() ** 2 < SMALLEST_PIVOT:
            raise self._singular(filled)
        # The wanted change of the rows enters the filled system as an impulse of its own.
        share = np.where(sizes > 1e-12 * sizes.max(initial=0.0), wanted / sizes, 0.0)
        filled_impulse = impulse + share @ unit
        half = scipy.linalg.solve_triangular(
            lower, scale[:, None] * np.vstack([rows, filled_impulse]).T, lower=True
        )
        solution = self._multipliers(half, rows, wanted, q, v)
        total = filled_impulse + solution.impulse @ rows
        dv = scale * scipy.linalg.cho_solve((lower, True), scale * total)
        return dv, _outcome(solution)

    def _singular(self, filled: np.ndarray) -> SingularMassError:
        """The error that names the joints along which neither inertia nor constraint acts."""
        values, vectors = np.linalg.eigh(filled)
        del values
        still = np.flatnonzero(np.abs(vectors[:, 0]) > 0.1)
        model = self._model
        starts = [model.idx_vs[joint_id] for joint_id in range(1, model.njoints)]
        joints = np.searchsorted(starts, still, side="right")
        return singular_mass(model, sorted(set(joints.tolist())))


def _sparse_half_solve(data: pin.Data, rows: np.ndarray, impulse: np.ndarray) -> np.ndarray:
    """(nv, m + 1) C with M = U D Uᵀ: C = D^-½ U⁻¹ [Aᵀ, I], so that A M⁻¹ Aᵀ = Cᵀ C."""
    from scipy.linalg.lapack import dtrtrs

    right = np.empty((rows.shape[1], rows.shape[0] + 1), order="F")
    right[:, :-1] = rows.T
    right[:, -1] = impulse
    half, _ = dtrtrs(data.U, right, unitdiag=1, overwrite_b=1)
    half /= np.sqrt(data.D)[:, None]
    return half


def _outcome(solution: BilateralSolution) -> Outcome:
    return Outcome(solution.impulse, solution.unique)
