"""The plan of a scene: its computations, their algorithms, and reasons."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ..robot.model_checks import check_capacity
from ..scene import Collision
from .singular import refuse_massless

if TYPE_CHECKING:
    from ..scene import Scene

__all__ = ["Plan", "needs_core", "plan_of", "reached_joints", "touched_joints"]

# [µs] on one 2.5 GHz core, fitted to chains and robots: ABA a joint; CRBA with Cholesky a joint,
# an entry of M that is not zero and the square of a depth. Only their ratios matter.
ABA_JOINT, ABA_TURNED = 0.224, 3.2
CRBA, CRBA_JOINT, CRBA_ENTRY, CRBA_SQUARE = 1.4, 0.07, 0.0073, 1.7e-4

# The error of CRBA with Cholesky grows with the depth of a chain, that of the
# articulated-body algorithm does not: beyond this depth accuracy decides.
DEEPEST_FOR_CRBA = 16


@dataclass(frozen=True)
class Plan:
    """The computations by which a scene is solved.

    Attributes:
        algorithm: "none" (nothing moves), "aba" or "crba" on Pinocchio, or "core".
        joints: how many joints are computed.
        skipped_joints: how many no impulse reaches.
        why: a sentence for each choice.
    """

    algorithm: str
    joints: int
    skipped_joints: int
    why: tuple[str, ...]


def plan_of(scene: Scene) -> Plan:
    """The plan for a scene.

    Raises:
        SingularMassError: a motion of a joint that is reached is without mass everywhere.
        RangeError: Pinocchio's data of the robot does not fit into memory.
    """
    robot, touched = scene.robot, touched_joints(scene)
    model = robot.model
    if not touched:
        return Plan("none", 0, model.njoints - 1, ("nothing acts: nothing moves",))
    reached = reached_joints(model, touched)
    skipped = model.njoints - 1 - len(reached)
    why = [f"{skipped} joints hang on the world apart from the impact: left out"] if skipped else []
    if not scene.held:
        refuse_massless(robot, [model.names[j] for j in reached])
    algorithm = "core"
    if not needs_core(scene):
        check_capacity(model)
        algorithm, reason = _cheaper_algorithm(scene, reached)
        why.append(reason)
    elif scene.held or scene.contacts:
        why.append(
            f"Delassus matrix of {len(scene.held)} constraints and {len(scene.contacts)} contacts"
        )
    elif len(model.mimicking_joints):
        why.append("dense mass matrix: Pinocchio's ABA and sparse Cholesky take no mimic joints")
    else:
        why.append("a joint has no inertia of its own, so pivots of the mass matrix are watched")
    return Plan(algorithm, len(reached), skipped, tuple(why))


def touched_joints(scene: Scene) -> set[int]:
    """The joints of the bodies that a scene strikes, holds or touches, without the world."""
    robot = scene.robot
    touched = set()
    for entry in (*scene.impulses, *scene.held, *scene.contacts):
        if getattr(entry, "of_whole_robot", False):
            return set(range(1, robot.model.njoints))
        touched |= {robot.model.frames[robot.frame_id(n)].parentJoint for n in entry.frame_names}
        touched |= {robot.joint_id(name) for name in entry.joint_names}
        if isinstance(entry, Collision):
            from ..robot.geometry import geometry_ids

            touched |= {geometry_ids(robot, name)[1] for name in (entry.first, entry.other)}
    return touched - {0}


def needs_core(scene: Scene) -> bool:
    """Return True if Pinocchio alone is not enough: rows, mimic joints, or M may be singular."""
    robot = scene.robot
    if scene.held or scene.contacts or len(robot.model.mimicking_joints):
        return True
    return bool(scene.impulses) and not robot.is_always_regular


def reached_joints(model: pin.Model, joints: Iterable[int]) -> list[int]:
    """All joints of the branches in which some lie: trees at the world do not feel each other."""
    branch = [0] * model.njoints
    parents = list(model.parents)
    for joint_id in range(1, model.njoints):
        branch[joint_id] = branch[parents[joint_id]] or joint_id
    reached = {branch[joint_id] for joint_id in joints} - {0}
    return [j for j in range(1, model.njoints) if branch[j] in reached]


def _cheaper_algorithm(scene: Scene, reached: list[int]) -> tuple[str, str]:
    """ "aba" or "crba" for M⁻¹Jᵀp on the joints that are reached, and why."""
    depths = _depths(scene.robot.model, reached)
    deepest, joints = int(depths.max(initial=0)), len(reached)
    if deepest > DEEPEST_FOR_CRBA:
        return "aba", f"ABA: a chain is {deepest} deep, where it keeps the most digits"
    aba = ABA_JOINT * joints + ABA_TURNED
    crba = CRBA + CRBA_JOINT * joints + CRBA_ENTRY * float(depths.sum())
    crba += CRBA_SQUARE * float((depths**2).sum())
    # Pinocchio's sparse Cholesky does not take a matrix of one row.
    if aba < crba or len(depths) < 2:
        return "aba", f"ABA: about {aba:.1f} against {crba:.1f} for CRBA with Cholesky"
    return "crba", f"CRBA with Cholesky: about {crba:.1f} against {aba:.1f} for ABA"


def _depths(model: pin.Model, reached: list[int]) -> np.ndarray:
    """(k,) for each degree of freedom, how many stand on its way to the world, itself included."""
    depth_of_joint = [0] * model.njoints
    depths: list[int] = []
    for joint_id in reached:
        above = depth_of_joint[model.parents[joint_id]]
        size = model.nvs[joint_id]
        depths.extend(range(above + 1, above + size + 1))
        depth_of_joint[joint_id] = above + size
    return np.array(depths, dtype=float)
