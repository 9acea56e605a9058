"""Every impulse of an answer as a wrench on a body, for reactions and audits."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ..scene import AppliedImpulse, FrameAnchor, PointAnchor
from ..scene.constraints import DIRECTIONS

if TYPE_CHECKING:
    from .result import Impact

__all__ = ["BodyImpulse", "body_impulses"]


@dataclass(frozen=True, eq=False)
class BodyImpulse:
    """An impulse that acts on one frame's body from outside it.

    Attributes:
        frame_id: the frame in the robot's model.
        joint_id: the joint that carries it; 0 for the world.
        wrench_in_joint: the spatial impulse in the joint's frame.
        entry: the name of the scene's impulse or constraint behind it; "" for what a
            solver found on its own.
    """

    frame_id: int
    joint_id: int
    wrench_in_joint: pin.Force
    entry: str = ""


def body_impulses(impact: Impact) -> Iterator[BodyImpulse]:
    """All impulses on links: blows, and both ends of every anchor."""
    scene = impact.scene
    for name, entry in zip(scene.entry_names("impulses"), scene.impulses, strict=True):
        if isinstance(entry, AppliedImpulse):
            wrench = np.array([*entry.linear, *entry.angular])
            yield _at_point(impact, entry.frame, entry.at, wrench, entry.axes, name)
    for constraint, result in zip(scene.constraints, impact.constraints, strict=True):
        if isinstance(constraint, PointAnchor | FrameAnchor):
            yield from _both_ends(impact, constraint, result.impulse, result.name)
    yield from _contact_impulses(impact)


def _both_ends(
    impact: Impact, anchor: PointAnchor | FrameAnchor, impulse: np.ndarray, name: str
) -> Iterator[BodyImpulse]:
    directions = anchor.directions if isinstance(anchor, FrameAnchor) else DIRECTIONS[:3]
    wrench = np.zeros(6)
    wrench[[DIRECTIONS.index(d) for d in directions]] = impulse
    mechanics = impact.mechanics
    first = mechanics.frame_placement(anchor.frame)
    if isinstance(anchor, FrameAnchor) and anchor.axes == "local":
        wrench = np.concatenate([first.rotation @ wrench[:3], first.rotation @ wrench[3:]])
    yield _at_point(impact, anchor.frame, anchor.at, wrench, "world", name)
    other_at = anchor.other_at
    if other_at is None:
        point = first.act(np.array(anchor.at))
        other_at = mechanics.frame_placement(anchor.other).actInv(point)
    yield _at_point(impact, anchor.other, other_at, -wrench, "world", name)


def _contact_impulses(impact: Impact) -> Iterator[BodyImpulse]:
    outcome = impact.outcome
    if outcome is None:
        return
    points = iter([point for result in impact.contacts for point in result.points])
    # Results keep the order of the touching points, contact by contact.
    for touch in outcome.touches:
        point = next(points)
        if point.position is None:
            continue
        for sign, joint_id, frame_id in zip(
            (1.0, -1.0), touch.joint_ids, touch.frame_ids, strict=True
        ):
            placement = impact.mechanics.joint_placement(joint_id)
            linear = placement.rotation.T @ (sign * point.impulse)
            arm = placement.actInv(np.array(point.position))
            yield BodyImpulse(frame_id, joint_id, pin.Force(linear, np.cross(arm, linear)))


def _at_point(
    impact: Impact, frame: str, at: object, wrench: np.ndarray, axes: str, entry: str = ""
) -> BodyImpulse:
    """A wrench at a point of a frame, brought to the frame's joint.

    Only rotations and distances within the body enter, so no place in the world costs digits.
    """
    robot = impact.scene.robot
    frame_id = robot.frame_id(frame)
    item = robot.model.frames[frame_id]
    placement = item.placement * pin.SE3(np.eye(3), np.array(at, dtype=float))
    if axes == "world":
        rotation = impact.mechanics.frame_placement(frame).rotation
        wrench = np.concatenate([wrench[:3] @ rotation, wrench[3:] @ rotation])
    return BodyImpulse(frame_id, item.parentJoint, placement.act(pin.Force(wrench)), entry)
