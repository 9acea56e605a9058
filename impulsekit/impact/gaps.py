"""How far the contacts of a scene are from touching, and its anchors from being closed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..robot import Robot
from ..robot.placing import Posture
from ..rows.entries import frame_pair
from ..scene import Collision, FrameAnchor, JointStop, PointAnchor, Scene
from .flat.scene import flat_of

__all__ = ["AnchorOpening", "ContactGap", "anchor_openings", "contact_gaps"]


# Points of two flat sides whose gaps differ by less belong to one patch [m].
ONE_PATCH = 1e-9


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
    if not names:
        return ()
    flat, (q, v) = flat_of(scene), (posture.q, posture.v)
    touching = set(flat.rows(q, v).entries)
    found = flat.rows(q, v, only=[not isinstance(x, Collision) for x in scene.contacts])
    closing = -(found.J.reshape(-1, 3, len(v))[: len(found.gaps), 2] @ v)
    told = zip(found.gaps.tolist(), closing.tolist(), strict=True)
    by_entry = dict(zip(found.entries, told, strict=True))
    gaps = []
    for i in range(len(names)) if which is None else which:
        entry = scene.contacts[i]
        if isinstance(entry, Collision):
            gaps.append(_between_bodies(posture, entry, names[i]))
            continue
        # A stop without limits is nowhere.
        gap, speed = by_entry.get(i, (np.inf, 0.0))
        angular = isinstance(entry, JointStop) and _turns(posture, entry)
        gaps.append(ContactGap(names[i], gap, speed, i in touching, angular))
    return tuple(gaps)


def _turns(posture: Posture[Robot], entry: JointStop) -> bool:
    """Whether the joint of a stop turns."""
    return bool(posture.motion_subspace(posture.robot.joint_id(entry.joint))[3:].any())


def anchor_openings(
    scene: Scene, posture: Posture[Robot], which: Sequence[int] | None = None
) -> tuple[AnchorOpening, ...]:
    """The openings of a scene's constraints, likewise."""
    names = scene.entry_names("held")
    chosen = range(len(scene.constraints)) if which is None else which
    return tuple(AnchorOpening(names[i], _opening(posture, scene.held[i])) for i in chosen)


def _between_bodies(posture: Posture[Robot], entry: Collision, name: str) -> ContactGap:
    from .._core import nearest_points, touching
    from ..geometry.axes import place_numbers
    from ..rows.bodies import CLOSE_BY, bodies_of

    bodies = bodies_of(posture.robot, entry)
    first, other = bodies.first, bodies.other
    one, two = (place_numbers(posture.joint(body.joint_id)) for body in (first, other))
    within = bodies.margin + CLOSE_BY * bodies.size
    close = touching(first.shapes, one, other.shapes, two, within)
    points = [(point.point, point.normal) for point in close if point.gap <= bodies.margin]
    left_out = len(close) - len(points) if points else 0
    if points:
        gap = min(point.gap for point in close)
    else:
        found = min(
            (nearest_points(a, one, b, two) for a in first.shapes for b in other.shapes),
            key=lambda numbers: float(numbers[0]),
        )
        gap = float(found[0])
        # Flat sides that face each other are nearest at all corners of what they share.
        flat = touching(first.shapes, one, other.shapes, two, gap + ONE_PATCH)
        points = [(point.point, point.normal) for point in flat]
        points = points or [(0.5 * (found[4:7] + found[7:]), found[1:4])]
    speed = max(
        float(
            normal
            @ (posture.velocity_at(other.joint_id, at) - posture.velocity_at(first.joint_id, at))
        )
        for at, normal in points
    )
    return ContactGap(name, gap, speed, gap <= bodies.margin, left_out=left_out)


def _opening(posture: Posture[Robot], entry: Any) -> float:
    if not isinstance(entry, PointAnchor | FrameAnchor) or entry.other_at is None:
        return 0.0
    pair = frame_pair(posture.robot, entry)
    first, other = pair.places(posture.joint)
    way = pair.axes_at(first, other).T @ (first.translation - other.translation)
    return float(np.linalg.norm(way[pair.linear]))
