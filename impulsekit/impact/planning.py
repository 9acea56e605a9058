"""Which algorithm a scene takes, on which part of its robot."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..robot.masses import is_always_regular
from ..robot.model_checks import check_capacity
from ..rows.origin import Places
from ..rows.reach import ReachedModel, reached_model, touched_joints
from .algorithms import ByAba, ByCrba, ByDenseCholesky, Rescaled
from .known import KnownImpulses
from .plan import Plan, cheaper_algorithm
from .singular import refuse_massless

if TYPE_CHECKING:
    from ..scene import Scene

__all__ = ["planned", "reached_by"]


def reached_by(scene: Scene) -> ReachedModel:
    """The part of the robot that a scene's impulses, constraints and contacts reach."""
    places = Places.NONE
    if scene.held or scene.contacts:
        from ..rows.constraints import needs_places

        places = needs_places(scene.robot, scene)
    return reached_model(scene.robot.model, touched_joints(scene), keep_places=places)


def planned(scene: Scene) -> tuple[Any, Plan, Any]:
    """The algorithm for a scene, the plan that tells of it, and the model it works on."""
    robot = scene.robot
    touched = touched_joints(scene)
    if not touched:
        skipped = robot.model.njoints - 1
        return None, Plan("none", 0, skipped, True, ("nothing acts: nothing moves",)), None
    reached = reached_by(scene)
    check_capacity(reached.model)
    joints = reached.model.njoints - 1
    skipped = robot.model.njoints - 1 - joints
    why = [f"{skipped} joints hang on the world apart from the impact: left out"] if skipped else []
    alone = not (scene.held or scene.contacts)
    known = KnownImpulses(scene, reached, alone=alone)
    regular = is_always_regular(reached.model)
    if not (regular or scene.held):
        refuse_massless(robot, reached.model.names)
    algorithm: Any
    if scene.held or scene.contacts:
        from .constrained import ConstrainedJump

        name = "delassus"
        why.append(
            f"Delassus matrix of {len(scene.held)} constraints and {len(scene.contacts)} "
            "contacts, on CRBA with Cholesky"
        )
        algorithm = ConstrainedJump(scene, known, reached)
    elif any(joint.shortname() == "JointModelMimic" for joint in reached.model.joints):
        name = "dense"
        why.append("dense Cholesky: Pinocchio's ABA and sparse Cholesky take no mimic joints")
        algorithm = ByDenseCholesky(known)
    elif not regular:
        name = "crba"
        why.append("CRBA with Cholesky: a joint has no inertia of its own, so pivots are watched")
        algorithm = ByCrba(known, always_regular=False)
    else:
        in_world_axes = sum(blow.axes == "world" for blow in known.blows)
        name, reason = cheaper_algorithm(reached.model, in_world_axes)
        why.append(reason)
        algorithm = ByAba(known) if name == "aba" else ByCrba(known, always_regular=True)
    if known.unit != 1.0:
        algorithm = Rescaled(algorithm, known.unit)
        why.append("impulses brought near 1 by a power of two: their products would not be doubles")
    return algorithm, Plan(name, joints, skipped, regular, tuple(why)), reached
