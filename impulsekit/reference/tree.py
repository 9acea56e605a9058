"""The system of N rigid bodies: a tree of links, each with the joint above it.

Every link is a body with its own inertia, links behind fixed joints among them. Bodies, and
with them coordinates and speeds, are numbered depth first, children by the name of their
joint, as Pinocchio numbers them.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from impulsekit.errors import (
    RangeError,
    ShapeError,
    StateError,
    UnknownNameError,
    UrdfError,
)
from impulsekit.reference import rotation
from impulsekit.reference.arithmetic import Arithmetic, Array, read_only
from impulsekit.reference.joint import COORDINATES, SPEEDS, Joint
from impulsekit.reference.urdf import UrdfJoint, UrdfModel, read_urdf

__all__ = ["ROOTS", "WORLD", "Body", "Tree"]

WORLD = -1
"""The index that stands for the inertial frame R where a body's index is wanted."""

ROOTS = ("fixed", "planar", "freeflyer")
ROOT_JOINT = "root_joint"
"""The name of the joint between the world and the root link, a fixed one among them."""

# How far from length one a quaternion, or a cosine and sine, may be.
_UNIT_TOLERANCE = 1e-9


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body B_k: a link of the URDF.

    Attributes:
        parent: index of the body that its joint hangs on, or WORLD.
        mass: kg.
        mass_centre: (3,) m, in the link's frame.
        inertia: (3, 3) kg m² about the mass centre, in axes of the link's frame.
    """

    name: str
    parent: int
    joint: Joint
    mass: Any
    mass_centre: Array
    inertia: Array

    def __post_init__(self) -> None:
        read_only(self.mass_centre, self.inertia)


@dataclass(frozen=True, eq=False)
class Tree:
    """The bodies, parents before children, and the arithmetic their numbers are in.

    Example:
        >>> rod = '''<robot name="rod"><link name="rod"><inertial>
        ...     <mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>
        ... </inertial></link></robot>'''
        >>> Tree.from_urdf(rod, root="planar").speed_names
        ('root_joint.vx', 'root_joint.vy', 'root_joint.wz')
    """

    bodies: tuple[Body, ...]
    arithmetic: Arithmetic
    speed_names: tuple[str, ...]
    coordinate_names: tuple[str, ...]

    @classmethod
    def from_urdf(
        cls,
        urdf: str | os.PathLike[str],
        root: str = "fixed",
        mimic: bool = False,
        arithmetic: Arithmetic | None = None,
        exact_decimals: bool = False,
    ) -> Tree:
        """Read a tree from a URDF.

        Args:
            urdf: a path, or the XML itself.
            root: "fixed", "planar" or "freeflyer": how the root link hangs on the world.
            mimic: False reads a joint that mimics another as independent; True lets it
                follow, without a speed of its own.
            arithmetic: doubles unless given.
            exact_decimals: False takes each number of the URDF as the nearest double,
                which is what other programs compute with; True takes the decimal as
                written, in full.

        Raises:
            UrdfError: the URDF cannot be read, or has a moving joint that carries nothing
                but links without mass, so that no mass matrix of it could be inverted.
            RangeError: a root unknown.
        """
        if root not in ROOTS:
            raise RangeError.of("root", repr(root), ", ".join(map(repr, ROOTS)))
        numbers = arithmetic if arithmetic is not None else Arithmetic.double()
        model = read_urdf(urdf)
        tree = _Builder(model, mimic, numbers, exact_decimals).build(root)
        tree._refuse_weightless_branches(model.source)
        return tree

    @classmethod
    def combine(
        cls, parts: Mapping[str, Tree], placements: Mapping[str, tuple[Any, Any]] | None = None
    ) -> Tree:
        """Several trees in one world, names prefixed "part/", q and y stacked in order.

        Args:
            parts: at least one tree by name, all in the same arithmetic.
            placements: for some of the parts, translation (3,) in m and rotation (3, 3) of
                the part's root in the world; together with the root joint's own motion.
        """
        if not parts:
            raise RangeError.of("number of parts", 0, "1 or more")
        wanted = dict(placements or {})
        for name in wanted:
            if name not in parts:
                raise UnknownNameError.among("part", name, parts)
        numbers = next(iter(parts.values())).arithmetic
        bodies: list[Body] = []
        speed_names: list[str] = []
        coordinate_names: list[str] = []
        for name, part in parts.items():
            if part.arithmetic.name != numbers.name:
                raise RangeError.of(
                    f'arithmetic of the part "{name}"', part.arithmetic.name, numbers.name
                )
            first = len(bodies)
            for body in part.bodies:
                joint = replace(
                    body.joint,
                    name=f"{name}/{body.joint.name}",
                    mimics=f"{name}/{body.joint.mimics}" if body.joint.mimics else "",
                    first_coordinate=body.joint.first_coordinate + len(coordinate_names),
                    first_speed=body.joint.first_speed + len(speed_names),
                )
                if body.parent == WORLD and name in wanted:
                    joint = replace(joint, placement=_placement(name, wanted[name], numbers))
                parent = WORLD if body.parent == WORLD else body.parent + first
                bodies.append(replace(body, name=f"{name}/{body.name}", parent=parent, joint=joint))
            speed_names += [f"{name}/{speed}" for speed in part.speed_names]
            coordinate_names += [f"{name}/{coordinate}" for coordinate in part.coordinate_names]
        return cls(tuple(bodies), numbers, tuple(speed_names), tuple(coordinate_names))

    # -- sizes and names -------------------------------------------------------

    @property
    def n(self) -> int:
        """Number of generalized speeds."""
        return len(self.speed_names)

    @cached_property
    def link_names(self) -> tuple[str, ...]:
        """Names of the bodies, in order."""
        return tuple(body.name for body in self.bodies)

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints above the bodies, in order."""
        return tuple(body.joint.name for body in self.bodies)

    @cached_property
    def _link_index(self) -> dict[str, int]:
        return {name: index for index, name in enumerate(self.link_names)}

    @cached_property
    def _joint_index(self) -> dict[str, int]:
        return {name: index for index, name in enumerate(self.joint_names)}

    def body_of_link(self, link: str) -> int:
        """Index of the body called ``link``; WORLD for "world" where no link is called so."""
        if link in self._link_index:
            return self._link_index[link]
        if link == "world":
            return WORLD
        raise UnknownNameError.among("link", link, self.link_names)

    def body_of_joint(self, joint: str) -> int:
        """Index of the body below the joint."""
        if joint not in self._joint_index:
            raise UnknownNameError.among("joint", joint, self.joint_names)
        return self._joint_index[joint]

    def joint(self, name: str) -> Joint:
        """The joint of this name."""
        return self.bodies[self.body_of_joint(name)].joint

    def subtree(self, body: int) -> list[int]:
        """Indices of a body and all that hang on it."""
        below = {body}
        for index in range(body + 1, len(self.bodies)):
            if self.bodies[index].parent in below:
                below.add(index)
        return sorted(below)

    # -- states -----------------------------------------------------------------

    def neutral(self) -> Array:
        """(nq,) coordinates with every joint at zero."""
        ones = (".cos", ".qw")
        return self.arithmetic.array(
            [1 if name.endswith(ones) else 0 for name in self._coordinate_suffixes]
        )

    @cached_property
    def _coordinate_suffixes(self) -> list[str]:
        return [
            suffix
            for body in self.bodies
            if not body.joint.mimics
            for suffix in COORDINATES[body.joint.kind]
        ]

    def configuration(self, q: Any) -> Array:
        """A checked copy of q, (nq,), quaternions and cosine-sine pairs made unit exactly.

        Doubles are unit to 16 digits only. What they say is a direction, and that is taken
        to the precision at hand, so that rotations are orthogonal to the last digit.

        Raises:
            ShapeError, NotFiniteError: of q.
            StateError: a quaternion or a cosine-sine pair that is not unit to 1e-9.
        """
        checked = self._vector(q, "q", len(self.coordinate_names))
        for body in self.bodies:
            joint = body.joint
            if joint.mimics or joint.kind not in ("continuous", "planar", "floating"):
                continue
            stop = joint.coordinates.stop
            start = stop - (4 if joint.kind == "floating" else 2)
            length = self.arithmetic.norm(checked[start:stop])
            if abs(length - 1) > _UNIT_TOLERANCE:
                what = "quaternion" if joint.kind == "floating" else "cosine and sine"
                raise StateError(
                    f'q: the {what} of joint "{joint.name}" (entries {start} to {stop - 1}) '
                    f"has length {float(length):.12g}, wanted is 1",
                    joint=joint.name,
                    value=tuple(checked[start:stop]),
                )
            checked[start:stop] /= length
        return checked

    def speeds(self, y: Any, what: str = "y") -> Array:
        """A checked copy of generalized speeds, (n,)."""
        return self._vector(y, what, self.n)

    def _vector(self, values: Any, what: str, size: int) -> Array:
        checked = self.arithmetic.finite_array(values, what)
        if checked.shape != (size,):
            raise ShapeError.of(what, (size,), checked.shape)
        return checked

    # -- what cannot move -------------------------------------------------------

    def _refuse_weightless_branches(self, source: str) -> None:
        for index, body in enumerate(self.bodies):
            if not len(body.joint.linear) or body.joint.mimics:
                continue
            below = [self.bodies[k] for k in self.subtree(index)]
            if all(b.mass == 0 and not b.inertia.any() for b in below):
                joint = f'joint "{body.joint.name}"'
                raise UrdfError(
                    f'{source}: {joint}: link "{body.name}" and all below it have neither mass '
                    "nor inertia, so any blow would move them infinitely fast",
                    source=source,
                    element=joint,
                )


def _placement(part: str, placement: tuple[Any, Any], numbers: Arithmetic) -> tuple[Array, Array]:
    translation, turned = placement
    origin = numbers.finite_array(translation, f'translation of the part "{part}"')
    matrix = numbers.finite_array(turned, f'rotation of the part "{part}"')
    for what, value, shape in (("translation", origin, (3,)), ("rotation", matrix, (3, 3))):
        if value.shape != shape:
            raise ShapeError.of(f'{what} of the part "{part}"', shape, value.shape)
    error = max(abs(entry) for entry in (matrix @ matrix.T - numbers.eye(3)).flat)
    if error > _UNIT_TOLERANCE:
        raise RangeError.of(f'rotation of the part "{part}"', turned, "an orthogonal matrix")
    return matrix, origin


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

    def build(self, root: str) -> Tree:
        kind = {"fixed": "fixed", "planar": "planar", "freeflyer": "floating"}[root]
        name = ROOT_JOINT
        if name in self.model.joints:
            if kind != "fixed":
                raise self._error(
                    name, "this name is kept for the joint between the world and the root link"
                )
            name = f"world_{ROOT_JOINT}"
        self._add(UrdfJoint(name, kind, "", self.model.root), WORLD)
        bodies = [replace(body, joint=self._following(body.joint)) for body in self.bodies]
        return Tree(
            tuple(bodies), self.arithmetic, tuple(self.speed_names), tuple(self.coordinate_names)
        )

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
