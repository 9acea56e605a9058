"""Δv with bilateral constraints and contacts: M Δv = I + Aᵀλ + JᵀP, A v⁺ = b, P by law.

λ comes from W λ = b − A v_free with the Delassus matrix W = A M⁻¹ Aᵀ. Contacts see a
system from which the bilateral rows are eliminated: their own Delassus matrix is that
of the rows J projected off the span of A in the metric of M⁻¹.
"""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from ..scene import Scene
from ..scene.restitution import restitution_at
from .algorithms import crba, decompose
from .bilateral import RANK_TOLERANCE, BilateralSolution, solve_bilateral
from .factor import FilledFactor, SparseFactor, pivots_are_safe
from .known import KnownImpulses
from .reach import ReachedModel
from .rows import ConstraintRows
from .touching import ContactRows, Touch

if TYPE_CHECKING:
    from .laws import ContactSolution

__all__ = ["ConstrainedJump", "Outcome"]


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a solve found besides Δv.

    Attributes:
        constraint_impulses: (m,) λ by row of the bilateral constraints.
        unique: (m,) whether each is determined; None where all are.
        touches: the points at which contacts touched.
        contacts: the impulses there, by the law; None where nothing touched.
    """

    constraint_impulses: np.ndarray
    unique: np.ndarray | None
    touches: tuple[Touch, ...] = ()
    contacts: ContactSolution | None = None


class ConstrainedJump:
    """Δv under bilateral rows and contacts, on CRBA with Cholesky."""

    def __init__(
        self, scene: Scene, known: KnownImpulses, reached: ReachedModel, *, always_regular: bool
    ) -> None:
        self._known = known
        self._rows = ConstraintRows.of(scene, reached) if scene.constraints else None
        self._contacts = _Contacts(scene, reached) if scene.contacts else None
        self._model, self._data = known.model, known.model.createData()
        self._always_regular = always_regular
        # Pinocchio's sparse Cholesky takes neither mimic joints nor a model with one row.
        self._dense = self._model.nv < 2 or any(
            joint.shortname() == "JointModelMimic" for joint in self._model.joints
        )

    def solve(
        self, q: np.ndarray, v: np.ndarray, touching: Container[int] | None = None
    ) -> tuple[np.ndarray, Outcome]:
        """(nv,) Δv of the reached model, and the impulses that constraints and contacts took.

        ``touching``: the indices of the contacts that take part; None for all that touch.

        Raises:
            ContradictionError: dependent rows demand different things.
            SingularMassError: M is singular and the constraints do not make up for it.
            InputError, RangeError: what the contact law refuses.
        """
        model, data = self._model, self._data
        impulse = self._known.generalized_impulse(data, q)
        rows = wanted = None
        if self._rows is not None:
            rows = self._rows.matrix(data, q)
            before = rows.dot(v)
            wanted = self._rows.target(before) - before
        touches = [] if self._contacts is None else self._contacts.rows.touching(data, q, touching)
        crba(model, data, q)
        factor: SparseFactor | FilledFactor | None = None
        if not self._dense:
            decompose(model, data)
            if self._always_regular or pivots_are_safe(data):
                factor = SparseFactor(model, data)
        if factor is None:
            factor = FilledFactor(model, data.M, np.empty((0, model.nv)) if rows is None else rows)
            if wanted is not None:
                impulse = factor.filled_impulse(impulse, wanted)
        if not touches:
            return self._without_contacts(factor, impulse, rows, wanted, q, v)
        return self._with_contacts(factor, impulse, rows, wanted, touches, q, v)

    def _without_contacts(
        self,
        factor: SparseFactor | FilledFactor,
        impulse: np.ndarray,
        rows: np.ndarray | None,
        wanted: np.ndarray | None,
        q: np.ndarray,
        v: np.ndarray,
    ) -> tuple[np.ndarray, Outcome]:
        if rows is None or wanted is None:
            return factor.solve(impulse), Outcome(np.empty(0), None)
        half = factor.half(rows, impulse[None])
        solution = self._multipliers(half[:, :-1], half[:, -1], wanted, q, v)
        dv = factor.solve(impulse + solution.impulse.dot(rows))
        return dv, Outcome(solution.impulse, solution.unique)

    def _with_contacts(
        self,
        factor: SparseFactor | FilledFactor,
        impulse: np.ndarray,
        rows: np.ndarray | None,
        wanted: np.ndarray | None,
        touches: list[Touch],
        q: np.ndarray,
        v: np.ndarray,
    ) -> tuple[np.ndarray, Outcome]:
        """Contacts in the system that is left when the bilateral rows are eliminated."""
        contacts = self._contacts
        if contacts is None:
            raise InputError("no contacts")
        jacobian = (
            touches[0].jacobian if len(touches) == 1 else np.vstack([t.jacobian for t in touches])
        )
        before = jacobian.dot(v)
        if rows is None or wanted is None:
            half = factor.half(jacobian, impulse[None])
            half_contacts = half[:, :-1]
            free = before + half[:, -1].dot(half_contacts)
            solution = contacts.solve(half_contacts, before, free, touches)
            dv = factor.solve(impulse + solution.impulse.dot(jacobian))
            return dv, Outcome(np.empty(0), None, tuple(touches), solution)
        count = len(rows)
        half = factor.half(rows, jacobian, impulse[None])
        half_rows, half_contacts, start = half[:, :count], half[:, count:-1], half[:, -1]
        held = self._multipliers(half_rows, start, wanted, q, v)
        # Rows that are imposed move the contact points, too.
        free = before + (start + half_rows.dot(held.impulse)).dot(half_contacts)
        basis = _range_of(half_rows)
        left = half_contacts - basis.dot(basis.T.dot(half_contacts))
        solution = contacts.solve(left, before, free, touches)
        # What the bilateral rows bear of the contacts' impulses.
        change = half_rows.T.dot(left.dot(solution.impulse) - half_contacts.dot(solution.impulse))
        borne = self._multipliers(half_rows, np.zeros(len(start)), change, q, v)
        multipliers = held.impulse + borne.impulse
        dv = factor.solve(impulse + multipliers.dot(rows) + solution.impulse.dot(jacobian))
        return dv, Outcome(multipliers, held.unique, tuple(touches), solution)

    def _multipliers(
        self,
        half_rows: np.ndarray,
        start: np.ndarray,
        wanted: np.ndarray,
        q: np.ndarray,
        v: np.ndarray,
    ) -> BilateralSolution:
        """λ that brings the rows from where ``start`` (half-solved impulse) leaves them."""
        data, rows = self._data, self._rows
        if rows is None:
            raise InputError("no constraints")

        def magnitude() -> np.ndarray:
            gross = rows.magnitude(data, q)
            masses = np.diagonal(np.atleast_2d(data.M))
            return (gross**2) @ (1.0 / np.maximum(masses, 1e-12 * masses.max()))

        def velocity_scale() -> np.ndarray:
            gross = rows.magnitude(data, q)
            return gross @ np.abs(v) + np.abs(half_rows.T @ start)

        right = wanted - start.dot(half_rows)
        return solve_bilateral(half_rows, right, magnitude, velocity_scale, rows.names)


class _Contacts:
    """The contacts of a scene: rows, coefficients and law."""

    def __init__(self, scene: Scene, reached: ReachedModel) -> None:
        from .laws import ContactProblem, solve_contacts

        self._problem, self._solve = ContactProblem, solve_contacts
        self.rows = ContactRows(scene, reached)
        self._law = scene.law
        self._restitution = [entry.restitution for entry in scene.contacts]
        self._varying = any(callable(e) for e in self._restitution)
        self._names = scene.entry_names("contacts")
        self._friction = np.array([getattr(entry, "friction", 0.0) for entry in scene.contacts])
        self._tangential = np.array(
            [getattr(entry, "tangential_restitution", 0.0) for entry in scene.contacts]
        )
        self._fixed = None if self._varying else np.array(self._restitution, dtype=float)

    def solve(
        self, half: np.ndarray, before: np.ndarray, free: np.ndarray, touches: list[Touch]
    ) -> ContactSolution:
        """P by the law, for rows half-solved (nv, 3n) and velocities (3n,) before and free."""
        entries = [touch.entry for touch in touches]
        problem = self._problem(
            delassus=half.T.dot(half),
            velocity_before=before,
            velocity_free=free,
            restitution=self._coefficients(entries, before),
            friction=self._friction[entries],
            tangential_restitution=self._tangential[entries],
        )
        return self._solve(problem, self._law)

    def _coefficients(self, entries: list[int], before: np.ndarray) -> np.ndarray:
        if self._fixed is not None:
            return self._fixed[entries]
        approach = np.maximum(-before[2::3], 0.0)
        return np.array(
            [
                restitution_at(
                    self._restitution[entry], float(speed), f"{self._names[entry]}: restitution"
                )
                for entry, speed in zip(entries, approach, strict=True)
            ]
        )


def _range_of(half_rows: np.ndarray) -> np.ndarray:
    """(nv, r) an orthonormal basis of what the bilateral rows span."""
    sizes = np.sqrt(np.einsum("ij,ij->j", half_rows, half_rows))
    live = sizes > 1e-11 * sizes.max(initial=0.0)
    left, values, _ = np.linalg.svd(half_rows[:, live] / sizes[live], full_matrices=False)
    return left[:, values > RANK_TOLERANCE]
