"""Gaps of the contacts of a scene, and openings of its anchors."""

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

__all__ = [
    "AnchorOpening",
    "ContactGap",
    "anchor_openings",
    "contact_gaps",
    "contacts_close_by",
    "nearest_contact",
]


# Points of two flat sides whose gaps differ by less belong to one patch [m].
ONE_PATCH = 1e-9


@dataclass(frozen=True)
class ContactGap:
    """The gap of a contact of a scene, without solving.

    Attributes:
        name: the entry's name.
        gap: [m], of a joint stop to the nearer limit [rad, m]; negative where bodies overlap,
            a point is below its plane or a joint past its limit.
        closing_speed: how fast the gap gets smaller [m/s, rad/s].
        touching: whether ``solve`` counts it as touching: a ``Contact`` whatever its gap.
        angular: whether it is an angle.
        left_out: how many more points of two bodies are close by: further apart than the margin,
            by no more than 1e-3 of the smaller body's size.
    """

    name: str
    gap: float
    closing_speed: float
    touching: bool
    angular: bool = False
    left_out: int = 0


@dataclass(frozen=True)
class AnchorOpening:
    """The distance between the two points of an anchor in the directions that it holds.

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
    """Return True if the joint of a stop is revolute."""
    return bool(posture.motion_subspace(posture.robot.joint_id(entry.joint))[3:].any())


def anchor_openings(
    scene: Scene, posture: Posture[Robot], which: Sequence[int] | None = None
) -> tuple[AnchorOpening, ...]:
    """The openings of a scene's constraints, likewise."""
    names = scene.entry_names("held")
    chosen = range(len(scene.constraints)) if which is None else which
    return tuple(AnchorOpening(names[i], _opening(posture, scene.held[i])) for i in chosen)


def contacts_close_by(scene: Scene, posture: Posture[Robot]) -> list[int]:
    """The indices of the contacts that touch, and of bodies with points close by."""
    touched = set(flat_of(scene).rows(posture.q, posture.v).entries)
    return [
        i
        for i, entry in enumerate(scene.contacts)
        if i in touched or (isinstance(entry, Collision) and _Pair(posture, entry).close)
    ]


def nearest_contact(scene: Scene, posture: Posture[Robot]) -> ContactGap:
    """The contact with the least gap; of bodies the balls around them decide who is looked at."""
    pairs = {i: x for i, x in enumerate(scene.contacts) if isinstance(x, Collision)}
    rest = [i for i in range(len(scene.contacts)) if i not in pairs]
    found = list(contact_gaps(scene, posture, rest)) if rest else []
    names = scene.entry_names("contacts")
    for bound, i in sorted((_Pair(posture, entry).bound, i) for i, entry in pairs.items()):
        if found and bound > min(item.gap for item in found):
            break
        found.append(_between_bodies(posture, pairs[i], names[i]))
    return min(found, key=lambda item: item.gap)


class _Pair:
    """The two bodies of a Collision where they are."""

    def __init__(self, posture: Posture[Robot], entry: Collision) -> None:
        from ..geometry.axes import place_numbers
        from ..rows.bodies import bodies_of

        self.bodies = bodies_of(posture.robot, entry)
        both = self.bodies.first, self.bodies.other
        self.places = [posture.joint(body.joint_id) for body in both]
        self.shapes = [body.shapes for body in both]
        self.numbers = [place_numbers(place) for place in self.places]

    def touching(self, within: float) -> list[Any]:
        """The points no further apart [m]."""
        from .._core import touching

        return touching(self.shapes[0], self.numbers[0], self.shapes[1], self.numbers[1], within)

    @property
    def close(self) -> list[Any]:
        """The points that touch or are close by."""
        from ..rows.bodies import CLOSE_BY

        return self.touching(self.bodies.margin + CLOSE_BY * self.bodies.size)

    @property
    def bound(self) -> float:
        """A lower bound of the gap, by the balls around the pieces [m]."""
        (one, two), (a, b) = self.shapes, self.places
        return min(
            float(np.linalg.norm(a.act(x.centre) - b.act(y.centre))) - x.reach - y.reach
            for x in one
            for y in two
        )


def _between_bodies(posture: Posture[Robot], entry: Collision, name: str) -> ContactGap:
    from .._core import nearest_points

    pair = _Pair(posture, entry)
    bodies, (one, two) = pair.bodies, pair.numbers
    first, other, close = bodies.first, bodies.other, pair.close
    points = [(point.point, point.normal) for point in close if point.gap <= bodies.margin]
    left_out = len(close) - len(points)
    if points:
        gap = min(point.gap for point in close)
    else:
        found = min(
            (nearest_points(a, one, b, two) for a in first.shapes for b in other.shapes),
            key=lambda numbers: float(numbers[0]),
        )
        gap = float(found[0])
        # Flat sides that face each other are nearest at all corners of what they share.
        flat = pair.touching(gap + ONE_PATCH)
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
