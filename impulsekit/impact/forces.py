"""Every impulse of an answer as a wrench on a body, for reactions and audits."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ..rows.entries import FramePair, Site, frame_pair, rows_of_entry
from ..scene import AppliedImpulse

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
            site = frame_pair(scene.robot, entry).first
            yield _at_point(impact, site, wrench, entry.axes, name)
    for constraint, result in zip(scene.constraints, impact.constraints, strict=True):
        said = rows_of_entry(scene.robot, constraint)
        if isinstance(said, FramePair):
            yield from _both_ends(impact, said, result.impulse, result.name)
    yield from _contact_impulses(impact)


def _both_ends(
    impact: Impact, said: FramePair, impulse: np.ndarray, name: str
) -> Iterator[BodyImpulse]:
    wrench = np.zeros(6)
    wrench[list(said.select)] = impulse
    mechanics = impact.mechanics
    carrier, axes = said.carrying
    axes = axes if carrier == 0 else mechanics.joint_placement(carrier).rotation @ axes
    wrench = np.concatenate([axes @ wrench[:3], axes @ wrench[3:]])
    yield _at_point(impact, said.first, wrench, "world", name)
    other = said.other
    if said.coincides:
        first, at_other = (
            mechanics.joint_placement(site.joint_id) * site.placement
            for site in (said.first, said.other)
        )
        own = at_other.actInv(first.translation)
        other = replace(other, placement=other.placement * pin.SE3(np.eye(3), own))
    yield _at_point(impact, other, -wrench, "world", name)


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
    impact: Impact, site: Site, wrench: np.ndarray, axes: str, entry: str = ""
) -> BodyImpulse:
    """A wrench at a point of a frame, brought to the frame's joint.

    Only rotations and distances within the body enter, so no place in the world costs digits.
    """
    if axes == "world":
        rotation = impact.mechanics.joint_placement(site.joint_id).rotation
        rotation = rotation @ site.placement.rotation
        wrench = np.concatenate([wrench[:3] @ rotation, wrench[3:] @ rotation])
    return BodyImpulse(site.frame_id, site.joint_id, site.placement.act(pin.Force(wrench)), entry)
