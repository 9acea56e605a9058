"""Bilateral constraints during the motion: rows, their rates, and how far they have drifted.

What holds, and how it is kept from drifting:

- rows keep the velocity that the scene prescribes (zero, a number, or what it is at the
  start for "kept"), so relative positions keep their value at the start, or move evenly;
- that is enforced on accelerations, on velocities after every step, and on positions
  wherever the rows determine one: anchors of three directions or more, hinges, sliders
  with their rotation held, locks, and couplings of joints that are no continuous ones;
- an anchor whose points are less than ``CLOSED`` apart at the start is closed for good;
  others keep their distance, as its rows ask for.

Partial rotations in axes that turn with neither body determine no position: of those,
only velocities are kept.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio as pin

from ..impact.reach import ReachedModel
from ..impact.rows import ConstraintRows
from ..robot import Robot
from ..scene import FrameAnchor, JointCoupling, JointLock, PointAnchor, Scene
from ..scene.constraints import DIRECTIONS
from .points import Pair

__all__ = ["CLOSED", "HeldRows"]

# Loops closed by hand are off by about as much [m].
CLOSED = 1e-6

# What a constraint's coordinates are off by, (k,), at (q, t), and which rows they belong to.
Drift = tuple[slice | list[int], Callable[[np.ndarray, float], np.ndarray]]


class HeldRows:
    """The bilateral rows of a scene on its whole model.

    Attributes:
        names: of the rows.
        velocity: (m,) what the rows' velocities are kept at.
        kept: (m,) True where that is what it is at the start; None where none is.
    """

    def __init__(self, scene: Scene, reached: ReachedModel) -> None:
        self._model = reached.model
        self._constraints = scene.constraints
        self._rows = ConstraintRows.of(scene, reached)
        self.names = self._rows.names
        self.velocity = self._rows.velocity.copy()
        self.kept = self._rows.kept
        self._pairs = [
            _pair(scene.robot, reached, entry)
            if isinstance(entry, PointAnchor | FrameAnchor)
            else None
            for entry in scene.constraints
        ]
        self._drifts: list[Drift] = []
        # Drift is looked at with a workspace of its own.
        self._data: pin.Data | None = None

    def start(self, q: np.ndarray, v: np.ndarray) -> None:
        """Take what "kept" rows keep, and where all rows stand, from the start of the motion."""
        self._data = self._model.createData()
        before = self.matrix(self._data, q).dot(v)
        self.velocity = self._rows.target(before).copy()
        pin.forwardKinematics(self._model, self._data, q)
        self._drifts = []
        for entry, where, pair in zip(
            self._constraints, self._rows.slices, self._pairs, strict=True
        ):
            speed = self.velocity[where]
            if pair is not None and isinstance(entry, PointAnchor | FrameAnchor):
                self._drifts += _anchor_drifts(self, entry, pair, where.start, speed)
            elif isinstance(entry, JointLock):
                self._drifts.append((where, self._lock_drift(entry, q, speed)))
            elif isinstance(entry, JointCoupling):
                self._drifts += self._coupling_drift(entry, q, speed[0], where)

    def matrix(self, data: pin.Data, q: np.ndarray) -> np.ndarray:
        """(m, nv) A at q."""
        return self._rows.matrix(data, q)

    def magnitude(self, data: pin.Data, q: np.ndarray) -> np.ndarray:
        """(m, nv) the size of the terms that make up A."""
        return self._rows.magnitude(data, q)

    def bias(self, data: pin.Data) -> np.ndarray:
        """(m,) Ȧ v; ``data`` with accelerations at zero joint acceleration."""
        bias = np.zeros(len(self.names))
        for entry, where, pair in zip(
            self._constraints, self._rows.slices, self._pairs, strict=True
        ):
            if pair is not None and isinstance(entry, PointAnchor | FrameAnchor):
                bias[where] = pair.bias(data)[_chosen(entry)]
        return bias

    def drift(self, q: np.ndarray, t: float) -> tuple[np.ndarray, np.ndarray]:
        """(k,) how far coordinates are off at a time, and (k,) the rows they belong to."""
        pin.forwardKinematics(self._model, self.data, q)
        values: list[np.ndarray] = []
        rows: list[np.ndarray] = []
        everywhere = np.arange(len(self.names))
        for where, drift in self._drifts:
            values.append(drift(q, t))
            rows.append(everywhere[where])
        if not values:
            return np.empty(0), np.empty(0, dtype=int)
        return np.concatenate(values), np.concatenate(rows)

    @property
    def data(self) -> pin.Data:
        """Pinocchio's data, with the placements of the last drift."""
        if self._data is None:
            self._data = self._model.createData()
        return self._data

    def _lock_drift(self, lock: JointLock, q: np.ndarray, speed: np.ndarray) -> Callable:
        model, start = self._model, q.copy()
        joint = model.joints[model.getJointId(lock.joint)]
        rows = slice(joint.idx_v, joint.idx_v + joint.nv)
        move = np.zeros(model.nv)
        move[rows] = speed

        def drift(q: np.ndarray, t: float) -> np.ndarray:
            wanted = pin.integrate(model, start, t * move)
            return pin.difference(model, wanted, q)[rows]

        return drift

    def _coupling_drift(
        self, coupling: JointCoupling, q: np.ndarray, speed: float, where: slice
    ) -> list[Drift]:
        model = self._model
        names = (coupling.joint, *coupling.other)
        joints = [model.joints[model.getJointId(name)] for name in names]
        if any(joint.nq != 1 for joint in joints):
            return []
        entries = [joint.idx_q for joint in joints]
        ratios = np.array([1.0, *(-r for r in coupling.ratio)])
        start = ratios.dot(q[entries])
        return [(where, lambda q, t: np.array([ratios.dot(q[entries]) - start - speed * t]))]


def _chosen(anchor: PointAnchor | FrameAnchor) -> slice | list[int]:
    """Which of the six rows of a pair an anchor has."""
    if isinstance(anchor, PointAnchor):
        return slice(0, 3)
    return [DIRECTIONS.index(d) for d in anchor.directions]


def _pair(robot: Robot, reached: ReachedModel, anchor: PointAnchor | FrameAnchor) -> Pair:
    axes = "first" if isinstance(anchor, FrameAnchor) and anchor.axes == "local" else "world"
    other_at = anchor.other_at
    if other_at is None and robot.model.frames[robot.frame_id(anchor.other)].parentJoint == 0:
        # The world stands still: any of its points will do.
        other_at = (0.0, 0.0, 0.0)
    return Pair(robot, reached, anchor.frame, anchor.at, anchor.other, other_at, axes)


def _anchor_drifts(
    held: HeldRows, anchor: PointAnchor | FrameAnchor, pair: Pair, first_row: int, speed: np.ndarray
) -> list[Drift]:
    """What the rows of an anchor determine of its coordinates; placements are in ``held.data``."""
    directions = DIRECTIONS[:3] if isinstance(anchor, PointAnchor) else anchor.directions
    linear = [DIRECTIONS.index(d) for d in directions if d in DIRECTIONS[:3]]
    angular = [DIRECTIONS.index(d) - 3 for d in directions if d in DIRECTIONS[3:]]
    first, other = (placement.copy() for placement in pair.placements(held.data))
    drifts: list[Drift] = []
    rows = [first_row + i for i in range(len(directions))]
    if linear:
        found = _linear_drift(
            held, anchor, pair, linear, len(angular) == 3, first, other, speed[: len(linear)]
        )
        if found is not None:
            drifts.append((rows[: len(linear)], found))
    if angular and not speed[len(linear) :].any():
        turned = _angular_drift(held, pair, angular, first, other)
        if turned is not None:
            drifts.append((rows[len(linear) :], turned))
    return drifts


def _linear_drift(
    held: HeldRows,
    anchor: PointAnchor | FrameAnchor,
    pair: Pair,
    linear: list[int],
    turns_with: bool,
    first: pin.SE3,
    other: pin.SE3,
    speed: np.ndarray,
) -> Callable | None:
    moves = bool(speed.any())
    whole = len(linear) == 3 and not moves
    if anchor.other_at is None and (whole or turns_with):
        # The point of the other body stays the one that was met at the start.
        if moves:
            return None
        met = other.actInv(first.translation)

        def by_other(q: np.ndarray, t: float) -> np.ndarray:
            one, two = pair.placements(held.data)
            gap = one.translation - two.act(met)
            return pair.rotation(one, two).T.dot(gap)[linear]

        return by_other
    if not (pair.in_world_axes or whole):
        return None
    if anchor.other_at is None and other_moves(pair):
        return None
    start = first.translation - other.translation
    if anchor.other_at is not None and np.abs(start).max() < CLOSED:
        start = np.zeros(3)
    velocity = np.zeros(3)
    velocity[linear] = speed

    def between(q: np.ndarray, t: float) -> np.ndarray:
        one, two = pair.placements(held.data)
        gap = one.translation - two.translation - start - t * velocity
        return pair.rotation(one, two).T.dot(gap)[linear]

    return between


def other_moves(pair: Pair) -> bool:
    """Whether the second of two points is carried by a joint."""
    return pair.other.joint_id > 0


def _angular_drift(
    held: HeldRows, pair: Pair, angular: list[int], first: pin.SE3, other: pin.SE3
) -> Callable | None:
    """The turn of ``first`` against ``other`` since the start, in the axes of the rows."""
    relative = other.rotation.T.dot(first.rotation)
    if len(angular) == 3:

        def all_three(q: np.ndarray, t: float) -> np.ndarray:
            one, two = pair.placements(held.data)
            turn = pin.log3(one.rotation.dot(two.rotation.dot(relative).T))
            return pair.rotation(one, two).T.dot(turn)

        return all_three
    local = not pair.in_world_axes
    if len(angular) != 2 or not (local or not other_moves(pair)):
        return None
    (free,) = {0, 1, 2} - set(angular)

    def hinge(q: np.ndarray, t: float) -> np.ndarray:
        one, two = pair.placements(held.data)
        if local:
            # The free axis of ``other``, seen from ``first``: where it was at the start.
            tilt = -one.rotation.T.dot(two.rotation.dot(relative))[:, free]
        else:
            # The body's direction that lay along the free axis at the start.
            tilt = one.rotation.dot(first.rotation.T)[:, free]
        return _tilt(tilt, free)[angular]

    return hinge


def _tilt(axis: np.ndarray, free: int) -> np.ndarray:
    """(3,) e × axis: the small turn that has brought the unit vector e there."""
    unit = np.zeros(3)
    unit[free] = 1.0
    return np.cross(unit, axis)
