"""A robot as the reference sees it: made anew from its URDF, or from the numbers of its model."""

from __future__ import annotations

import re
import weakref
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError, UrdfError
from ..reference import Arithmetic, KaneSystem
from ..reference.tree import ROOTS
from ..robot.base import WORLD_LINK
from .model_bodies import system_of_model

if TYPE_CHECKING:
    from ..robot import Robot
    from ..robot.source import RobotPart

__all__ = ["ReferenceRobot", "read_reference", "reference_robot"]

# A robot by itself gets a prefix too, so that its links never meet the fixed "world".
_ALONE = "robot/"
# The joints before the last that stand for one joint of several simple ones.
_FIRST_OF_SEVERAL = re.compile(r" \(\d+\)$")


@dataclass(frozen=True, eq=False)
class ReferenceRobot:
    """A Kane system and how the robot's names are found in it.

    Attributes:
        system: the system.
        prefix: what stands before the robot's names there.
    """

    system: KaneSystem
    prefix: str

    def link(self, frame: str) -> str:
        """The link that a frame of the robot is; "world" for the fixed one.

        A URDF joint's frame is that of the link below it.
        """
        return frame if frame == "world" else self.own_link(frame)

    def own_link(self, frame: str) -> str:
        """The same for a frame that moves with the robot: a URDF may call a link "world", too."""
        name = self.prefix + frame
        tree = self.system
        if name not in tree.link_names and frame == WORLD_LINK:
            name = f"{self.prefix}world"
        if name not in tree.link_names:
            name = tree.bodies[tree.body_of_joint(name)].name
        return name

    def joint(self, joint: str) -> str:
        """The name of a joint in the system."""
        return self.prefix + joint

    def joints(self, names: Iterable[str]) -> dict[str, str]:
        """By joint of the robot, the joint of the system; without those it does not have."""
        known = set(self.system.joint_names)
        found = {name: self.joint(name) for name in names}
        return {name: inner for name, inner in found.items() if inner in known}


def reference_robot(robot: Robot, numbers: Arithmetic) -> ReferenceRobot:
    """The reference's own reading of a robot's URDF, kept as long as the robot lives.

    Args:
        robot: the robot.
        numbers: those that the reference computes with; those of one name are the same.

    Raises:
        InputError: the robot cannot be made by the reference; it says why.
    """
    kept = _kept.setdefault(robot, {})
    if numbers.name not in kept:
        with numbers.precision():
            kept[numbers.name] = read_reference(robot, numbers)
    return kept[numbers.name]


_kept: weakref.WeakKeyDictionary[Robot, dict[str, ReferenceRobot]] = weakref.WeakKeyDictionary()


def read_reference(robot: Robot, numbers: Arithmetic) -> ReferenceRobot:
    """The reference's own reading of a robot's URDF, in the numbers given.

    Raises:
        InputError: the robot cannot be made by the reference; it says why.
    """
    parts: dict[str, KaneSystem] = {}
    placements = {}
    alone = [part.prefix for part in robot.parts] == [""]
    for part in robot.parts:
        name = (_ALONE if alone else part.prefix).removesuffix("/")
        if part.urdf is None or part.root not in ROOTS:
            # Read out of the whole model, where it is placed already.
            parts[name] = system_of_model(robot, part, numbers)
            continue
        parts[name] = _system_of(part, numbers)
        if part.placement is not None:
            rows = [row[:3] for row in part.placement[:3]]
            placements[name] = ([row[3] for row in part.placement[:3]], rows)
    reference = ReferenceRobot(KaneSystem.combine(placements, **parts), _ALONE if alone else "")
    _same_order(robot, reference)
    return _with_rotors(reference, robot)


def _system_of(part: RobotPart, numbers: Arithmetic) -> KaneSystem:
    try:
        return KaneSystem.from_urdf(str(part.urdf), part.root, part.mimic, numbers)
    except UrdfError as error:
        raise _impossible(str(error)) from error


def _same_order(robot: Robot, reference: ReferenceRobot) -> None:
    """Prove that both programs number the degrees of freedom alike."""
    tree = reference.system
    named = (
        _FIRST_OF_SEVERAL.sub("", body.joint.name.removeprefix(reference.prefix))
        for body in tree.bodies
        if len(body.joint.linear) and not body.joint.mimics
    )
    theirs = list(dict.fromkeys(named))
    ours = [
        name
        for name, joint in zip(robot.joint_names, list(robot.model.joints)[1:], strict=True)
        if joint.nv > 0
    ]
    sizes = (len(tree.coordinate_names), tree.n) == (robot.nq, robot.nv)
    if theirs != ours or not sizes:
        astray = next((name for name in ours if name not in theirs), None)
        reason = f'joint "{astray}" is another to it' if astray else "it orders joints otherwise"
        raise _impossible(f"the reference reads another robot: {reason}")


def _with_rotors(reference: ReferenceRobot, robot: Robot) -> ReferenceRobot:
    """The same system with the armature of the robot's joints."""
    armature = np.array(robot.model.armature)
    if not armature.any():
        return reference
    tree = reference.system
    bodies = []
    for body in tree.bodies:
        own = armature[body.joint.speeds]
        if len(own) and not body.joint.mimics and own.any():
            numbers = [tree.arithmetic.number(float(value)) for value in own]
            rotor = np.array(numbers, dtype=tree.arithmetic.dtype)
            body = replace(body, joint=replace(body.joint, armature=rotor))
        bodies.append(body)
    return ReferenceRobot(replace(tree, bodies=tuple(bodies)), reference.prefix)


def _impossible(reason: str) -> InputError:
    return InputError(f"this impact cannot be checked: {reason}")
