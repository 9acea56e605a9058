"""From a URDF to bodies, numbered depth first."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from impulsekit.errors import UrdfError
from impulsekit.reference import rotation
from impulsekit.reference.arithmetic import Arithmetic, Array
from impulsekit.reference.joint import COORDINATES, SPEEDS, WORLD, Bodies, Body, Joint
from impulsekit.reference.urdf import UrdfJoint, UrdfModel, read_urdf

ROOT_JOINT = "root_joint"
"""The name of the joint between the world and the root link, a fixed one among them."""


def bodies_of_urdf(
    urdf: str | os.PathLike[str],
    root: str,
    mimic: bool,
    arithmetic: Arithmetic,
    exact_decimals: bool,
) -> Bodies:
    """The bodies of a URDF; arguments and errors are those of ``Tree.from_urdf``."""
    model = read_urdf(urdf)
    found = _Builder(model, mimic, arithmetic, exact_decimals).build(root)
    _refuse_weightless_branches(found.bodies, model.source)
    return found


def _refuse_weightless_branches(bodies: Sequence[Body], source: str) -> None:
    """Refuse a joint that carries links without mass alone: it cannot move."""
    heavy = [body.mass != 0 or body.inertia.any() for body in bodies]
    # Children come after their parents.
    for index in reversed(range(len(bodies))):
        if heavy[index] and bodies[index].parent != WORLD:
            heavy[bodies[index].parent] = True
    for body, carries in zip(bodies, heavy, strict=True):
        if len(body.joint.linear) and not body.joint.mimics and not carries:
            joint = f'joint "{body.joint.name}"'
            raise UrdfError(
                f'{source}: {joint}: link "{body.name}" and all below it have neither mass '
                "nor inertia, so any blow would move them infinitely fast",
                source=source,
                element=joint,
            )


class _Builder:
    """Walks down a URDF, depth first, and numbers coordinates and speeds on the way."""

    def __init__(
        self, model: UrdfModel, mimic: bool, arithmetic: Arithmetic, exact_decimals: bool
    ) -> None:
        self.model = model
        self.mimic = mimic
        self.arithmetic = arithmetic
        self.exact_decimals = exact_decimals
        self.bodies: list[Body] = []
        self.speed_names: list[str] = []
        self.coordinate_names: list[str] = []

    def build(self, root: str) -> Bodies:
        kind = {"fixed": "fixed", "planar": "planar", "freeflyer": "floating"}[root]
        name = ROOT_JOINT
        if name in self.model.joints:
            name = f"world_{ROOT_JOINT}"
        self._add(UrdfJoint(name, kind, "", self.model.root), WORLD)
        bodies = [replace(body, joint=self._following(body.joint)) for body in self.bodies]
        return Bodies(tuple(bodies), tuple(self.speed_names), tuple(self.coordinate_names))

    def _add(self, first: UrdfJoint, parent: int) -> None:
        ahead = [(first, parent)]  # a stack, since long chains are deeper than Python's
        while ahead:
            joint, above = ahead.pop()
            index = len(self.bodies)
            self.bodies.append(self._body(joint, above))
            ahead += [(below, index) for below in reversed(self.model.children(joint.child))]

    def _read(self, texts: tuple[str, ...]) -> Array:
        values: list[Any] = list(texts) if self.exact_decimals else [float(t) for t in texts]
        numbers = self.arithmetic.zeros(len(values))
        for i, value in enumerate(values):
            numbers[i] = self.arithmetic.number(value)
        return numbers

    def _body(self, joint: UrdfJoint, parent: int) -> Body:
        link = self.model.links[joint.child]
        turned = rotation.of_roll_pitch_yaw(self._read(link.roll_pitch_yaw), self.arithmetic)
        ixx, ixy, ixz, iyy, iyz, izz = self._read(link.inertia)
        own = np.array(
            [[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]], dtype=self.arithmetic.dtype
        )
        return Body(
            link.name,
            parent,
            self._joint(joint),
            self._read((link.mass,))[0],
            self._read(link.mass_centre),
            turned @ own @ turned.T,
        )

    def _joint(self, joint: UrdfJoint) -> Joint:
        numbers = self.arithmetic
        placement = (
            rotation.of_roll_pitch_yaw(self._read(joint.roll_pitch_yaw), numbers),
            self._read(joint.translation),
        )
        unit = numbers.eye(3)
        axis = unit[2].copy()
        if joint.kind in ("revolute", "continuous", "prismatic"):
            axis = self._read(joint.axis)
            axis = axis / numbers.norm(axis)
        rate, none, three = axis[None, :], numbers.zeros(1, 3), numbers.zeros(3, 3)
        linear, angular = {
            "fixed": (numbers.zeros(0, 3), numbers.zeros(0, 3)),
            "revolute": (none, rate),
            "continuous": (none, rate),
            "prismatic": (rate, none),
            "planar": (np.vstack([unit[:2], none]), np.vstack([none, none, unit[2:]])),
            "floating": (np.vstack([unit, three]), np.vstack([three, unit])),
        }[joint.kind]
        follows = joint.mimics if self.mimic else ""
        first_coordinate, first_speed = len(self.coordinate_names), len(self.speed_names)
        if not follows:
            self.coordinate_names += [joint.name + tail for tail in COORDINATES[joint.kind]]
            self.speed_names += [joint.name + tail for tail in SPEEDS[joint.kind]]
        return Joint(
            joint.name,
            joint.kind,
            placement,
            linear,
            angular,
            axis,
            joint.kind,
            first_coordinate,
            first_speed,
            follows,
            self._read((joint.multiplier,))[0] if follows else numbers.number(1),
            self._read((joint.offset,))[0] if follows else numbers.number(0),
        )

    def _following(self, joint: Joint) -> Joint:
        """The joint, pointed at the coordinate and speed of the joint that it follows."""
        if not joint.mimics:
            return joint
        known = {body.joint.name: body.joint for body in self.bodies}
        multiplier, offset, leader = self.arithmetic.number(1), self.arithmetic.number(0), joint
        seen: set[str] = set()
        while leader.mimics:
            # q = m1 (m2 q'' + o2) + o1
            if leader.name in seen:
                raise self._error(joint.name, "it mimics itself")
            if leader.mimics not in known:
                raise self._error(
                    joint.name, f'the joint "{leader.mimics}" that it mimics does not exist'
                )
            seen.add(leader.name)
            multiplier, offset = multiplier * leader.multiplier, multiplier * leader.offset + offset
            leader = known[leader.mimics]
        if len(joint.linear) != 1 or len(leader.linear) != 1:
            raise self._error(
                joint.name, f'it mimics "{leader.name}", and both need a single speed'
            )
        return replace(
            joint,
            coordinate_kind=leader.kind,
            first_coordinate=leader.first_coordinate,
            first_speed=leader.first_speed,
            mimics=leader.name,
            multiplier=multiplier,
            offset=offset,
        )

    def _error(self, joint: str, reason: str) -> UrdfError:
        element = f'joint "{joint}"'
        source = self.model.source
        return UrdfError(f"{source}: {element}: {reason}", source=source, element=element)
