"""Derivatives where all impulses are known: M Δv = I alone, the shortest way.

∂v⁺/∂q = −M⁻¹ ∂(M Δv − I)/∂q,    ∂v⁺/∂v = 1,    ∂v⁺/∂p = M⁻¹Jᵀ.
"""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from ..result import Impact
from .building import Builder
from .motion import Motion
from .regressor import inertia_regressor
from .result import Derivatives
from .status import DerivativeStatus
from .workspace import Workspace

__all__ = ["of_known_blows"]

_NONE: MappingProxyType = MappingProxyType({})


def of_known_blows(impact: Impact, workspace: Workspace) -> Derivatives:
    """The derivatives of an impact without constraints and touching contacts.

    Raises:
        InputError: the mass matrix is singular.
    """
    nv = workspace.model.nv
    q = workspace.configuration(impact.q)
    dv = np.array(impact.dv)
    motion = Motion(workspace.expanded, workspace.data, q)
    placed = [rows.placed(motion) for rows in workspace.blows]
    builder = Builder(workspace, motion, q, (), redundant=False)
    right = np.empty((nv, workspace.width_of_state - nv), order="F")
    right[:, :nv] = builder.load(dv, list(zip(placed, workspace.impulses, strict=True)))
    at = nv
    parts = []
    for name, rows in zip(workspace.blow_names, placed, strict=True):
        until = at + len(rows.matrix)
        right[:, at:until] = rows.matrix.T
        parts.append((name, at, until))
        at = until
    factor = builder.factor()
    table = factor.solve(right)
    table.setflags(write=False)

    def by_inertia(joint_id: int) -> np.ndarray:
        return -factor.solve(inertia_regressor(workspace, q, dv, joint_id))

    return Derivatives(
        impact,
        DerivativeStatus.EXISTS,
        (),
        table[:, :nv],
        workspace.identity,
        MappingProxyType({name: table[:, i:j] for name, i, j in parts}),
        _NONE,
        _NONE,
        _NONE,
        _NONE,
        by_inertia,
    )
