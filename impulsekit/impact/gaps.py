"""How far the contacts of a scene are from touching, and its anchors from being closed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..geometry.gaps import AT_STOP, before_limit, is_closed, nearest_points, over_plane
from ..robot import Robot
from ..robot.placing import Posture
from ..rows.entries import FunctionRows, frame_pair
from ..scene import Collision, Contact, FrameAnchor, GapContact, JointStop, PointAnchor, Rope, Scene

__all__ = ["AnchorOpening", "ContactGap", "anchor_openings", "contact_gaps"]


@dataclass(frozen=True)
class ContactGap:
    """How far a contact of a scene is from touching, before anything is solved.

    Attributes:
        name: the entry's name.
        gap: [m], of a joint stop to the nearer limit [rad, m]; negative where bodies overlap,
            a point is below its plane or a joint past its limit.
        closing_speed: how fast the gap gets smaller [m/s, rad/s].
        touching: whether ``solve`` counts it as touching: a ``Contact`` whatever its gap.
        angular: whether it is an angle.
        left_out: how many more points of two bodies that touch are close by: further apart than
            the margin, by no more than 1e-3 of the smaller body's size.
    """

    name: str
    gap: float
    closing_speed: float
    touching: bool
    angular: bool = False
    left_out: int = 0


@dataclass(frozen=True)
class AnchorOpening:
    """How far the two points of an anchor are apart in the directions that it holds.

    Attributes:
        name: the entry's name.
        gap: [m]; 0 where there is nothing to be open: a lock, a coupling, an anchor at
            whatever point of the other frame coincides (``other_at=None``).
    """

    name: str
    gap: float


def contact_gaps(
    scene: Scene, posture: Posture[Robot], which: Sequence[int] | None = None
) -> tuple[ContactGap, ...]:
    """The gaps of a scene's contacts in their order, or of those with the indices ``which``."""
    names = scene.entry_names("contacts")
    chosen = range(len(names)) if which is None else which
    return tuple(_contact_gap(posture, scene.contacts[i], names[i]) for i in chosen)


def _contact_gap(posture: Posture[Robot], entry: Any, name: str) -> ContactGap:
    if isinstance(entry, JointStop):
        return _before_stop(posture, entry, name)
    if isinstance(entry, Collision):
        return _between_bodies(posture, entry, name)
    if isinstance(entry, GapContact):
        said = FunctionRows(posture.robot, entry, name)
        gap = float(said.value(posture.q)[0])
        closing = -float(said.matrix_at(posture.q)[2] @ posture.v)
        return ContactGap(name, gap, closing, touching=gap <= AT_STOP)
    if isinstance(entry, Rope):
        return _of_rope(posture, entry, name)
    return _over_plane(posture, entry, name)


def anchor_openings(
    scene: Scene, posture: Posture[Robot], which: Sequence[int] | None = None
) -> tuple[AnchorOpening, ...]:
    """The openings of a scene's constraints, likewise."""
    names = scene.entry_names("held")
    chosen = range(len(scene.constraints)) if which is None else which
    return tuple(AnchorOpening(names[i], _opening(posture, scene.held[i])) for i in chosen)


def _over_plane(posture: Posture[Robot], entry: Contact, name: str) -> ContactGap:
    pair = frame_pair(posture.robot, entry)
    first, other = pair.places(posture.joint)
    normal = pair.axes_at(first, other)[:, 2]
    gap = over_plane(first.translation, normal, other.translation)
    ids = pair.first.joint_id, pair.other.joint_id
    speed = _closing_speed(posture, [(first.translation, normal)], *ids)
    return ContactGap(name, gap, speed, touching=True)


def _of_rope(posture: Posture[Robot], entry: Rope, name: str) -> ContactGap:
    pair = frame_pair(posture.robot, entry)
    places = pair.places(posture.joint)
    here, there = (place.translation for place in places)
    gap = entry.length - float(np.linalg.norm(here - there))
    w = posture.velocity_at(pair.first.joint_id, here)
    w = w - posture.velocity_at(pair.other.joint_id, there)
    closing = -float(pair.axes_at(*places)[:, 2] @ w)
    return ContactGap(name, gap, closing, touching=is_closed(gap, entry.length))


def _before_stop(posture: Posture[Robot], entry: JointStop, name: str) -> ContactGap:
    robot = posture.robot
    joint = robot.model.joints[robot.joint_id(entry.joint)]
    turns = bool(posture.motion_subspace(joint.id)[3:].any())
    value, speed = posture.q[joint.idx_q], posture.v[joint.idx_v]
    sides = [
        (before_limit(value, limit, sign), sign, limit)
        for limit, sign in zip(entry.limits(robot), (1.0, -1.0), strict=True)
    ]
    gap, sign, limit = min(sides)
    touching = is_closed(gap, limit)
    return ContactGap(name, float(gap), float(-sign * speed), touching, angular=turns)


def _between_bodies(posture: Posture[Robot], entry: Collision, name: str) -> ContactGap:
    from ..geometry.collision import meeting_points
    from ..rows.bodies import CLOSE_BY, bodies_of

    bodies = bodies_of(posture.robot, entry)
    first, other = (
        [(solid, posture.joint(joint_id) * own) for solid, own in pieces]
        for pieces, joint_id in zip(bodies.pieces, bodies.joint_ids, strict=True)
    )
    gap, points = nearest_points(first, other, bodies.margin)
    speed = _closing_speed(posture, points, *bodies.joint_ids)
    touching, left_out = gap <= bodies.margin, 0
    if touching:
        close = meeting_points(first, other, bodies.margin + CLOSE_BY * bodies.size)
        left_out = sum(point.gap > bodies.margin for point in close)
    return ContactGap(name, gap, speed, touching, left_out=left_out)


def _closing_speed(posture: Posture[Robot], points: Any, first: int, other: int) -> float:
    """−n·(v_first − v_other) at the points of the world that are nearest; the largest."""
    return max(
        (
            float(-normal @ (posture.velocity_at(first, at) - posture.velocity_at(other, at)))
            for at, normal in points
        ),
        default=0.0,
    )


def _opening(posture: Posture[Robot], entry: Any) -> float:
    if not isinstance(entry, PointAnchor | FrameAnchor) or entry.other_at is None:
        return 0.0
    pair = frame_pair(posture.robot, entry)
    first, other = pair.places(posture.joint)
    way = pair.axes_at(first, other).T @ (first.translation - other.translation)
    return float(np.linalg.norm(way[pair.linear]))
