"""A scene as the reference takes it: loads on links, impulses in joints, constraint rows."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError
from ..reference import Load, Rows
from ..reference.kinematics import Kinematics
from ..reference.rows import angular_velocity_rows, point_velocity_rows, speed_rows
from ..reference.tree import WORLD
from ..scene import (
    AppliedImpulse,
    DistanceAnchor,
    FrameAnchor,
    GapConstraint,
    JointCoupling,
    JointImpulse,
    JointLock,
    PointAnchor,
)
from ..scene.constraints import DIRECTIONS, KEPT
from .system import ReferenceRobot

if TYPE_CHECKING:
    from ..impact.forces import BodyImpulse
    from ..scene.entries import Constraint


@dataclass
class KnownImpulses:
    """Impulses given to the reference: loads on links, and by joint the impulse in it."""

    reference: ReferenceRobot
    loads: list[Load]
    in_joints: dict[str, np.ndarray]

    def add_in_joint(self, joint: str, impulse: Any) -> None:
        """Add an impulse along a joint's own speeds."""
        name = self.reference.joint(joint)
        self.in_joints[name] = self.in_joints.get(name, 0.0) + np.atleast_1d(impulse)

    def add_on_body(self, item: BodyImpulse, frames: Any) -> None:
        """Add a wrench on a body, as the solver found it; ``frames`` are those of the model."""
        frame = frames[item.frame_id]
        wrench = frame.placement.actInv(item.wrench_in_joint)
        link = self.reference.own_link(frame.name)
        self.loads.append(Load(link, wrench.linear, wrench.angular, axes="local"))

    def add_of_joint_constraint(self, entry: Constraint, impulse: np.ndarray) -> None:
        """Add the impulse of a lock or a coupling; anchors act on bodies and add nothing here."""
        if isinstance(entry, JointLock):
            self.add_in_joint(entry.joint, impulse)
        elif isinstance(entry, JointCoupling):
            for name, factor in entry.terms:
                self.add_in_joint(name, factor * impulse)


def known_impulses(
    reference: ReferenceRobot, impulses: Iterable[AppliedImpulse | JointImpulse]
) -> KnownImpulses:
    """Return the known impulses of a scene."""
    known = KnownImpulses(reference, [], {})
    for entry in impulses:
        if isinstance(entry, AppliedImpulse):
            link = reference.link(entry.frame)
            known.loads.append(Load(link, entry.linear, entry.angular, entry.at, entry.axes))
        else:
            known.add_in_joint(entry.joint, entry.impulse)
    return known


def constraint_rows(
    reference: ReferenceRobot, at: Kinematics, y: np.ndarray, constraints: Iterable[Constraint]
) -> Rows:
    """Return the rows of a scene's constraints, in its order, with their velocities after.

    Args:
        y: (n,) the speeds before the impact, for rows whose velocity is kept.
    """
    tree = reference.system
    stacked = []
    for entry in constraints:
        rows = _rows(reference, at, entry)
        if entry.velocity == KEPT:
            matrix = rows.matrix(tree.arithmetic, at.linear, at.angular) + rows.speeds
            target = matrix @ tree.speeds(y)
        else:
            target = tree.arithmetic.zeros(len(rows)) + tree.arithmetic.array(entry.velocity)
        stacked.append(replace(rows, target=target))
    return Rows.stack(tree, stacked)


def _rows(reference: ReferenceRobot, at: Kinematics, entry: Constraint) -> Rows:
    tree = reference.system
    if isinstance(entry, PointAnchor | FrameAnchor):
        return _anchor_rows(reference, at, entry)
    if isinstance(entry, GapConstraint):
        raise InputError(
            "this impact cannot be checked: a GapConstraint is a function of q, which the "
            "reference has no words for"
        )
    if isinstance(entry, DistanceAnchor):
        return _distance_rows(reference, at, entry)
    matrix = tree.arithmetic.zeros(1, tree.n)
    if isinstance(entry, JointLock):
        speeds = tree.joint(reference.joint(entry.joint)).speeds
        return speed_rows(tree, tree.arithmetic.eye(tree.n)[speeds])
    if isinstance(entry, JointCoupling):
        for name, factor in entry.terms:
            matrix[0, tree.joint(reference.joint(name)).speeds] = tree.arithmetic.number(factor)
        return speed_rows(tree, matrix)
    raise TypeError(type(entry).__name__)


def _distance_rows(reference: ReferenceRobot, at: Kinematics, entry: DistanceAnchor) -> Rows:
    """Return the velocity of one point against the other along the line that joins them."""
    tree = reference.system
    link, other = reference.link(entry.frame), reference.link(entry.other)
    between = tree.arithmetic.zeros(3)
    for name, place, sign in ((link, entry.at, 1), (other, entry.other_at, -1)):
        body, arm = tree.body_of_link(name), tree.arithmetic.array(place)
        if body != WORLD:
            arm = at.origins[body] + at.rotations[body] @ arm
        between = between + sign * arm
    way = between / tree.arithmetic.sqrt(between @ between)
    return point_velocity_rows(tree, at, link, other, entry.at, entry.other_at, way[None])


def _anchor_rows(
    reference: ReferenceRobot, at: Kinematics, entry: PointAnchor | FrameAnchor
) -> Rows:
    tree = reference.system
    link, other = reference.link(entry.frame), reference.link(entry.other)
    first, second = tree.body_of_link(link), tree.body_of_link(other)
    other_at: Any = entry.other_at
    if other_at is None:
        other_at = place = tree.arithmetic.array(entry.at)
        if first != WORLD:
            place = at.origins[first] + at.rotations[first] @ place
        other_at = place
        if second != WORLD:
            other_at = at.rotations[second].T @ (place - at.origins[second])
    axes = tree.arithmetic.eye(3)
    directions: tuple[str, ...] = DIRECTIONS[:3]
    if isinstance(entry, FrameAnchor):
        directions = entry.directions
        if entry.axes == "local" and first != WORLD:
            axes = at.rotations[first].T
    linear = [DIRECTIONS.index(d) for d in directions if d in DIRECTIONS[:3]]
    angular = [DIRECTIONS.index(d) - 3 for d in directions if d in DIRECTIONS[3:]]
    parts = []
    if linear:
        parts.append(point_velocity_rows(tree, at, link, other, entry.at, other_at, axes[linear]))
    if angular:
        parts.append(angular_velocity_rows(tree, link, other, axes[angular]))
    return Rows.stack(tree, parts)
