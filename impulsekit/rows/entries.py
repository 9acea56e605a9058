"""Rows of an entry of a scene: between two frames, or of joints' own speeds.

The core makes rows of them, ``core/scene/rows.hpp``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
import pinocchio as pin

from ..errors import InputError
from ..geometry.axes import contact_axes
from ..robot import Robot
from ..robot.base import RobotFrame
from ..scene import (
    AppliedImpulse,
    Contact,
    DistanceAnchor,
    Driven,
    FrameAnchor,
    GapConstraint,
    GapContact,
    JointCoupling,
    JointImpulse,
    JointLock,
    JointStop,
    PointAnchor,
    Rope,
)
from ..scene.constraints import DIRECTIONS
from ..scene.gap_functions import FunctionRows

__all__ = [
    "FramePair",
    "FunctionRows",
    "JointRows",
    "PlacementOf",
    "Site",
    "axes_of_line",
    "frame_pair",
    "joint_rows",
    "rows_of_entry",
    "vectors_of_rows",
]

# From a joint to the placement of its frame in the world.
PlacementOf = Callable[[int], pin.SE3]

# Points nearer than this [m] have no direction between them.
NO_LENGTH = 1e-12


class Site(NamedTuple):
    """A point of a frame.

    Attributes:
        frame: the frame.
        at: (3,) the point in its coordinates [m].
    """

    frame: RobotFrame
    at: Any = (0.0, 0.0, 0.0)

    @classmethod
    def of(cls, robot: Robot, frame: str, at: Any = (0.0, 0.0, 0.0)) -> Site:
        """The point ``at`` (3,) of a frame."""
        return cls(robot.frame(frame), at)

    @property
    def joint_id(self) -> int:
        """The joint of the whole model that carries it; 0 for the world."""
        return self.frame.joint_id

    @property
    def frame_id(self) -> int:
        """The number of its frame in the whole model."""
        return self.frame.frame_id

    @property
    def placement(self) -> pin.SE3:
        """The placement of the point, with the axes of its frame, in the joint."""
        return pin.SE3(self.frame.rotation, self.point)

    @property
    def point(self) -> np.ndarray:
        """(3,) the point in the axes of the joint."""
        if not any(self.at):
            return self.frame.origin
        found: np.ndarray = self.frame.placement.act(np.array(self.at, dtype=float))
        return found

    @property
    def moves(self) -> bool:
        """True if a joint carries it."""
        return self.frame.joint_id > 0


class FramePair(NamedTuple):
    """Rows of the velocity of one frame relative to another.

    Attributes:
        first, other: the points.
        coincides: whether the rows are of the point of ``other`` that coincides with that of
            ``first``; where ``other`` stands still, its points are all alike.
        carrier: what the axes R turn with: the world, one of the frames, or "line", the line
            from the point of ``other`` to that of ``first``, along which the last axis points.
        axes: (3, 3) R in those of the carrier; of the line diag(1, 1, ±1), with −1 where the
            last axis points back.
        select: which of the six rows there are, linear before angular.
        labels: of these rows.
    """

    first: Site
    other: Site
    coincides: bool
    carrier: Literal["world", "first", "other", "line"]
    axes: np.ndarray
    select: tuple[int, ...]
    labels: tuple[str, ...]

    def places(self, placement_of: PlacementOf) -> tuple[pin.SE3, pin.SE3]:
        """Both points in the world, with the axes of their frames.

        ``placement_of`` gives the placements of joints of the whole model.
        """
        first, other = self.first, self.other
        return (
            placement_of(first.joint_id) * first.placement,
            placement_of(other.joint_id) * other.placement,
        )

    def axes_at(self, first: pin.SE3, other: pin.SE3) -> np.ndarray:
        """(3, 3) R in the world, given ``places``."""
        if self.carrier == "world":
            return self.axes
        if self.carrier == "line":
            return axes_of_line(first.translation - other.translation, self.axes)
        carrier = first if self.carrier == "first" else other
        return carrier.rotation.dot(self.axes)

    def wrench(self, impulse: np.ndarray, axes: np.ndarray) -> np.ndarray:
        """(6,) in world axes: what the rows (k,) give the first frame at its point.

        ``axes``: (3, 3) R in the world.
        """
        wrench = np.zeros(6)
        wrench[list(self.select)] = impulse
        return np.concatenate([axes @ wrench[:3], axes @ wrench[3:]])

    @property
    def linear(self) -> list[int]:
        """The axes among x, y, z of its rows."""
        return [row for row in self.select if row < 3]

    @property
    def angular(self) -> list[int]:
        """About which of x, y, z its rows turn."""
        return [row - 3 for row in self.select if row > 2]


@dataclass(frozen=True)
class JointRows:
    """Rows that do not depend on the configuration.

    Attributes:
        terms: by row, (joint of the whole model, which of its degrees of freedom, factor).
        labels: of the rows.
        whole_joint: whether the rows are one joint's own speeds, all of them.
    """

    terms: tuple[tuple[tuple[int, int, float], ...], ...]
    labels: tuple[str, ...]
    whole_joint: bool = False

    def matrix(self, model: pin.Model, joint_id: Callable[[int], int] | None = None) -> np.ndarray:
        """(k, nv) the rows on a model; ``joint_id`` finds its joints by those of the whole one."""
        rows = np.zeros((len(self.terms), model.nv))
        for row, terms in zip(rows, self.terms, strict=True):
            for joint, degree, factor in terms:
                own = joint if joint_id is None else joint_id(joint)
                row[model.idx_vs[own] + degree] = factor
        return rows


def rows_of_entry(robot: Robot, entry: Any) -> FramePair | JointRows | FunctionRows:
    """Return the rows of an impulse, constraint or contact.

    A contact's rows are t₁, t₂, n; those of a joint stop its joint's speed. A ``Collision`` has no
    frames of its own: its points are found state by state.
    """
    return _SAYS[type(entry)](robot, entry)


def frame_pair(robot: Robot, entry: Any) -> FramePair:
    """Return the pair of frames of an entry: an applied impulse, an anchor, a ``Contact``."""
    said = rows_of_entry(robot, entry)
    if not isinstance(said, FramePair):
        raise TypeError(type(entry).__name__)
    return said


def joint_rows(robot: Robot, entry: Any) -> JointRows:
    """Return the joint rows of an entry: a joint impulse, a lock, a coupling, a stop."""
    said = rows_of_entry(robot, entry)
    if not isinstance(said, JointRows):
        raise TypeError(type(entry).__name__)
    return said


def _blow(robot: Robot, entry: AppliedImpulse) -> FramePair:
    carrier: Literal["world", "first"] = "first" if entry.axes == "local" else "world"
    site, world = Site.of(robot, entry.frame, entry.at), Site.of(robot, "world")
    return FramePair(site, world, True, carrier, np.eye(3), tuple(range(6)), DIRECTIONS)


def _anchor(robot: Robot, entry: PointAnchor | FrameAnchor) -> FramePair:
    labels = entry.directions if isinstance(entry, FrameAnchor) else DIRECTIONS[:3]
    local = isinstance(entry, FrameAnchor) and entry.axes == "local"
    return FramePair(
        Site.of(robot, entry.frame, entry.at),
        Site.of(robot, entry.other, entry.other_at or (0.0, 0.0, 0.0)),
        entry.other_at is None,
        "first" if local else "world",
        np.eye(3),
        tuple(DIRECTIONS.index(label) for label in labels),
        tuple(labels),
    )


def _contact(robot: Robot, entry: Contact) -> FramePair:
    plane = Site.of(robot, entry.against, entry.origin)
    normal = np.array(entry.normal)
    # Axes that turn with a plane that moves, so that their rates are smooth.
    carrier: Literal["world", "other"] = "other" if plane.moves else "world"
    axes = contact_axes(normal if plane.moves else plane.frame.rotation.dot(normal))
    site = Site.of(robot, entry.frame, entry.at)
    return FramePair(site, plane, True, carrier, axes, (0, 1, 2), ("t1", "t2", "n"))


def axes_of_line(between: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """(3, 3) the axes of a line (3,) that joins two points, the last one along it.

    Raises:
        InputError: the points coincide.
    """
    length = float(np.sqrt(between.dot(between)))
    if not length > NO_LENGTH:
        raise InputError(
            "the two points of a DistanceAnchor or a Rope coincide: no line joins them; move one "
            "of them, or use a PointAnchor"
        )
    return contact_axes(axes[2, 2] * between / length)


def _distance(robot: Robot, entry: DistanceAnchor | Rope) -> FramePair:
    ends = Site.of(robot, entry.frame, entry.at), Site.of(robot, entry.other, entry.other_at)
    if isinstance(entry, DistanceAnchor):
        return FramePair(*ends, False, "line", np.eye(3), (2,), ("distance",))
    # A rope pulls its first end towards the other.
    back = np.diag([1.0, 1.0, -1.0])
    return FramePair(*ends, False, "line", back, (0, 1, 2), ("t1", "t2", "n"))


def _whole_joint(robot: Robot, entry: JointLock | JointImpulse | Driven) -> JointRows:
    joint_id = robot.joint_id(entry.joint)
    count = robot.model.nvs[joint_id]
    labels = ("lock",) if count == 1 else tuple(f"lock{i}" for i in range(count))
    return JointRows(tuple(((joint_id, i, 1.0),) for i in range(count)), labels, True)


def _coupling(robot: Robot, entry: JointCoupling) -> JointRows:
    terms = tuple((robot.joint_id(name), 0, factor) for name, factor in entry.terms)
    return JointRows((terms,), ("coupling",))


def _stop(robot: Robot, entry: JointStop) -> JointRows:
    return JointRows((((robot.joint_id(entry.joint), 0, 1.0),),), ("n",), True)


_SAYS: dict[type, Callable[[Robot, Any], FramePair | JointRows | FunctionRows]] = {
    AppliedImpulse: _blow,
    JointImpulse: _whole_joint,
    PointAnchor: _anchor,
    FrameAnchor: _anchor,
    DistanceAnchor: _distance,
    GapConstraint: FunctionRows,
    GapContact: FunctionRows,
    Rope: _distance,
    JointLock: _whole_joint,
    Driven: _whole_joint,
    JointCoupling: _coupling,
    Contact: _contact,
    JointStop: _stop,
}


def vectors_of_rows(entries: Iterable[FramePair | JointRows | FunctionRows]) -> tuple[int, ...]:
    """(m,) a number for each row: the same for the axes of one linear or angular velocity."""
    numbers: list[int] = []
    for said in entries:
        first = numbers[-1] + 1 if numbers else 0
        if isinstance(said, FramePair):
            numbers.extend(first + (row > 2) for row in said.select)
        else:
            numbers.extend(range(first, first + len(said.labels)))
    return tuple(numbers)
