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
from typing import Any, Self

from impulsekit.errors import RangeError, ShapeError, StateError, UnknownNameError
from impulsekit.reference.arithmetic import Arithmetic, Array
from impulsekit.reference.joint import COORDINATES, UNIT_TOLERANCE, WORLD, Bodies, Body, Joint
from impulsekit.reference.urdf import ROOT_KINDS, bodies_of_urdf

ROOTS = tuple(ROOT_KINDS)


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
    ) -> Self:
        """Read a tree from a URDF.

        Args:
            urdf: a path, or the XML itself.
            root: "fixed", "planar" or "freeflyer": how the root link is joined to the world.
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
        bodies, speed_names, coordinate_names = bodies_of_urdf(
            urdf, root, mimic, numbers, exact_decimals
        )
        return cls(bodies, numbers, speed_names, coordinate_names)

    @classmethod
    def combine(
        cls, placements: Mapping[str, tuple[Any, Any]] | None = None, /, **parts: Tree
    ) -> Self:
        """Put several trees in one world, names prefixed "part/", q and y stacked in order.

        Args:
            placements: for some of the parts, translation (3,) in m and rotation (3, 3) of
                the part's root in the world; together with the root joint's own motion.
            **parts: at least one tree by name, all in the same arithmetic.
        """
        bodies, speed_names, coordinate_names = _combined_bodies(parts, placements)
        numbers = next(iter(parts.values())).arithmetic
        return cls(bodies, numbers, speed_names, coordinate_names)

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
        """Return the index of a link's body; WORLD for "world" where no link is called so."""
        if link in self._link_index:
            return self._link_index[link]
        if link == "world":
            return WORLD
        raise UnknownNameError.among("link", link, self.link_names)

    def body_of_joint(self, joint: str) -> int:
        """Return the index of the body below the joint."""
        if joint not in self._joint_index:
            raise UnknownNameError.among("joint", joint, self.joint_names)
        return self._joint_index[joint]

    def joint(self, name: str) -> Joint:
        """Return the joint of this name."""
        return self.bodies[self.body_of_joint(name)].joint

    def subtree(self, body: int) -> list[int]:
        """Return the indices of a body and all below it."""
        below = {body}
        for index in range(body + 1, len(self.bodies)):
            if self.bodies[index].parent in below:
                below.add(index)
        return sorted(below)

    # -- states -----------------------------------------------------------------

    def neutral(self) -> Array:
        """Return (nq,) coordinates with every joint at zero."""
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
        """Return a checked copy of q, (nq,), quaternions and cosine-sine pairs made unit exactly.

        Doubles are unit to 16 digits only. What they say is a direction, and that is taken
        to the precision at hand, so that rotations are orthogonal to the last digit.

        Raises:
            ShapeError, NotFiniteError: of q.
            StateError: a quaternion or a cosine-sine pair that is not unit to 1e-9.
        """
        checked = self._vector(q, "q", len(self.coordinate_names))
        for body in self.bodies:
            joint = body.joint
            turns = joint.kind in ("spherical", "floating")
            if joint.mimics or not (turns or joint.kind in ("continuous", "planar")):
                continue
            stop = joint.coordinates.stop
            start = stop - (4 if turns else 2)
            length = self.arithmetic.norm(checked[start:stop])
            if abs(length - 1) > UNIT_TOLERANCE:
                what = "quaternion" if turns else "cosine and sine"
                raise StateError(
                    f'q: the {what} of joint "{joint.name}" (entries {start} to {stop - 1}) '
                    f"has length {float(length):.12g}, expected 1",
                    joint=joint.name,
                    value=tuple(checked[start:stop]),
                )
            checked[start:stop] /= length
        return checked

    def speeds(self, y: Any, what: str = "y") -> Array:
        """Return a checked copy of generalized speeds, (n,)."""
        return self._vector(y, what, self.n)

    def _vector(self, values: Any, what: str, size: int) -> Array:
        checked = self.arithmetic.finite_array(values, what)
        if checked.shape != (size,):
            raise ShapeError.of(what, (size,), checked.shape)
        return checked


def _combined_bodies(
    parts: Mapping[str, Tree], placements: Mapping[str, tuple[Any, Any]] | None
) -> Bodies:
    """Return the bodies of all parts; arguments and errors are those of ``Tree.combine``."""
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
    return Bodies(tuple(bodies), tuple(speed_names), tuple(coordinate_names))


def _placement(part: str, placement: tuple[Any, Any], numbers: Arithmetic) -> tuple[Array, Array]:
    translation, turned = placement
    origin = numbers.finite_array(translation, f'translation of the part "{part}"')
    matrix = numbers.finite_array(turned, f'rotation of the part "{part}"')
    for what, value, shape in (("translation", origin, (3,)), ("rotation", matrix, (3, 3))):
        if value.shape != shape:
            raise ShapeError.of(f'{what} of the part "{part}"', shape, value.shape)
    error = max(abs(entry) for entry in (matrix @ matrix.T - numbers.eye(3)).flat)
    if error > UNIT_TOLERANCE:
        raise RangeError.of(f'rotation of the part "{part}"', turned, "an orthogonal matrix")
    return matrix, origin
