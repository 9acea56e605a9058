"""The mass matrix under bilateral rows, and how bodies respond to impulses on points there.

With C = L⁻¹ Aᵀ of the rows and C_p of the points, Δv = L⁻ᵀ of what is left of C_p off the span
of C: impacts, their derivatives, and what is looked for beside an answer see the same freedom.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pinocchio as pin

from .._core import ConstrainedMass
from .singular import singular_joints, singular_mass

if TYPE_CHECKING:
    from .flat.scene import FlatScene

__all__ = ["CONTRADICTION", "Responses", "constrained_mass"]

# What dependent rows may disagree by, relative to the velocities they speak of.
CONTRADICTION = 1e-6


def constrained_mass(
    model: pin.Model,
    flat: FlatScene,
    masses: np.ndarray,
    rows: np.ndarray,
    wider: np.ndarray | None = None,
) -> ConstrainedMass:
    """M (nv, nv) factored under bilateral rows A (m, nv) of a scene.

    ``wider``: (m,) by how much each vector is longer than its longest row; None for 1.

    Raises:
        SingularMassError: M is singular, and the rows do not make up for what it lacks.
    """
    found = ConstrainedMass(
        np.ascontiguousarray(masses), flat.model.core.parents, np.ascontiguousarray(rows),
        list(flat.vectors), wider,
    )  # fmt: skip
    if found.weak >= 0:
        rows = rows.reshape(-1, model.nv)
        raise singular_mass(model, singular_joints(model, masses, rows))
    return found


class Responses(NamedTuple):
    """Responses to unit impulses on points under bilateral constraints.

    Attributes:
        velocity_changes: (nv, 3n) Δv.
        multipliers: (m, 3n) λ.
        delassus: (3n, 3n) W [1/kg].
    """

    velocity_changes: np.ndarray
    multipliers: np.ndarray
    delassus: np.ndarray

    @classmethod
    def of(cls, held: ConstrainedMass, points: np.ndarray) -> Responses:
        """The responses to impulses on points' rows (3n, nv)."""
        count, nv = points.shape
        found = held.respond(np.ascontiguousarray(points))
        size = len(found.multipliers) // max(count, 1)
        return cls(
            found.velocity_changes.reshape(count, nv).T,
            found.multipliers.reshape(count, size).T,
            found.W.reshape(count, count),
        )
