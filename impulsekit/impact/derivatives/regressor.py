"""How M Δv changes with the inertia of one body."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from .workspace import Workspace

__all__ = ["inertia_regressor"]


def inertia_regressor(
    workspace: Workspace, q: np.ndarray, change: np.ndarray, joint_id: int
) -> np.ndarray:
    """(nv, 10) ∂(M Δv) by the dynamic parameters of the body behind a joint.

    Args:
        q: of the expanded model. change: (nv,) Δv.
    """
    expanded = workspace.expanded
    regressor = pin.computeJointTorqueRegressor(
        expanded.model, workspace.data, q, expanded.still, expanded.speeds(change)
    )
    at = 10 * (expanded.joint_ids[joint_id] - 1)
    own = np.asarray(regressor).reshape(len(expanded.still), -1)[:, at : at + 10]
    return expanded.rows(own)
