"""Every impulse of an answer as a wrench on a body, on Pinocchio, for audits."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ..robot.base import RobotFrame
from ..rows.entries import FramePair, PlacementOf, Site, frame_pair, rows_of_entry
from ..scene import AppliedImpulse

if TYPE_CHECKING:
    from .touched import TouchedAnswer

__all__ = [
    "BodyImpulse",
    "body_impulses",
]


@dataclass(frozen=True, eq=False)
class BodyImpulse:
    """An impulse that acts on one frame's body from outside it.

    Attributes:
        frame_id: the frame in the robot's model.
        joint_id: the joint that carries it; 0 for the world.
        wrench_in_joint: the spatial impulse in the joint's frame.
        entry: the name of the scene's entry behind it.
    """

    frame_id: int
    joint_id: int
    wrench_in_joint: pin.Force
    entry: str = ""


def body_impulses(impact: TouchedAnswer) -> Iterator[BodyImpulse]:
    """All impulses on links: blows, and both ends of every anchor."""
    scene, placement_of = impact.scene, impact.mechanics.joint_placement
    for name, entry in zip(scene.entry_names("impulses"), scene.impulses, strict=True):
        if isinstance(entry, AppliedImpulse):
            wrench = np.array(entry.values)
            site = frame_pair(scene.robot, entry).first
            yield _at_point(placement_of, site, wrench, entry.axes, name)
    for constraint, result in zip(scene.held, impact.constraints, strict=True):
        said = rows_of_entry(scene.robot, constraint)
        if isinstance(said, FramePair):
            yield from _on_both_ends(placement_of, said, result.impulse, result.name)
    if impact.outcome is None:
        return
    points = iter([point for result in impact.contacts for point in result.points])
    # Results keep the order of the touching points, contact by contact.
    for touch in impact.outcome.touches:
        if touch.turns >= 0:
            continue
        point = next(points)
        if point.position is None:
            continue
        moment = np.zeros(3) if point.turning is None else point.turning.impulse
        wrench = np.concatenate([point.impulse, moment])
        name, ids = scene.entry_names("contacts")[touch.entry], (touch.joint_ids, touch.frame_ids)
        for sign, joint_id, frame_id in zip((1.0, -1.0), *ids, strict=True):
            own = placement_of(joint_id).actInv(np.array(point.position))
            site = Site(RobotFrame.of(frame_id, joint_id, pin.SE3(np.eye(3), own)))
            yield _at_point(placement_of, site, sign * wrench, "world", name)


def _on_both_ends(
    placement_of: PlacementOf, said: FramePair, impulse: np.ndarray, name: str
) -> Iterator[BodyImpulse]:
    """Return the wrenches on two frames of the (k,) impulses or forces of their rows."""
    first, at_other = said.places(placement_of)
    wrench = said.wrench(impulse, said.axes_at(first, at_other))
    yield _at_point(placement_of, said.first, wrench, "world", name)
    other = said.other
    if said.coincides:
        other = Site(other.frame, other.at + at_other.actInv(first.translation))
    yield _at_point(placement_of, other, -wrench, "world", name)


def _at_point(
    placement_of: PlacementOf, site: Site, wrench: np.ndarray, axes: str, entry: str = ""
) -> BodyImpulse:
    """A wrench at a point of a frame, brought to the frame's joint.

    Only rotations and distances within the body enter, so no place in the world costs digits.
    """
    if axes == "world":
        rotation = placement_of(site.joint_id).rotation @ site.placement.rotation
        wrench = np.concatenate([wrench[:3] @ rotation, wrench[3:] @ rotation])
    return BodyImpulse(site.frame_id, site.joint_id, site.placement.act(pin.Force(wrench)), entry)
