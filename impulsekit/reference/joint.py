"""The joint above a body: its kinds, coordinates, speeds and motion.

Conventions, those of Pinocchio so that answers compare entry by entry:

================  ===========================  =====================================
joint             coordinates q                generalized speeds y, in child axes
================  ===========================  =====================================
fixed             none                         none
revolute          angle                        angular rate about the axis
continuous        cosine, sine of the angle    angular rate about the axis
prismatic         displacement                 rate along the axis
planar            x, y, cosine, sine           vx, vy, wz
spherical         qx, qy, qz, qw               wx, wy, wz
floating          x, y, z, qx, qy, qz, qw      vx, vy, vz, wx, wy, wz
================  ===========================  =====================================

A planar joint moves in the x-y plane of its own frame. Pinocchio reads a URDF so too,
whatever axis the URDF gives it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from impulsekit.reference import rotation
from impulsekit.reference.arithmetic import Arithmetic, Array, read_only

WORLD = -1
"""The index that stands for the inertial frame R where a body's index is expected."""


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body B_k: a link of the URDF.

    Attributes:
        parent: index of the body above its joint, or WORLD.
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


class Bodies(NamedTuple):
    """Bodies, parents before children, with the names of all speeds and coordinates."""

    bodies: tuple[Body, ...]
    speed_names: tuple[str, ...]
    coordinate_names: tuple[str, ...]


COORDINATES = {
    "fixed": (),
    "revolute": ("",),
    "continuous": (".cos", ".sin"),
    "prismatic": ("",),
    "planar": (".x", ".y", ".cos", ".sin"),
    "spherical": (".qx", ".qy", ".qz", ".qw"),
    "floating": (".x", ".y", ".z", ".qx", ".qy", ".qz", ".qw"),
}
"""The endings of a joint's coordinate names, by kind."""

SPEEDS = {
    "fixed": (),
    "revolute": ("",),
    "continuous": ("",),
    "prismatic": ("",),
    "planar": (".vx", ".vy", ".wz"),
    "spherical": (".wx", ".wy", ".wz"),
    "floating": (".vx", ".vy", ".vz", ".wx", ".wy", ".wz"),
}
"""The endings of a joint's generalized speed names, by kind."""

UNIT_TOLERANCE = 1e-9
"""The largest deviation from unit length of a given quaternion, or cosine and sine."""


@dataclass(frozen=True, eq=False)
class Joint:
    """The joint above a body.

    Attributes:
        placement: rotation (3, 3) and translation (3,) in m of the joint's frame in the
            parent link's frame.
        axis: (3,) unit vector of the rotation or displacement, in the joint's frame.
        linear, angular: (d, 3) each, the velocity of the child against the parent, at the
            child's origin and in child axes, per unit of each of the joint's d own speeds.
            For every kind of joint they do not change with the configuration.
        first_coordinate, first_speed: where in q and y the joint's own entries begin.
            A joint that mimics another has none of its own and points at the other's.
        coordinate_kind: the kind of joint whose coordinates they are.
        mimics: the name of the joint followed, "" if none; its coordinate is
            ``multiplier`` times the other's plus ``offset``.
        armature: (d,) what a rotor adds to the generalized mass of each own speed [kg m²,
            kg]; None for nothing.
    """

    name: str
    kind: str
    placement: tuple[Array, Array]
    linear: Array
    angular: Array
    axis: Array
    first_coordinate: int
    first_speed: int
    multiplier: Any
    offset: Any
    mimics: str = ""
    coordinate_kind: str = ""
    armature: Array | None = None

    def __post_init__(self) -> None:
        read_only(*self.placement, self.linear, self.angular, self.axis)
        object.__setattr__(self, "coordinate_kind", self.coordinate_kind or self.kind)

    @property
    def speeds(self) -> slice:
        """The places of its speeds in y."""
        return slice(self.first_speed, self.first_speed + len(self.linear))

    @property
    def coordinates(self) -> slice:
        """The places of its coordinates in q."""
        length = len(COORDINATES[self.coordinate_kind])
        return slice(self.first_coordinate, self.first_coordinate + length)


def directions(numbers: Arithmetic, kind: str, axis: Array) -> tuple[Array, Array]:
    """Return the linear and angular parts (d, 3) of a joint's speeds; see ``Joint``."""
    one, none = numbers.eye(3), numbers.zeros(3, 3)
    rate = axis[None, :]
    linear, angular = {
        "fixed": (none[:0], none[:0]),
        "revolute": (none[:1], rate),
        "continuous": (none[:1], rate),
        "prismatic": (rate, none[:1]),
        "planar": (np.vstack([one[:2], none[:1]]), np.vstack([none[:2], one[2:]])),
        "spherical": (none, one),
        "floating": (np.vstack([one, none]), np.vstack([none, one])),
    }[kind]
    return linear.copy(), angular.copy()


def joint_coordinate(joint: Joint, q: Array, arithmetic: Arithmetic) -> Any:
    """Return the angle in rad or displacement in m of a joint with a single speed."""
    first = joint.first_coordinate
    if joint.coordinate_kind == "continuous":
        value = arithmetic.atan2(q[first + 1], q[first])
    else:
        value = q[first]
    return joint.multiplier * value + joint.offset if joint.mimics else value


def joint_pose(joint: Joint, q: Array, arithmetic: Arithmetic) -> tuple[Array, Array]:
    """Return rotation (3, 3) and translation (3,) of the child in the joint's frame.

    Args:
        q: (nq,) coordinates of the whole system, checked.
    """
    own = q[joint.coordinates]
    still, here = arithmetic.eye(3), arithmetic.zeros(3)
    if joint.kind == "fixed":
        return still, here
    if joint.kind == "spherical":
        return rotation.of_quaternion(own, arithmetic), here
    if joint.kind == "floating":
        return rotation.of_quaternion(own[3:], arithmetic), own[:3].copy()
    if joint.kind == "planar":
        here[:2] = own[:2]
        return rotation.about_axis(joint.axis, own[2], own[3], arithmetic), here
    if joint.kind == "continuous" and not joint.mimics:
        return rotation.about_axis(joint.axis, own[0], own[1], arithmetic), here
    value = joint_coordinate(joint, q, arithmetic)
    if joint.kind == "prismatic":
        return still, value * joint.axis
    cosine, sine = arithmetic.cos(value), arithmetic.sin(value)
    return rotation.about_axis(joint.axis, cosine, sine, arithmetic), here
