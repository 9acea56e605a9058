"""Gaps of the contacts of a scene, and openings of its anchors."""

from __future__ import annotations

import heapq
from collections.abc import Container, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import coal
import numpy as np

from .._core import Nearest, contact_points, nearest_points
from ..geometry.axes import core_place
from ..robot import Robot
from ..robot.geometry import geometry_ids
from ..robot.placing import Posture
from ..rows.bodies import Bodies, Body, bodies_between, body_of
from ..rows.entries import frame_pair
from ..scene import Collision, FrameAnchor, JointStop, PointAnchor, Scene
from ..scene.scene import SceneCache
from .flat.scene import flat_of

__all__ = [
    "AnchorOpening",
    "ContactGap",
    "anchor_openings",
    "bodies_close_by",
    "contact_gaps",
    "nearest_contacts",
]


# Points of two flat sides whose gaps differ by less belong to one patch [m].
ONE_PATCH = 1e-9
# Beyond it a body has no end, such as a plane [m].
BOUNDLESS = 1e6
# How far a pair of bodies has been looked at.
BOXED, CORNERED, MEASURED = range(3)


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
        reach: the gap of the furthest of these [m].
        margin: of two bodies [m].
    """

    name: str
    gap: float
    closing_speed: float
    touching: bool
    angular: bool = False
    left_out: int = 0
    reach: float = 0.0
    margin: float = 0.0


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
    chosen = range(len(names)) if which is None else which
    if not chosen:
        return ()
    flat, (q, v) = flat_of(scene), (posture.q, posture.v)
    touching = set(flat.rows(q, v).entries)
    found = flat.rows(q, v, only=[not isinstance(x, Collision) for x in scene.contacts])
    closing = -(found.J.reshape(-1, 3, len(v))[: len(found.gaps), 2] @ v)
    told = zip(found.gaps.tolist(), closing.tolist(), strict=True)
    by_entry = dict(zip(found.entries, told, strict=True))
    gaps = []
    for i in chosen:
        entry = scene.contacts[i]
        if isinstance(entry, Collision):
            gaps.append(_between_bodies(posture, _pairs.of(scene), i, names[i]))
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


def bodies_close_by(scene: Scene, posture: Posture[Robot]) -> list[int]:
    """The indices of the collisions with points that touch or are close by."""
    pairs = _pairs.of(scene)
    return [
        i
        for i, bound in zip(pairs.bodies, pairs.bounds(posture).tolist(), strict=True)
        if bound <= pairs.bodies[i].close and _Pair(posture, pairs, i).close
    ]


def nearest_contacts(
    scene: Scene, posture: Posture[Robot], count: int = 1, without: Container[int] = ()
) -> tuple[ContactGap, ...]:
    """The contacts with the least gaps, those with the indices ``without`` left out.

    Best first: a pair of bodies waits by its boxes, then by its corners, then by its gap.
    """
    pairs = _pairs.of(scene)
    others = [i for i in range(len(scene.contacts)) if i not in without and i not in pairs.bodies]
    found = contact_gaps(scene, posture, others)
    waiting = [(item.gap, MEASURED, i) for i, item in zip(others, found, strict=True)]
    bounds = zip(pairs.bounds(posture).tolist(), pairs.bodies, strict=True)
    waiting += [(bound, BOXED, i) for bound, i in bounds if i not in without]
    heapq.heapify(waiting)
    nearest: list[int] = []
    while waiting and len(nearest) < count:
        gap, stage, i = heapq.heappop(waiting)
        if stage == MEASURED:
            nearest.append(i)
        elif stage == CORNERED:
            heapq.heappush(waiting, (_Pair(posture, pairs, i).nearest.gap, MEASURED, i))
        else:
            heapq.heappush(waiting, (max(gap, pairs.apart(posture, i)), CORNERED, i))
    return contact_gaps(scene, posture, nearest)


class _Pairs:
    """The collisions of a scene, kept with it: their bodies, and boxes around these.

    Attributes:
        bodies: of each ``Collision``, by its index.
    """

    def __init__(self, scene: Scene) -> None:
        robot = scene.robot
        made: dict[str, Body] = {}
        self.bodies: dict[int, Bodies] = {}
        ends: list[tuple[str, str]] = []
        for i, entry in enumerate(scene.contacts):
            if isinstance(entry, Collision):
                names = entry.first, entry.other
                made.update((x, body_of(robot, x)) for x in names if x not in made)
                first, other = (made[x] for x in names)
                self.bodies[i] = bodies_between(first, other, entry.margin)
                ends.append(names)
        places = {name: k for k, name in enumerate(made)}
        self._ends = np.array([[places[x] for x in names] for names in ends], dtype=int)
        self._joints = [body.joint_id for body in made.values()]
        # All corners of a body in its joint's axes; None of one without an end, such as a plane.
        self._corners = [_corners(robot, name) for name in made]
        boxes = [_box(corners) for corners in self._corners]
        self._centres = np.array([box[0] for box in boxes]).reshape(-1, 3)
        self._halves = np.array([box[1] for box in boxes]).reshape(-1, 3)
        self._at = {i: k for k, i in enumerate(self.bodies)}

    def bounds(self, posture: Posture[Robot]) -> np.ndarray:
        """(pairs,) lower bounds of the gaps [m], 0 or more: of boxes along either body's axes."""
        if not self.bodies:
            return np.zeros(0)
        places = [posture.joint(joint) for joint in self._joints]
        turns = np.array([place.rotation for place in places])
        middles = np.array([place.translation for place in places])
        middles += np.einsum("ijk,ik->ij", turns, self._centres)
        ways = self._ends.T, self._ends.T[::-1]
        return np.maximum(*(self._apart(turns, middles, one, two) for one, two in ways))

    def _apart(
        self, turns: np.ndarray, middles: np.ndarray, one: np.ndarray, two: np.ndarray
    ) -> np.ndarray:
        """(pairs,) distances between boxes along the axes of the bodies ``one`` [m]."""
        way = np.einsum("ikj,ik->ij", turns[one], middles[two] - middles[one])
        turned = np.abs(np.einsum("ikj,ikl->ijl", turns[one], turns[two]))
        with np.errstate(invalid="ignore"):
            halves = self._halves[one] + np.einsum("ijk,ik->ij", turned, self._halves[two])
        # Infinite half sides times 0.
        halves[np.isnan(halves)] = np.inf
        found: np.ndarray = np.linalg.norm(np.maximum(np.abs(way) - halves, 0.0), axis=1)
        return found

    def apart(self, posture: Posture[Robot], index: int) -> float:
        """A lower bound of a gap [m]: how far a plane across some direction parts the bodies."""
        ends = self._ends[self._at[index]].tolist()
        places = [posture.joint(self._joints[k]) for k in ends]
        corners = [self._corners[k] for k in ends]
        if corners[0] is None or corners[1] is None:
            return -np.inf
        first, other = (
            p.translation + c @ p.rotation.T for p, c in zip(places, corners, strict=True)
        )
        way = other.mean(axis=0) - first.mean(axis=0)
        ways = np.column_stack([way / (np.linalg.norm(way) or 1.0), *(p.rotation for p in places)])
        one, two = first @ ways, other @ ways
        sides = two.min(axis=0) - one.max(axis=0), one.min(axis=0) - two.max(axis=0)
        return float(np.max(sides))


_pairs: SceneCache[_Pairs] = SceneCache(_Pairs)


def _corners(robot: Robot, name: str) -> np.ndarray | None:
    """(n, 3) corners of a body in its joint's axes, of round pieces those of their boxes."""
    found = []
    for index in geometry_ids(robot, name)[0]:
        piece = robot.collision_model.geometryObjects[index]
        piece.geometry.computeLocalAABB()
        box = piece.geometry.aabb_local
        if not np.abs([box.min_, box.max_]).max() < BOUNDLESS:
            return None
        own = np.array([(x, y, z) for x, y, z in product(*zip(box.min_, box.max_, strict=True))])
        if isinstance(piece.geometry, coal.BVHModelBase):
            own = np.array(piece.geometry.vertices())
        found.append(own @ piece.placement.rotation.T + piece.placement.translation)
    return np.concatenate(found)


def _box(corners: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """Middle and half sides of a box around corners."""
    if corners is None:
        return np.zeros(3), np.full(3, np.inf)
    low, high = corners.min(axis=0), corners.max(axis=0)
    return 0.5 * (low + high), 0.5 * (high - low)


class _Pair:
    """The two bodies of a Collision where they are."""

    def __init__(self, posture: Posture[Robot], pairs: _Pairs, index: int) -> None:
        self.bodies = pairs.bodies[index]
        both = self.bodies.first, self.bodies.other
        self.shapes = [body.shapes for body in both]
        self.places = [core_place(posture.joint(body.joint_id)) for body in both]

    def touching(self, within: float) -> list[Any]:
        """The points no further apart [m]."""
        return contact_points(
            self.shapes[0], self.places[0], self.shapes[1], self.places[1], within
        )

    @property
    def nearest(self) -> Nearest:
        """The least gap, its normal and the points of both there."""
        (first, other), (one, two) = self.shapes, self.places
        found = (nearest_points(a, one, b, two) for a in first for b in other)
        return min(found, key=lambda each: each.gap)

    @property
    def close(self) -> list[Any]:
        """The points that touch or are close by."""
        return self.touching(self.bodies.close)


def _between_bodies(posture: Posture[Robot], pairs: _Pairs, index: int, name: str) -> ContactGap:
    pair = _Pair(posture, pairs, index)
    bodies = pair.bodies
    first, other, close = bodies.first, bodies.other, pair.close
    points = [(point.point, point.normal) for point in close if point.gap <= bodies.margin]
    left_out = len(close) - len(points)
    if points:
        gap = min(point.gap for point in close)
    else:
        found = pair.nearest
        gap = found.gap
        # Flat sides that face each other are nearest at all corners of what they share.
        flat = pair.touching(gap + ONE_PATCH)
        points = [(point.point, point.normal) for point in flat]
        points = points or [(0.5 * (found.on_first + found.on_other), found.normal)]
    speed = max(
        float(
            normal
            @ (posture.velocity_at(other.joint_id, at) - posture.velocity_at(first.joint_id, at))
        )
        for at, normal in points
    )
    reach = max((point.gap for point in close), default=0.0)
    touches = gap <= bodies.margin
    return ContactGap(name, gap, speed, touches, False, left_out, reach, bodies.margin)


def _opening(posture: Posture[Robot], entry: Any) -> float:
    if not isinstance(entry, PointAnchor | FrameAnchor) or entry.other_at is None:
        return 0.0
    pair = frame_pair(posture.robot, entry)
    first, other = pair.places(posture.joint)
    way = pair.axes_at(first, other).T @ (first.translation - other.translation)
    return float(np.linalg.norm(way[pair.linear]))
