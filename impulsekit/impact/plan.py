"""What a scene needs computed, and by which algorithm: decided once per scene."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

__all__ = ["Plan", "cheaper_algorithm"]

# [µs] on one 2.5 GHz core, fitted to chains and robots: ABA a joint; CRBA with Cholesky a joint,
# an entry of M that is not zero and the square of a depth. Only their ratios matter.
ABA_JOINT = 0.224
CRBA_JOINT, CRBA_ENTRY, CRBA_SQUARE = 0.07, 0.0073, 1.7e-4

# The error of CRBA with Cholesky grows with the depth of a chain, that of the
# articulated-body algorithm does not: beyond this depth accuracy decides.
DEEPEST_FOR_CRBA = 16


@dataclass(frozen=True)
class Plan:
    """How a scene is solved.

    Attributes:
        algorithm: "none" (nothing moves), "aba", "crba", or "dense" (mimic joints).
        joints: how many joints are computed.
        skipped_joints: how many no impulse reaches.
        always_regular: True where M is regular at every configuration, because every
            joint moves inertia of its own; then no solve has to look.
        why: a sentence for each choice.
    """

    algorithm: str
    joints: int
    skipped_joints: int
    always_regular: bool
    why: tuple[str, ...]


def cheaper_algorithm(model: pin.Model, blows_in_world_axes: int) -> tuple[str, str]:
    """ "aba" or "crba" for M⁻¹Jᵀp on this model, and why.

    The costs are in microseconds on one 2.5 GHz core, fitted to chains and robots;
    only their ratio matters.
    """
    depths = _depths(model)
    deepest = int(depths.max(initial=0))
    if deepest > DEEPEST_FOR_CRBA:
        return "aba", f"ABA: a chain is {deepest} deep, where it keeps the most digits"
    nonzeros, squares = float(depths.sum()), float((depths**2).sum())
    aba = ABA_JOINT * model.njoints + (
        1.0 + 2.2 * blows_in_world_axes if blows_in_world_axes else 0.0
    )
    crba = CRBA_JOINT * model.njoints + CRBA_ENTRY * nonzeros + CRBA_SQUARE * squares + 1.4
    if aba < crba:
        return "aba", f"ABA: about {aba:.1f} against {crba:.1f} for CRBA with Cholesky"
    return "crba", f"CRBA with Cholesky: about {crba:.1f} against {aba:.1f} for ABA"


def _depths(model: pin.Model) -> np.ndarray:
    """(nv,) for each degree of freedom, how many stand on its way to the world, itself included."""
    depth_of_joint = [0] * model.njoints
    depths: list[int] = []
    for joint_id in range(1, model.njoints):
        above = depth_of_joint[model.parents[joint_id]]
        size = model.joints[joint_id].nv
        depths.extend(range(above + 1, above + size + 1))
        depth_of_joint[joint_id] = above + size
    return np.array(depths, dtype=float)
