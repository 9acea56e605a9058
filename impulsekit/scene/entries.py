"""Kinds of constraints and contacts of a scene, and the proof that they fit a robot."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

from ..errors import InputError, ShapeError, a_thing
from ..robot import Robot
from .constraints import FrameAnchor, JointCoupling, JointLock, PointAnchor
from .contacts import Collision, Contact, JointStop
from .distances import KEPT_ANYWAY, DistanceAnchor, Rope
from .driven import Driven
from .gap_functions import GapConstraint, GapContact, check_gradient
from .validation import check_one_degree, check_two_bodies

HOLDS_NOTHING = "an anchor between them holds nothing"

Constraint: TypeAlias = (
    PointAnchor | FrameAnchor | DistanceAnchor | JointLock | JointCoupling | Driven | GapConstraint
)


def check_constraint(robot: Robot, constraint: Any, where: str) -> None:
    """Prove that a constraint fits a robot.

    Raises:
        UnknownNameError: a frame or joint that the robot does not have.
        InputError: an anchor within one rigid body, a coupling of a joint with several
            degrees of freedom, or something that is no constraint.
        ShapeError: a lock whose velocity does not have the joint's length.
    """
    if isinstance(constraint, GapConstraint):
        check_gradient(robot, constraint, where)
    elif isinstance(constraint, DistanceAnchor):
        check_two_bodies(robot, constraint.frame_names, where, KEPT_ANYWAY)
    elif isinstance(constraint, Driven):
        check_one_degree(robot, constraint.joint, where, "a Driven")
    elif isinstance(constraint, PointAnchor | FrameAnchor):
        check_two_bodies(robot, constraint.frame_names, where, HOLDS_NOTHING)
    elif isinstance(constraint, JointLock):
        joint = robot.model.joints[robot.joint_id(constraint.joint, where)]
        if isinstance(constraint.velocity, tuple) and len(constraint.velocity) != joint.nv:
            what = f'{where}: velocity of joint "{constraint.joint}"'
            raise ShapeError.of(what, (joint.nv,), (len(constraint.velocity),))
    elif isinstance(constraint, JointCoupling):
        for name in (constraint.joint, *constraint.other):
            check_one_degree(robot, name, where, "a JointCoupling")
    else:
        raise InputError(
            f"{where} must be a PointAnchor, FrameAnchor, DistanceAnchor, JointLock, "
            f"JointCoupling, Driven or GapConstraint, "
            f"got {a_thing(constraint)}"
        )


def check_controlled(
    robot: Robot, controlled: Sequence[str], constraints: Sequence[Constraint]
) -> None:
    """Prove that a robot has these joints, each named once and none of them locked as well.

    Raises:
        UnknownNameError: a joint that the robot does not have.
        InputError: a fixed joint, one that is named twice, or locked by a constraint.
    """
    locked = [entry.joint for entry in constraints if isinstance(entry, JointLock | Driven)]
    for i, name in enumerate(controlled):
        robot.joint_id(name, f"controlled[{i}]")
        if name in controlled[:i]:
            raise InputError(f'controlled[{i}]: joint "{name}" is named twice')
        if name in locked:
            raise InputError(
                f'controlled[{i}]: a JointLock holds joint "{name}" already; '
                "leave one of the two out"
            )


ContactEntry: TypeAlias = Contact | JointStop | Collision | Rope | GapContact


def check_contact(robot: Robot, contact: Any, where: str) -> None:
    """Prove that a contact fits a robot.

    Raises:
        UnknownNameError: a frame, joint or piece of geometry that the robot does not have.
        InputError: a contact within one rigid body, a stop of a joint that has no limit
            or more than one coordinate, or something that is no contact.
    """
    if isinstance(contact, GapContact):
        check_gradient(robot, contact, where)
    elif isinstance(contact, Rope):
        check_two_bodies(robot, contact.frame_names, where, KEPT_ANYWAY)
    elif isinstance(contact, Contact):
        check_two_bodies(robot, contact.frame_names, where, "they cannot strike each other")
    elif isinstance(contact, JointStop):
        joint = robot.model.joints[robot.joint_id(contact.joint, where)]
        if joint.nq != 1 or joint.nv != 1:
            raise InputError(
                f'{where}: joint "{contact.joint}" has no single coordinate that could reach '
                "a stop (a continuous joint has no limits)"
            )
        lower, upper = contact.limits(robot)
        if not lower <= upper:
            raise InputError(
                f"{where}: the lower limit {lower:g} is above the upper {upper:g}; give both"
            )
    elif isinstance(contact, Collision):
        from ..robot.geometry import geometry_ids

        ends = [geometry_ids(robot, name, where)[1] for name in (contact.first, contact.other)]
        if ends[0] == ends[1]:
            raise InputError(
                f'{where}: "{contact.first}" and "{contact.other}" belong to one rigid body '
                "and cannot collide"
            )
    else:
        raise InputError(
            f"{where} must be a Contact, JointStop, Collision, Rope or GapContact, "
            f"got {a_thing(contact)}"
        )
