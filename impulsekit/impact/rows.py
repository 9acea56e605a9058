"""The rows of bilateral constraints: A v⁺ = b, one block of rows per constraint."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import pinocchio as pin

from ..robot import Robot
from ..scene import Collision, Contact, FrameAnchor, JointCoupling, JointLock, PointAnchor, Scene
from ..scene.constraints import DIRECTIONS, KEPT
from .origin import Places
from .points import PointOnFrame
from .reach import ReachedModel, branch_of

__all__ = ["ConstraintRows", "needs_places"]


class _Block(Protocol):
    """The rows of one constraint.

    Attributes:
        faintest: (k,) rows without an entry above this may be zeros but for rounding; 0
            where they cannot be.
    """

    faintest: np.ndarray

    def write(self, rows: np.ndarray, model: pin.Model, data: pin.Data, q: np.ndarray) -> None:
        """Write the rows (k, nv)."""

    def magnitude(self, model: pin.Model, data: pin.Data, q: np.ndarray) -> np.ndarray:
        """(k, nv) what the rows are differences of; tells a zero from rounding."""


# Rows this much smaller than the terms they are made of are zeros: rods in line, a loop
# at its dead point. Loops closed by hand are off by about as much.
NULL_ROW = 1e-7
# What rounding leaves of them.
EXACT_NULL_ROW = 1e-14


class _AnchorRows:
    """Relative velocity of two points, or of a point against the world."""

    def __init__(self, robot: Robot, reached: ReachedModel, anchor: PointAnchor | FrameAnchor):
        moving = robot.model.frames[robot.frame_id(anchor.frame)].parentJoint > 0
        other_moves = robot.model.frames[robot.frame_id(anchor.other)].parentJoint > 0
        self._coincident = anchor.other_at is None and other_moves
        self._point = PointOnFrame(robot, reached, anchor.frame, anchor.at) if moving else None
        self._other = (
            PointOnFrame(robot, reached, anchor.other, anchor.other_at or (0.0, 0.0, 0.0))
            if other_moves
            else None
        )
        if isinstance(anchor, FrameAnchor):
            self._rows = [DIRECTIONS.index(d) for d in anchor.directions]
            self._local = anchor.axes == "local"
        else:
            self._rows, self._local = [0, 1, 2], False
        fixed = robot.model.frames[robot.frame_id(anchor.frame)].placement
        self._fixed_point = fixed.act(np.array(anchor.at, dtype=float))
        self._fixed_axes = fixed.rotation
        # All six rows, or the first three, are a slice: no copy.
        count = len(self._rows)
        self._select = slice(0, count) if self._rows == list(range(count)) else self._rows
        self._reach = sum(_reach(reached.model, end) for end in (self._point, self._other))
        ends = [end for end in (self._point, self._other) if end is not None]
        faintest = np.where(np.array(self._rows) < 3, min(self._reach or 1.0, 1.0), 1.0)
        # A free-flyer's own speeds move every point in every direction.
        free = len(ends) == 1 and _root_kind(reached.model, ends[0]) == "JointModelFreeFlyer"
        self.faintest = np.zeros(count) if free else 10.0 * NULL_ROW * faintest
        # Against the world in its own axes, Pinocchio's local Jacobian is the answer.
        self._reference = pin.LOCAL_WORLD_ALIGNED
        if self._local and not other_moves:
            self._reference, self._local = pin.LOCAL, False

    def write(self, rows: np.ndarray, model: pin.Model, data: pin.Data, q: np.ndarray) -> None:
        if self._other is None and self._point is not None and not self._local:
            rows[:] = self._point.jacobian(model, data, q, self._reference)[self._select]
            return
        first, second = self._both(model, data, q)
        rows[:] = (first - second)[self._select]

    def magnitude(self, model: pin.Model, data: pin.Data, q: np.ndarray) -> np.ndarray:
        first, second = self._both(model, data, q)
        gross = np.abs(first) + np.abs(second)
        # Axes mix within a triple, so its rows share their size.
        gross[:3] = np.sqrt((gross[:3] ** 2).sum(axis=0))
        gross[3:] = np.sqrt((gross[3:] ** 2).sum(axis=0))
        # What turns the point moves it by differences of places.
        gross[:3] += self._reach * gross[3:]
        return gross[self._select]

    def _both(
        self, model: pin.Model, data: pin.Data, q: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """(6, nv) of both ends in the axes of the rows."""
        zero = np.zeros((6, model.nv))
        first = second = zero
        if self._point is not None:
            first = self._point.jacobian(model, data, q, self._reference)
        if self._other is not None:
            second = self._other.jacobian(model, data, q, self._reference)
        if self._coincident or (self._local and self._point is not None):
            pin.forwardKinematics(model, data, q)
        if self._coincident:
            second = second.copy()
            second[:3] -= pin.skew(self._offset(data)) @ second[3:]
        if self._local:
            axes = self._axes(data)
            turn = np.kron(np.eye(2), axes.T)
            first, second = turn @ first, turn @ second
        return first, second

    def _offset(self, data: pin.Data) -> np.ndarray:
        """(3,) from the origin of ``other`` to the point of ``frame``, world axes."""
        ends = [
            self._fixed_point
            if end is None
            else data.oMi[end.joint_id].act(end.placement.translation)
            for end in (self._point, self._other)
        ]
        return ends[0] - ends[1]

    def _axes(self, data: pin.Data) -> np.ndarray:
        """(3, 3) the axes of ``frame`` in the world."""
        if self._point is None:
            return self._fixed_axes
        return data.oMi[self._point.joint_id].rotation @ self._point.placement.rotation


class _JointRows:
    """Rows that do not depend on the configuration: locks and couplings."""

    def __init__(self, rows: np.ndarray) -> None:
        self._rows = rows
        self.faintest = np.zeros(len(rows))

    def write(self, rows: np.ndarray, model: pin.Model, data: pin.Data, q: np.ndarray) -> None:
        rows[:] = self._rows

    def magnitude(self, model: pin.Model, data: pin.Data, q: np.ndarray) -> np.ndarray:
        return np.abs(self._rows)


@dataclass(frozen=True, eq=False)
class ConstraintRows:
    """All bilateral rows of a scene on a model.

    Attributes:
        slices: where each constraint's rows stand.
        names: of each row, such as "constraints[0].x".
        velocity: (m,) the prescribed velocity of each row after the impact.
        kept: (m,) True where the row keeps its velocity instead; None where none does.
        faintest: (m,) of its blocks; None where no row can vanish.
    """

    model: pin.Model
    blocks: tuple[_Block, ...]
    slices: tuple[slice, ...]
    names: tuple[str, ...]
    velocity: np.ndarray
    kept: np.ndarray | None
    faintest: tuple[float, ...] | None

    @classmethod
    def of(cls, scene: Scene, reached: ReachedModel) -> ConstraintRows:
        """The rows of a scene; frames for their points are added to the reached model."""
        blocks: list[_Block] = []
        slices: list[slice] = []
        names: list[str] = []
        velocity: list[float] = []
        kept: list[bool] = []
        for name, entry in zip(scene.entry_names("constraints"), scene.constraints, strict=True):
            block, labels = _block(scene.robot, reached, entry)
            count = len(labels)
            blocks.append(block)
            slices.append(slice(len(names), len(names) + count))
            names.extend(f"{name}.{label}" for label in labels)
            keeps = entry.velocity == KEPT
            after = (
                entry.velocity if isinstance(entry.velocity, tuple) else (entry.velocity,) * count
            )
            velocity.extend((0.0,) * count if keeps else after)
            kept.extend([keeps] * count)
        faintest = np.concatenate([np.zeros(0), *(block.faintest for block in blocks)])
        return cls(
            reached.model,
            tuple(blocks),
            tuple(slices),
            tuple(names),
            np.array(velocity),
            np.array(kept) if any(kept) else None,
            tuple(faintest.tolist()) if faintest.any() else None,
        )

    @property
    def count(self) -> int:
        """How many rows there are."""
        return len(self.names)

    def matrix(self, data: pin.Data, q: np.ndarray) -> np.ndarray:
        """(m, nv) A at q; rows that are zero but for rounding are zero."""
        return self.matrix_and_doubt(data, q)[0]

    def matrix_and_doubt(self, data: pin.Data, q: np.ndarray) -> tuple[np.ndarray, bool]:
        """A at q, and whether a row was taken for zero that is more than rounding."""
        doubt = False
        rows = np.empty((len(self.names), self.model.nv))
        for block, where in zip(self.blocks, self.slices, strict=True):
            block.write(rows[where], self.model, data, q)
        if self.faintest is not None:
            largest = np.maximum.reduce(np.abs(rows), axis=1)
            # By far most rows are none of these: told apart without arrays.
            if any(0.0 < a <= b for a, b in zip(largest.tolist(), self.faintest, strict=True)):
                faint = (largest <= np.array(self.faintest)) & (largest > 0.0)
                gross = self.magnitude(data, q)
                faint &= (np.abs(rows) <= NULL_ROW * gross).all(axis=1)
                doubt = bool((np.abs(rows[faint]) > EXACT_NULL_ROW * gross[faint]).any())
                rows[faint] = 0.0
        return rows, doubt

    def magnitude(self, data: pin.Data, q: np.ndarray) -> np.ndarray:
        """(m, nv) the size of the terms that make up A."""
        return np.vstack([block.magnitude(self.model, data, q) for block in self.blocks])

    def target(self, velocity_before: np.ndarray) -> np.ndarray:
        """(m,) b, given the rows' velocities A v⁻ before the impact."""
        if self.kept is None:
            return self.velocity
        return np.where(self.kept, velocity_before, self.velocity)


def _reach(model: pin.Model, end: PointOnFrame | None) -> float:
    """The way from the root of its tree to a point at most [m], displacements left out."""
    if end is None:
        return 0.0
    reach, joint_id = float(np.linalg.norm(end.placement.translation)), end.joint_id
    while model.parents[joint_id] > 0:
        reach += float(np.linalg.norm(model.jointPlacements[joint_id].translation))
        joint_id = model.parents[joint_id]
    return reach


def _root_kind(model: pin.Model, end: PointOnFrame) -> str:
    return model.joints[branch_of(model, end.joint_id)].shortname()


def needs_places(robot: Robot, scene: Scene) -> Places:
    """Which places in the world the constraints and contacts of a scene depend on."""
    model = robot.model
    needed = Places.NONE
    pairs = [
        (entry.frame, entry.other)
        for entry in scene.constraints
        if isinstance(entry, PointAnchor | FrameAnchor) and entry.other_at is None
    ]
    for contact in scene.contacts:
        if isinstance(contact, Collision):
            return Places.IN_WORLD
        if isinstance(contact, Contact):
            pairs.append((contact.frame, contact.against))
    for pair in pairs:
        first, other = (
            branch_of(model, model.frames[robot.frame_id(name)].parentJoint) for name in pair
        )
        # A point of the first end is carried over to the other, if that moves.
        if other == 0 or first == other:
            continue
        if first == 0:
            return Places.IN_WORLD
        needed = Places.TO_EACH_OTHER
    return needed


def _block(robot: Robot, reached: ReachedModel, entry: object) -> tuple[_Block, tuple[str, ...]]:
    if isinstance(entry, PointAnchor):
        return _AnchorRows(robot, reached, entry), DIRECTIONS[:3]
    if isinstance(entry, FrameAnchor):
        return _AnchorRows(robot, reached, entry), entry.directions
    model = reached.model
    if isinstance(entry, JointLock):
        joint = model.joints[reached.joint_id(robot.joint_id(entry.joint))]
        rows = np.eye(model.nv)[joint.idx_v : joint.idx_v + joint.nv]
        labels = ("lock",) if joint.nv == 1 else tuple(f"lock{i}" for i in range(joint.nv))
        return _JointRows(rows), labels
    if isinstance(entry, JointCoupling):
        row = np.zeros((1, model.nv))
        for name, ratio in zip(
            (entry.joint, *entry.other), (1.0, *(-r for r in entry.ratio)), strict=True
        ):
            row[0, model.joints[reached.joint_id(robot.joint_id(name))].idx_v] = ratio
        return _JointRows(row), ("coupling",)
    raise TypeError(type(entry).__name__)
