"""Derivatives where all impulses are known: M Δv = I alone, the shortest way.

∂v⁺/∂q = −M⁻¹ ∂(M Δv − I)/∂q,    ∂v⁺/∂v = 1,    ∂v⁺/∂p = M⁻¹Jᵀ.
"""

from __future__ import annotations

from types import MappingProxyType

import numpy as np
import pinocchio as pin

from ..result import Impact
from .factor import Factor
from .motion import Motion
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
    model, data, nv = workspace.model, workspace.data, workspace.model.nv
    q = workspace.configuration(impact.q)
    pin.computeJointJacobians(model, data, q)
    motion = Motion(workspace.tree, data)
    placed = [rows.placed(motion) for rows in workspace.blows]
    forces = workspace.no_forces()
    for rows, impulse in zip(placed, workspace.impulses, strict=True):
        rows.add_wrenches(forces, impulse)
    dv = np.array(impact.dv)
    by_q, _, masses = pin.computeRNEADerivatives(model, data, q, workspace.zero, dv, forces)
    width = nv + workspace.blow_rows
    right = np.empty((nv, width), order="F")
    np.negative(by_q.reshape(nv, nv), out=right[:, :nv])
    at = nv
    for rows, impulse in zip(placed, workspace.impulses, strict=True):
        part = rows.change_of_pull(impulse)
        if part is not None:
            right[:, :nv] += part
        right[:, at : at + len(rows.matrix)] = rows.matrix.T
        at += len(rows.matrix)
    factor = Factor(masses.reshape(nv, nv), np.zeros((0, nv)))
    table = factor.solve(right)
    table.setflags(write=False)
    by_impulse = {}
    at = nv
    for name, rows in zip(workspace.blow_names, placed, strict=True):
        by_impulse[name] = table[:, at : at + len(rows.matrix)]
        at += len(rows.matrix)

    def by_inertia(joint_id: int) -> np.ndarray:
        regressor = pin.computeJointTorqueRegressor(model, data, q, workspace.zero, dv)
        own = np.asarray(regressor).reshape(nv, -1)[:, 10 * (joint_id - 1) : 10 * joint_id]
        return -factor.solve(own)

    return Derivatives(
        impact,
        DerivativeStatus.EXISTS,
        (),
        table[:, :nv],
        workspace.identity,
        MappingProxyType(by_impulse),
        _NONE,
        _NONE,
        _NONE,
        _NONE,
        by_inertia,
    )
