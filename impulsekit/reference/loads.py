"""Loads on the bodies, as plain data: wrenches at points of links, springs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from impulsekit.errors import RangeError, ShapeError
from impulsekit.reference import kane, rotation
from impulsekit.reference.arithmetic import Array
from impulsekit.reference.joint import joint_coordinate
from impulsekit.reference.kinematics import Kinematics
from impulsekit.reference.tree import WORLD, Tree


def in_joints(tree: Tree, given: Mapping[str, Any] | None) -> dict[str, Array]:
    """Return forces inside each joint along its own speeds, by name: zeros unless given.

    A joint that mimics another may have an impulse or torque of its own as well.
    """
    numbers = tree.arithmetic
    own = {b.joint.name: numbers.zeros(len(b.joint.linear)) for b in tree.bodies}
    for name, value in (given or {}).items():
        joint = tree.joint(name)
        what = f'joint "{name}"'
        checked = numbers.finite_array(np.atleast_1d(np.asarray(value)), what)
        if checked.shape != own[joint.name].shape:
            raise ShapeError.of(what, own[joint.name].shape, checked.shape)
        own[joint.name] = checked
    return own


def on_speeds(tree: Tree, own: Mapping[str, Array]) -> Array:
    """Return forces inside joints, on the generalized speeds: (n,)."""
    total = tree.arithmetic.zeros(tree.n)
    for body in tree.bodies:
        total[body.joint.speeds] += body.joint.multiplier * own[body.joint.name]
    return total


def active(
    tree: Tree,
    q: Array,
    at: Kinematics,
    y: Array,
    gravity: Any,
    forces: Iterable[Load],
    joint_torques: Mapping[str, Any] | None,
    springs: Iterable[JointSpring | PointSpring],
) -> Array:
    """Return (n,) F_l (eqs. 7-10) of all that acts; arguments as for
    ``KaneSystem.accelerations``."""
    outside, couples = at_mass_centres(tree, at, forces)
    outside += at.masses[:, None] * vector(tree, gravity, "gravity")
    inside = in_joints(tree, joint_torques)
    for spring in springs:
        if isinstance(spring, PointSpring):
            pull, turn = pull_of(spring, tree, at, y)
            outside += pull
            couples += turn
            continue
        joint = tree.joint(spring.joint)
        if len(joint.linear) != 1:
            raise RangeError.of(
                f'joint of a spring, "{joint.name}"', joint.kind, "one with a single speed"
            )
        number = tree.arithmetic.number
        stretch = joint_coordinate(joint, q, tree.arithmetic) - number(spring.rest)
        rate = joint.multiplier * y[joint.first_speed]
        inside[joint.name] = inside[joint.name] - (
            number(spring.stiffness) * stretch + number(spring.damping) * rate
        )
    return kane.generalized_active_force(at, outside, couples) + on_speeds(tree, inside)


@dataclass(frozen=True)
class Load:
    """A force and a couple, or the impulses of both, on a point of a link.

    In an impact N s and N m s, in motion N and N m.

    Attributes:
        link: the link that it acts on.
        linear: (3,) force or impulse.
        angular: (3,) couple about the point, or its impulse.
        at: (3,) m, the point in the link's frame.
        axes: "world" or "local" (the link's own), of ``linear`` and ``angular``.

    Example:
        >>> Load("hand", linear=(0, 5, 0), at=(0.1, 0, 0)).axes
        'world'
    """

    link: str
    linear: Any = (0, 0, 0)
    angular: Any = (0, 0, 0)
    at: Any = (0, 0, 0)
    axes: str = "world"


@dataclass(frozen=True)
class JointSpring:
    """A spring and a damper in a joint with one speed: −stiffness (q − rest) − damping q̇."""

    joint: str
    stiffness: float = 0.0
    damping: float = 0.0
    rest: float = 0.0


@dataclass(frozen=True)
class PointSpring:
    """A spring and a damper along the line between points of two links, or of the world.

    The pull is stiffness (length − rest_length) + damping times the rate of the length.

    Attributes:
        link, other: the links.
        at, other_at: (3,) m, the points in the frames of the links.
        stiffness: N/m. damping: N s/m. rest_length: m.
    """

    link: str
    other: str
    at: Any = (0, 0, 0)
    other_at: Any = (0, 0, 0)
    stiffness: float = 0.0
    damping: float = 0.0
    rest_length: float = 0.0


def point_on(tree: Tree, at: Kinematics, body: int, point: Any, what: str) -> Array:
    """Return world coordinates (3,) m of a point given in the frame of a body, or of the world."""
    own = vector(tree, point, what)
    return own if body == WORLD else at.origins[body] + at.rotations[body] @ own


def at_mass_centres(tree: Tree, at: Kinematics, loads: Iterable[Load]) -> tuple[Array, Array]:
    """Return the loads as one force F_k and one couple M_k per body, (N, 3) each, world axes.

    A force F on a point at r from the mass centre is F on the mass centre and a couple r x F.

    Raises:
        UnknownNameError, ShapeError, NotFiniteError, RangeError: of a load.
    """
    forces = tree.arithmetic.zeros(len(tree.bodies), 3)
    couples = tree.arithmetic.zeros(len(tree.bodies), 3)
    for load in loads:
        body = tree.body_of_link(load.link)
        what = f'load on "{load.link}"'
        force = vector(tree, load.linear, f"{what}: linear")
        couple = vector(tree, load.angular, f"{what}: angular")
        point = point_on(tree, at, body, load.at, f"{what}: at")
        if load.axes not in ("world", "local"):
            raise RangeError.of(f"{what}: axes", repr(load.axes), '"world" or "local"')
        if body == WORLD:
            continue  # the world does not move
        if load.axes == "local":
            force, couple = at.rotations[body] @ force, at.rotations[body] @ couple
        arm = rotation.skew(point - at.mass_centres[body], tree.arithmetic)
        forces[body] += force
        couples[body] += couple + arm @ force
    return forces, couples


def vector(tree: Tree, values: Any, what: str) -> Array:
    """Return a checked copy of three numbers."""
    checked = tree.arithmetic.finite_array(values, what)
    if checked.shape != (3,):
        raise ShapeError.of(what, (3,), checked.shape)
    return checked


def pull_of(spring: PointSpring, tree: Tree, at: Kinematics, y: Array) -> tuple[Array, Array]:
    """Return forces and couples of a spring between points on all bodies, (N, 3) each.

    Raises:
        RangeError: its ends meet, so its pull has no direction.
    """
    numbers = tree.arithmetic
    forces = numbers.zeros(len(tree.bodies), 3)
    couples = numbers.zeros(len(tree.bodies), 3)
    what = f'spring between "{spring.link}" and "{spring.other}"'
    velocity, spin = at.velocities(y)
    ends = []
    for link, place in ((spring.link, spring.at), (spring.other, spring.other_at)):
        body = tree.body_of_link(link)
        point = point_on(tree, at, body, place, what)
        if body == WORLD:
            ends.append((body, point, numbers.zeros(3), numbers.zeros(3, 3)))
        else:
            arm = rotation.skew(point - at.mass_centres[body], numbers)
            ends.append((body, point, velocity[body] - arm @ spin[body], arm))
    (first, here, here_rate, arm), (other, there, there_rate, other_arm) = ends
    length = numbers.norm(there - here)
    if not length > 0:
        raise RangeError.of(f"length of the {what}", 0, "more than 0")
    along = (there - here) / length
    stretch = length - numbers.number(spring.rest_length)
    rate = along @ (there_rate - here_rate)
    pull = numbers.number(spring.stiffness) * stretch + numbers.number(spring.damping) * rate
    for body, lever, force in ((first, arm, pull * along), (other, other_arm, -pull * along)):
        if body != WORLD:
            forces[body] += force
            couples[body] += lever @ force
    return forces, couples
