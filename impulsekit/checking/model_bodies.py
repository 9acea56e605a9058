"""The reference's bodies of a robot that is no URDF: plain numbers out of its model.

Masses, inertias, placements and kinds of joints are read; nothing is computed by Pinocchio.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..errors import InputError
from ..reference import Arithmetic, KaneSystem
from ..reference.body import WORLD, Body
from ..reference.joint import COORDINATES, SPEEDS, Joint

if TYPE_CHECKING:
    import pinocchio as pin

    from ..robot import Robot
    from ..robot.links import Link
    from ..robot.source import RobotPart

__all__ = ["system_of_model"]

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


def system_of_model(robot: Robot, part: RobotPart, numbers: Arithmetic) -> KaneSystem:
    """The Kane system of one part of a robot, placed in the world as in the robot.

    Raises:
        InputError: the model has a joint that the reference does not know.
    """
    return _Builder(robot, part.prefix, numbers).build()


class _Builder:
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
        """Links and frames of a joint, each a body fixed to it."""
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
        array = self._array
        self.bodies.append(
            Body(
                name, parent, joint, self.numbers.number(float(mass)), array(centre), array(moments)
            )
        )
        return len(self.bodies) - 1

    def _joint(self, name: str, kind: str, axis: Any, placement: tuple[Any, Any]) -> Joint:
        one, none = self.numbers.eye(3), self.numbers.zeros(3, 3)
        along = self._array(axis)
        along = along / self.numbers.norm(along)
        first_coordinate, first_speed = len(self.coordinates), len(self.speeds)
        self.coordinates += [name + tail for tail in COORDINATES[kind]]
        self.speeds += [name + tail for tail in SPEEDS[kind]]
        linear, angular = {
            "fixed": (none[:0], none[:0]),
            "revolute": (none[:1], along[None, :]),
            "continuous": (none[:1], along[None, :]),
            "prismatic": (along[None, :], none[:1]),
            "planar": (np.vstack([one[:2], none[:1]]), np.vstack([none[:2], one[2:]])),
            "spherical": (none, one),
            "floating": (np.vstack([one, none]), np.vstack([none, one])),
        }[kind]
        return Joint(
            name,
            kind,
            (self._array(placement[0]), self._array(placement[1])),
            linear,
            angular,
            along,
            kind,
            first_coordinate,
            first_speed,
            "",
            self.numbers.number(1),
            self.numbers.number(0),
        )

    def _array(self, values: Any) -> Any:
        flat = [self.numbers.number(float(value)) for value in np.ravel(values)]
        return np.array(flat, dtype=self.numbers.dtype).reshape(np.shape(values))


class _Inertia(NamedTuple):
    """Mass [kg], mass centre [m] and moments about it [kg m²], all in a body's own frame."""

    mass: float
    lever: np.ndarray
    inertia: np.ndarray


def _in_frame(link: Link, place: pin.SE3) -> _Inertia:
    """The inertia of a link in its own frame."""
    turn = place.rotation
    lever = turn.T @ (link.com_in_joint - place.translation)
    return _Inertia(link.mass, lever, turn.T @ link.inertia_in_joint_axes @ turn)


def _simple_joints(
    joint: pin.JointModel, name: str
) -> Iterator[tuple[str, Any, np.ndarray, np.ndarray]]:
    """Kind, axis and placement of each simple joint that a joint of Pinocchio is made of."""
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
