"""What ``Scene.contacts`` takes, and the proof that it fits a robot."""

from __future__ import annotations

from typing import Any, TypeAlias

from ..errors import InputError, a_thing
from ..robot import Robot
from .contacts import Collision, Contact, JointStop
from .distances import KEPT_ANYWAY, Rope
from .fits import check_two_bodies
from .function_rows import check_gradient
from .gap_functions import GapContact

__all__ = ["ContactEntry", "check_contact"]

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
