"""What acts inside joints, and all active forces together, on the generalized speeds."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from impulsekit.errors import RangeError, ShapeError
from impulsekit.reference import kane, loads
from impulsekit.reference.arithmetic import Array
from impulsekit.reference.joint import joint_coordinate
from impulsekit.reference.kinematics import Kinematics
from impulsekit.reference.loads import JointSpring, Load, PointSpring
from impulsekit.reference.tree import Tree

__all__ = ["active", "in_joints", "on_speeds"]


def in_joints(tree: Tree, given: Mapping[str, Any] | None) -> dict[str, Array]:
    """What acts inside each joint along its own speeds, by name: zeros unless given.

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
    """What acts inside joints, on the generalized speeds: (n,)."""
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
    """(n,) F_l (eqs. 7-10) of all that acts; arguments as for ``KaneSystem.accelerations``."""
    outside, couples = loads.at_mass_centres(tree, at, forces)
    outside += at.masses[:, None] * loads.vector(tree, gravity, "gravity")
    inside = in_joints(tree, joint_torques)
    for spring in springs:
        if isinstance(spring, PointSpring):
            pull, turn = loads.pull_of(spring, tree, at, y)
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
