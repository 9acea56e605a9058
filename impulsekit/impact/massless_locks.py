"""What locks carry of joints that move no mass."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ..rows.constraints import ConstraintRows
    from .outcome import Outcome

__all__ = ["with_massless_locks"]


def with_massless_locks(
    outcome: Outcome,
    of_scene: ConstraintRows,
    rows: np.ndarray,
    struck: np.ndarray,
    mass_matrix: np.ndarray,
) -> Outcome:
    """The outcome with the impulses of locks on joints whose row of M is zero.

    There 0 = I + Aᵀλ + JᵀP says what a lock carries: all else that acts in the joint. Out of the
    Delassus matrix λ would be the rounding of what other rows carry.

    Args:
        of_scene: the rows by constraint.
        rows: (m, nv) A.
        struck: (nv,) I of the known impulses.
        mass_matrix: (nv, nv) M, its upper triangle.
    """
    upper = np.triu(np.atleast_2d(mass_matrix)) != 0.0
    moves = np.logical_or(np.logical_or.reduce(upper, axis=0), np.logical_or.reduce(upper, axis=1))
    multipliers, acting = outcome.constraint_impulses.copy(), struck
    if outcome.contacts is not None:
        jacobian = np.concatenate([touch.jacobian for touch in outcome.touches])
        acting = struck + outcome.contacts.impulse.dot(jacobian)
    for dof, row in zip(*of_scene.prescribed, strict=True):
        if not moves[dof] and (outcome.unique is None or outcome.unique[row]):
            multipliers[row] = 0.0
            multipliers[row] = -(acting + multipliers.dot(rows))[dof] / rows[row, dof]
    return replace(outcome, constraint_impulses=multipliers)
