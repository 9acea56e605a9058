"""Kinds of entries of a scene, and those that a robot's own file gives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal, TypeAlias, TypedDict

from ..errors import InputError, warn_of_setup
from ..robot import Robot
from ..robot.source import Loop
from .constraints import (
    DIRECTIONS,
    DistanceAnchor,
    FrameAnchor,
    JointCoupling,
    JointLock,
    PointAnchor,
)
from .contacts import Collision, Contact, JointStop, Rope
from .driven import Driven
from .forces import JointFriction, JointSpring
from .gap_functions import GapConstraint, GapContact
from .impulses import AppliedImpulse, JointImpulse
from .law import Law
from .numbers import choice
from .overlaps import overlaps, sentence_on

if TYPE_CHECKING:
    import numpy as np

    from ..robot.mjcf_shapes import TouchingPair
    from .forces import Force
    from .materials import Material, MaterialPair
    from .numbers import Vector

Constraint: TypeAlias = (
    PointAnchor | FrameAnchor | DistanceAnchor | JointLock | JointCoupling | Driven | GapConstraint
)
ContactEntry: TypeAlias = Contact | JointStop | Collision | Rope | GapContact

# The direction that a closing joint leaves free, z along its axis.
_FREE = {"hinge": "rz", "slide": "z"}


class SceneEntries(TypedDict, total=False):
    """Arguments of ``Scene`` besides the robot, for editors."""

    impulses: Sequence[AppliedImpulse | JointImpulse]
    constraints: Sequence[Constraint]
    contacts: Sequence[ContactEntry]
    forces: Sequence[Force]
    law: Law
    gravity: Vector
    gap_bound: float
    controlled: Sequence[str]
    materials: Sequence[Material | MaterialPair]
    collisions: Literal["all"] | None


def constraints_of_file(robot: Robot) -> list[Constraint]:
    """Return the equality constraints of a robot's file."""
    return [_constraint(loop) for loop in robot.loops]


def contacts_of_file(
    robot: Robot, file_contacts: bool | str, restitution: float, *, turning: bool
) -> list[Collision]:
    """Return the collisions of a robot's file; the arguments are those of ``Scene.of_robot``."""
    if file_contacts is False:
        return []
    which = choice("all", "world")(
        "all" if file_contacts is True else file_contacts, "file_contacts"
    )
    pairs = [pair for pair in robot.touching_pairs if pair.fixed or which == "all"]
    overlapping = overlaps(robot, [(pair.first, pair.second) for pair in pairs])
    warn_of_setup(sentence_on(overlapping))
    return [
        _collision(pair, restitution, turning=turning)
        for pair in pairs
        if (pair.first, pair.second) not in overlapping
    ]


def _collision(pair: TouchingPair, restitution: float, *, turning: bool) -> Collision:
    rolling, torsion = (pair.rolling, pair.torsion) if turning else (0.0, 0.0)
    if pair.uneven:
        raise InputError(
            f'the file\'s friction of "{pair.first}" and "{pair.second}" differs between the two '
            "tangents of MuJoCo's contact frame, whose directions are not in the file; give "
            "file_contacts=False and a Collision with friction=EllipticFriction(...)"
        )
    return Collision(
        pair.first,
        pair.second,
        restitution=restitution,
        friction=pair.friction,
        rolling=rolling,
        torsion=torsion,
    )


def forces_of_file(robot: Robot, *, damping: bool, friction: bool) -> list[Force]:
    """Return the damping and the dry friction of a robot's joints, as far as they are asked for."""
    found: list[Force] = []
    if damping:
        damped = _by_joint(robot, robot.model.damping)
        found += [JointSpring(name, damping=value) for name, value in damped]
    if friction:
        rubbing = _by_joint(robot, robot.model.upperDryFrictionLimit)
        found += [JointFriction(name, value) for name, value in rubbing]
    return found


def _by_joint(robot: Robot, values: np.ndarray) -> list[tuple[str, float]]:
    """Joints of one degree of freedom and their entries of (nv,) values, where above 0."""
    joints = ((name, robot.model.joints[robot.joint_id(name)]) for name in robot.joint_names)
    found = [(name, float(values[joint.idx_v])) for name, joint in joints if joint.nv == 1]
    return [(name, value) for name, value in found if value > 0.0]


def _constraint(loop: Loop) -> Constraint:
    if loop.kind == "point":
        return PointAnchor(loop.first, loop.second, loop.at, loop.other_at, name=loop.name)
    if loop.kind == "frame":
        return FrameAnchor(loop.first, loop.second, loop.at, loop.other_at, name=loop.name)
    if loop.kind in _FREE:
        ends = loop.first, loop.second, loop.at, loop.other_at
        held = tuple(each for each in DIRECTIONS if each != _FREE[loop.kind])
        return FrameAnchor(*ends, held, "local", name=loop.name)
    if loop.kind == "lock":
        return JointLock(loop.first, name=loop.name)
    return JointCoupling(loop.first, loop.second, loop.ratio, name=loop.name)
