"""A robot as the reference sees it: made anew from its URDF, or from the numbers of its model."""

from __future__ import annotations

import re
import weakref
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..errors import InputError, UrdfError
from ..reference import Arithmetic, KaneSystem
from ..reference.joint import COORDINATES, SPEEDS, WORLD, Body, Joint, directions
from ..reference.tree import ROOTS
from ..robot.base import WORLD_LINK

if TYPE_CHECKING:
    import pinocchio as pin

    from ..robot import Robot
    from ..robot.masses import Link

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
# A joint of Pinocchio as a row of simple ones, each of a kind and about or along an axis.
# An axis of None is the joint's own.
_SIMPLE: dict[str, tuple[tuple[str, tuple[float, ...] | None], ...]] = {
    "FreeFlyer": (("floating", Z),),
    "Planar": (("planar", Z),),
    "Spherical": (("spherical", Z),),
    "SphericalZYX": (("revolute", Z), ("revolute", Y), ("revolute", X)),
    "Translation": (("prismatic", X), ("prismatic", Y), ("prismatic", Z)),
    "RevoluteUnaligned": (("revolute", None),),
    "RevoluteUnboundedUnaligned": (("continuous", None),),
    "PrismaticUnaligned": (("prismatic", None),),
    **{f"R{n}": (("revolute", axis),) for n, axis in zip("XYZ", (X, Y, Z), strict=True)},
    **{f"RUB{n}": (("continuous", axis),) for n, axis in zip("XYZ", (X, Y, Z), strict=True)},
    **{f"P{n}": (("prismatic", axis),) for n, axis in zip("XYZ", (X, Y, Z), strict=True)},
}


class _Builder:
    """Builds the Kane system of one part of a robot, placed in the world as in the robot."""

    def __init__(self, robot: Robot, prefix: str, numbers: Arithmetic) -> None:
        self.robot, self.prefix, self.numbers = robot, prefix, numbers
        self.bodies: list[Body] = []
        self.speeds: list[str] = []
        self.coordinates: list[str] = []
        self.body_of_joint = {0: WORLD}

    def build(self) -> KaneSystem:
        model = self.robot.model
        links: dict[int, list[Link]] = {}
        for link in self.robot.links:
            links.setdefault(link.joint_id, []).append(link)
        own = [i for i in range(1, model.njoints) if model.names[i].startswith(self.prefix)]
        self._add_frames(0, links.get(0, []))
        for joint_id in own:
            self._add_joint(joint_id, not links.get(joint_id))
            self._add_frames(joint_id, links.get(joint_id, []))
        names = tuple(self.speeds), tuple(self.coordinates)
        return KaneSystem(tuple(self.bodies), self.numbers, *names)

    def _add_joint(self, joint_id: int, with_inertia: bool) -> None:
        model = self.robot.model
        name = model.names[joint_id].removeprefix(self.prefix)
        above = self.body_of_joint[model.parents[joint_id]]
        simple = list(_simple_joints(model.joints[joint_id], model.names[joint_id]))
        shift = model.jointPlacements[joint_id]
        for k, (kind, axis, rotation, translation) in enumerate(simple):
            placement = shift.rotation @ rotation, shift.translation + shift.rotation @ translation
            shift = type(shift).Identity()
            own_name = name if k == len(simple) - 1 else f"{name} ({k + 1})"
            joint = self._joint(own_name, kind, axis, placement)
            inertia = model.inertias[joint_id] if with_inertia and own_name == name else None
            above = self._add_body(f"joint {own_name}", above, joint, inertia)
        self.body_of_joint[joint_id] = above

    def _add_frames(self, joint_id: int, links: list[Link]) -> None:
        """Add links and frames of a joint, each a body fixed to it."""
        model = self.robot.model
        by_frame = {link.frame_id: link for link in links}
        for frame_id, frame in enumerate(model.frames):
            kind = frame.type.name
            if frame.parentJoint != joint_id or kind == "JOINT" or frame_id == 0:
                continue
            if not frame.name.startswith(self.prefix):
                continue
            place = frame.placement
            name = frame.name.removeprefix(self.prefix)
            joint = self._joint(f"frame {name}", "fixed", Z, (place.rotation, place.translation))
            link = by_frame.get(frame_id)
            inertia = None if link is None else _in_frame(link, place)
            if not any(body.name == name for body in self.bodies):
                self._add_body(name, self.body_of_joint[joint_id], joint, inertia)

    def _add_body(self, name: str, parent: int, joint: Joint, inertia: Any) -> int:
        mass, centre, moments = 0.0, np.zeros(3), np.zeros((3, 3))
        if inertia is not None:
            mass, centre, moments = inertia.mass, inertia.lever, inertia.inertia
        weight, place = self.numbers.number(float(mass)), self._array(centre)
        self.bodies.append(Body(name, parent, joint, weight, place, self._array(moments)))
        return len(self.bodies) - 1

    def _joint(self, name: str, kind: str, axis: Any, placement: tuple[Any, Any]) -> Joint:
        along = self._array(axis)
        along = along / self.numbers.norm(along)
        starts = len(self.coordinates), len(self.speeds)
        self.coordinates += [name + tail for tail in COORDINATES[kind]]
        self.speeds += [name + tail for tail in SPEEDS[kind]]
        place = self._array(placement[0]), self._array(placement[1])
        ways = directions(self.numbers, kind, along)
        one, none = self.numbers.number(1), self.numbers.number(0)
        return Joint(name, kind, place, *ways, along, *starts, one, none)

    def _array(self, values: Any) -> Any:
        flat = [self.numbers.number(float(value)) for value in np.ravel(values)]
        return np.array(flat, dtype=self.numbers.dtype).reshape(np.shape(values))


class _Inertia(NamedTuple):
    """Mass [kg], mass centre [m] and moments about it [kg m²], all in a body's own frame."""

    mass: float
    lever: np.ndarray
    inertia: np.ndarray


def _in_frame(link: Link, place: pin.SE3) -> _Inertia:
    """Return the inertia of a link in its own frame."""
    turn = place.rotation
    lever = turn.T @ (link.com_in_joint - place.translation)
    return _Inertia(link.mass, lever, turn.T @ link.inertia_in_joint_axes @ turn)


def _simple_joints(
    joint: pin.JointModel, name: str
) -> Iterator[tuple[str, Any, np.ndarray, np.ndarray]]:
    """Return kind, axis and placement of each simple joint that a joint of Pinocchio is made of."""
    word = joint.shortname().removeprefix("JointModel")
    one, none = np.eye(3), np.zeros(3)
    if word == "Composite":
        inner = joint.extract()
        for each, place in zip(inner.joints, inner.jointPlacements, strict=True):
            for kind, axis, rotation, translation in _simple_joints(each, name):
                turned = place.rotation @ rotation
                yield kind, axis, turned, place.translation + place.rotation @ translation
                place = type(place).Identity()
    elif word == "Universal":
        inner = joint.extract()
        yield "revolute", inner.axis1, one, none
        yield "revolute", inner.axis2, one, none
    elif word in _SIMPLE:
        for kind, axis in _SIMPLE[word]:
            yield kind, joint.extract().axis if axis is None else axis, one, none
    else:
        raise InputError(
            f'this impact cannot be checked: joint "{name}" is of the kind {word}, which the '
            "reference does not know"
        )


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
        """Return the link that a frame of the robot is; "world" for the fixed one.

        A URDF joint's frame is that of the link below it.
        """
        return frame if frame == "world" else self.own_link(frame)

    def own_link(self, frame: str) -> str:
        """Return the same for a frame that moves with the robot: a URDF may call a link "world",
        too."""
        name = self.prefix + frame
        tree = self.system
        if name not in tree.link_names and frame == WORLD_LINK:
            name = f"{self.prefix}world"
        if name not in tree.link_names:
            name = tree.bodies[tree.body_of_joint(name)].name
        return name

    def joint(self, joint: str) -> str:
        """Return the name of a joint in the system."""
        return self.prefix + joint

    def joints(self, names: Iterable[str]) -> dict[str, str]:
        """Return the system's joint by the robot's, without those it does not have."""
        known = set(self.system.joint_names)
        found = {name: self.joint(name) for name in names}
        return {name: inner for name, inner in found.items() if inner in known}


def reference_robot(robot: Robot, numbers: Arithmetic) -> ReferenceRobot:
    """Return the reference's own reading of a robot's URDF, kept as long as the robot lives.

    Args:
        robot: the robot.
        numbers: those that the reference computes with; those of one name are the same.

    Raises:
        InputError: the robot cannot be made by the reference; it says why.
    """
    kept = _kept.setdefault(robot, {})
    if numbers.name not in kept:
        kept[numbers.name] = read_reference(robot, numbers)
    return kept[numbers.name]


_kept: weakref.WeakKeyDictionary[Robot, dict[str, ReferenceRobot]] = weakref.WeakKeyDictionary()


def read_reference(robot: Robot, numbers: Arithmetic) -> ReferenceRobot:
    """Read a robot anew; arguments and errors are those of ``reference_robot``."""
    parts: dict[str, KaneSystem] = {}
    placements = {}
    alone = [part.prefix for part in robot.parts] == [""]
    for part in robot.parts:
        name = (_ALONE if alone else part.prefix).removesuffix("/")
        if part.urdf is None or part.root not in ROOTS:
            # Read out of the whole model, where it is placed already.
            parts[name] = _Builder(robot, part.prefix, numbers).build()
            continue
        try:
            parts[name] = KaneSystem.from_urdf(str(part.urdf), part.root, part.mimic, numbers)
        except UrdfError as error:
            raise _impossible(str(error)) from error
        if part.placement is not None:
            rows = [row[:3] for row in part.placement[:3]]
            placements[name] = ([row[3] for row in part.placement[:3]], rows)
    reference = ReferenceRobot(KaneSystem.combine(placements, **parts), _ALONE if alone else "")
    _same_order(robot, reference)
    return _with_rotors(reference, robot)


def _same_order(robot: Robot, reference: ReferenceRobot) -> None:
    """Check that both programs number the degrees of freedom alike."""
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
    """Return the same system with the armature of the robot's joints."""
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
