"""Δv with bilateral constraints and contacts: M Δv = I + Aᵀλ + JᵀP, A v⁺ = b, P by law.

Pinocchio gives M (CRBA) and the Jacobians of the rows; the core eliminates the bilateral rows,
solves the law of contact in what is left, and brings all of it back to Δv.
"""

from __future__ import annotations

from collections.abc import Callable, Container
from functools import partial
from typing import Any

import numpy as np
import pinocchio as pin

from .._core import ImpactPlan, ImpactSolution
from ..errors import InputError
from ..robot.masses import crba_of
from ..rows.constraints import ConstraintRows
from ..rows.contacts import Touch
from ..rows.reach import ReachedModel
from ..scene import Scene
from .contact_law import ContactSolution, FrictionModel, law_codes
from .elimination import refuse_contradiction
from .known import KnownImpulses
from .outcome import Outcome
from .scene_contacts import SceneContacts
from .singular import singular_joints, singular_mass

__all__ = ["ConstrainedJump", "dof_parents"]

_SINGULAR, _CONTRADICTION, _REFUSED = 1, 2, 3


def dof_parents(model: pin.Model) -> list[int]:
    """Return by degree of freedom the one that it hangs on, −1 for none: where M is not zero."""
    if len(model.mimicking_joints):
        return list(range(-1, model.nv - 1))
    parents = [-1] * model.nv
    last = [-1] * model.njoints
    for joint_id in range(1, model.njoints):
        first, count = model.idx_vs[joint_id], model.nvs[joint_id]
        above = last[model.parents[joint_id]]
        for k in range(first, first + count):
            parents[k], above = above, k
        last[joint_id] = above
    return parents


class ConstrainedJump:
    """Δv under bilateral rows and contacts.

    Attributes:
        model, data: of the part of the robot that is reached.
    """

    def __init__(self, scene: Scene, known: KnownImpulses, reached: ReachedModel) -> None:
        self._known = known if scene.impulses else None
        self._rows = ConstraintRows.of(scene, reached) if scene.held else None
        self._contacts = SceneContacts(scene, reached) if scene.contacts else None
        self.model, self.data = known.model, known.model.createData()
        self._crba = crba_of(self.model)
        vectors: list[int] = []
        locks: list[int] = []
        passive: list[bool] = []
        if self._rows is not None:
            vectors, passive = list(self._rows.triples), self._rows.passive.tolist()
            locks = [-1] * len(vectors)
            if self._rows.prescribed:
                for dof, row in zip(*self._rows.prescribed, strict=True):
                    locks[row] = dof
        self._plan = ImpactPlan(
            dof_parents(self.model), vectors, locks, passive, *law_codes(scene.law)
        )

    def solve(
        self, q: np.ndarray, v: np.ndarray, touching: Container[int] | None = None
    ) -> tuple[np.ndarray, Callable[[], Outcome]]:
        """(nv,) Δv of the reached model, and a call that gives the rest of the outcome.

        ``touching``: the indices of the contacts that take part; None for all that touch.

        Raises:
            ContradictionError: dependent rows demand different things.
            SingularMassError: M is singular and the constraints do not make up for it.
            InputError, RangeError: what the contact law refuses.
        """
        model, data = self.model, self.data
        impulse = None if self._known is None else self._known.generalized_impulse(data, q)
        rows = target = jacobian = None
        doubt = False
        if self._rows is not None:
            rows, doubt = self._rows.matrix_and_doubt(data, q)
            target = self._rows.target(rows.dot(v))
        touches = [] if self._contacts is None else self._contacts.rows.touching(data, q, touching)
        coefficients: tuple[Any, ...] = ()
        models: list[FrictionModel] = []
        if touches:
            jacobian = np.concatenate([touch.jacobian for touch in touches])
            coefficients, models = self._contacts_of(touches, jacobian, v)
        # Pinocchio fills the upper triangle, column by column: the lower one, row by row.
        masses = np.atleast_2d(self._crba(model, data, q)).T
        found = self._plan.solve(masses, v, impulse, rows, target, jacobian, coefficients, models)
        if found.failure:
            self._refuse(found, masses, rows)
        return found.dv, partial(_outcome, found, tuple(touches), doubt)

    def touching(self, q: np.ndarray, only: Container[int]) -> tuple[Touch, ...]:
        """The touching points of some contacts at q (nq,) of the reached model."""
        if self._contacts is None:
            return ()
        return tuple(self._contacts.rows.touching(self.data, q, only))

    def _contacts_of(
        self, touches: list[Touch], jacobian: np.ndarray, v: np.ndarray
    ) -> tuple[tuple, list]:
        if self._contacts is None:
            raise InputError("no contacts")
        return self._contacts.coefficients(touches, jacobian, v)

    def _refuse(self, found: ImpactSolution, masses: np.ndarray, rows: np.ndarray | None) -> None:
        """Raise the error of an impact that has no answer."""
        if found.failure == _REFUSED:
            raise InputError(found.refused)
        if found.failure == _SINGULAR:
            raise singular_mass(self.model, singular_joints(self.model, masses, rows))
        names = [] if self._rows is None else self._rows.names
        raise refuse_contradiction([names[i] for i in found.failed], found.apart)


def _outcome(found: ImpactSolution, touches: tuple[Touch, ...], doubt: bool) -> Outcome:
    """What an impact found besides Δv."""
    unique = found.unique.astype(bool)
    return Outcome(
        found.multipliers,
        None if unique.all() else unique,
        touches,
        ContactSolution.of(found) if touches else None,
        doubt or found.nearly_dependent,
        (found.momentum_residual, found.constraint_residual, found.contact_residual),
    )
