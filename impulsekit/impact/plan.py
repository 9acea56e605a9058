"""The plan of a scene: its computations, their algorithms, and reasons."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import pinocchio as pin

from ..scene import Collision
from .singular import refuse_massless

if TYPE_CHECKING:
    from ..scene import Scene

__all__ = ["Plan", "needs_rows", "plan_of"]


@dataclass(frozen=True)
class Plan:
    """The computations by which a scene is solved.

    Attributes:
        algorithm: "none" (nothing moves), "articulated" (M Δv = I by articulated inertias), or
            "rows" (with the matrices of mass, constraints and contacts).
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
    """
    robot, touched = scene.robot, _touched_joints(scene)
    model = robot.model
    if not touched:
        return Plan("none", 0, model.njoints - 1, ("nothing acts: nothing moves",))
    reached = _reached_joints(model, touched)
    skipped = model.njoints - 1 - len(reached)
    why = [f"{skipped} joints hang on the world apart from the impact: left out"] if skipped else []
    if not scene.held:
        refuse_massless(robot, [model.names[j] for j in reached])
    algorithm = "rows"
    if not needs_rows(scene):
        algorithm = "articulated"
        why.append("known impulses on a tree: articulated inertias, O(n)")
    elif scene.held or scene.contacts:
        why.append(
            f"Delassus matrix of {len(scene.held)} constraints and {len(scene.contacts)} contacts"
        )
    elif len(model.mimicking_joints):
        why.append("dense mass matrix: articulated inertias take no mimic joints")
    else:
        why.append("a joint has no inertia of its own, so pivots of the mass matrix are watched")
    return Plan(algorithm, len(reached), skipped, tuple(why))


def _touched_joints(scene: Scene) -> set[int]:
    """The joints of the bodies that a scene strikes, holds or touches, without the world."""
    robot = scene.robot
    touched = set()
    for entry in (*scene.impulses, *scene.held, *scene.contacts):
        if getattr(entry, "of_whole_robot", False):
            return set(range(1, robot.model.njoints))
        touched |= {robot.frame(name).joint_id for name in entry.frame_names}
        touched |= {robot.joint_id(name) for name in entry.joint_names}
        if isinstance(entry, Collision):
            from ..robot.geometry import geometry_ids

            touched |= {geometry_ids(robot, name)[1] for name in (entry.first, entry.other)}
    return touched - {0}


def needs_rows(scene: Scene) -> bool:
    """Return True if articulated inertias do not do: rows, mimic joints, or M may be singular."""
    robot = scene.robot
    if scene.held or scene.contacts or len(robot.model.mimicking_joints):
        return True
    return bool(scene.impulses) and not robot.is_always_regular


def _reached_joints(model: pin.Model, joints: Iterable[int]) -> list[int]:
    """All joints of the branches in which some lie: trees at the world do not feel each other."""
    branch = [0] * model.njoints
    parents = list(model.parents)
    for joint_id in range(1, model.njoints):
        branch[joint_id] = branch[parents[joint_id]] or joint_id
    reached = {branch[joint_id] for joint_id in joints} - {0}
    return [j for j in range(1, model.njoints) if branch[j] in reached]
