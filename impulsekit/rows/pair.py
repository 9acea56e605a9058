"""The rows of two frames at a configuration, and their rates of change.

Rows are (Rᵀw, Rᵀω), see ``entries``. In axes that turn with Ω their rates are Rᵀ(ẇ − Ω × w) and
Rᵀ(ω̇ − Ω × ω).
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from pinocchio import getFrameJacobian

from ..geometry.axes import cross
from .entries import FramePair, axes_of_line
from .points import PointOnFrame
from .reach import ReachedModel

__all__ = ["Pair", "rows_at", "turning_rows"]

_ALIGNED = pin.LOCAL_WORLD_ALIGNED


class Pair:
    """A pair of frames on a reached model, which is given a frame for each point.

    Attributes:
        said: the pair.
        first, other: the two points.
    """

    def __init__(self, reached: ReachedModel, said: FramePair) -> None:
        self.said, self._model = said, reached.model
        self.first, self.other = (PointOnFrame(reached, site) for site in (said.first, said.other))
        rows = list(said.select)
        # All six rows, or the first three, are a slice: no copy.
        self._select = slice(0, len(rows)) if rows == list(range(len(rows))) else rows
        self._carries = said.coincides and said.other.moves
        self._turns = said.carrier != "world"
        self._on_line = said.carrier == "line"
        self._turn = None if said.is_level else said.axes.T.copy()
        self._reference = _ALIGNED
        # Against the world, in its axes or in the frame's own, Pinocchio's Jacobian is the answer.
        self.is_alone = (
            said.first.moves
            and not said.other.moves
            and said.carrier in ("world", "first")
            and (self._turn is None or not said.angular)
        )
        if self.is_alone and self._turns:
            self._reference = pin.LOCAL
        self._turn_selected = None if self._turn is None or said.angular else self._turn[rows]

    def placements(self, data: pin.Data) -> tuple[pin.SE3, pin.SE3]:
        """Of both points, with the axes of their frames; ``data`` with placements of joints."""
        first = pin.updateFramePlacement(self._model, data, self.first.frame_id)
        other = pin.updateFramePlacement(self._model, data, self.other.frame_id)
        return first, other

    def axes(self, data: pin.Data) -> np.ndarray:
        """(3, 3) R in the world; ``data`` with placements of joints."""
        if not self._turns:
            return self.said.axes
        first, other = self.placements(data)
        return self.axes_of(first, other)

    def axes_of(self, first: pin.SE3, other: pin.SE3) -> np.ndarray:
        """(3, 3) R in the world, out of the placements of both points."""
        if not self._turns:
            return self.said.axes
        if self._on_line:
            return axes_of_line(first.translation - other.translation, self.said.axes)
        carrier = first if self.said.carrier == "first" else other
        return carrier.rotation.dot(self.said.axes)

    def jacobian(self, data: pin.Data, q: np.ndarray) -> np.ndarray:
        """(k, nv) the rows at q; ``data`` may hold anything."""
        if self.is_alone:
            rows = self.first.jacobian(self._model, data, q, self._reference)
            if self._turn_selected is None:
                return rows[self._select]
            return self._turn_selected.dot(rows[:3])
        first, other = self.ends(data, q)
        return (first - other)[self._select]

    def ends(self, data: pin.Data, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(6, nv) of both ends, whose difference has the rows, at q."""
        model = self._model
        first, other = (
            end.jacobian(model, data, q, _ALIGNED) if end.moves else np.zeros((6, model.nv))
            for end in (self.first, self.other)
        )
        if self._turns or self._carries:
            pin.forwardKinematics(model, data, q)
        return self._carried_and_turned(data, first, other)

    def rows(self, data: pin.Data) -> np.ndarray:
        """(k, nv) the rows; ``data`` with joint Jacobians."""
        model = self._model
        # With one degree of freedom Pinocchio gives (6,) for (6, 1).
        first, other = (
            getFrameJacobian(model, data, end.frame_id, _ALIGNED).reshape(6, -1)
            if end.moves
            else None
            for end in (self.first, self.other)
        )
        zero = np.zeros((6, model.nv))
        first, other = self._carried_and_turned(
            data, zero if first is None else first, zero if other is None else other
        )
        return (first - other)[self._select]

    def bias(self, data: pin.Data) -> np.ndarray:
        """(k,) the rates of the rows' velocities where no joint accelerates.

        ``data`` with placements, velocities, and accelerations at zero joint acceleration.
        """
        model, said = self._model, self.said
        a1 = pin.getFrameClassicalAcceleration(model, data, self.first.frame_id, _ALIGNED)
        if not (said.other.moves or self._turns) and self._turn is None:
            return a1.vector[self._select]
        a2 = pin.getFrameClassicalAcceleration(model, data, self.other.frame_id, _ALIGNED)
        v1 = pin.getFrameVelocity(model, data, self.first.frame_id, _ALIGNED)
        v2 = pin.getFrameVelocity(model, data, self.other.frame_id, _ALIGNED)
        first, other = self.placements(data)
        velocity, rate = v1.linear - v2.linear, a1.linear - a2.linear
        if self._carries:
            arm = first.translation - other.translation
            rate = rate - cross(a2.angular, arm) - cross(v2.angular, velocity)
            velocity = velocity - cross(v2.angular, arm)
        spin, spin_rate = v1.angular - v2.angular, a1.angular - a2.angular
        if self._on_line:
            # The line turns with what moves one end across it.
            between = first.translation - other.translation
            turning = cross(between, velocity) / between.dot(between)
            rate = rate - cross(turning, velocity)
        elif self._turns:
            turning = (v1 if said.carrier == "first" else v2).angular
            rate = rate - cross(turning, velocity)
            spin_rate = spin_rate - cross(turning, spin)
        turn = self.axes_of(first, other).T
        return np.concatenate([turn.dot(rate), turn.dot(spin_rate)])[self._select]

    def _carried_and_turned(
        self, data: pin.Data, first: np.ndarray, other: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Both ends at the point of the first where they coincide, in the axes of the rows."""
        if not (self._turns or self._carries):
            if self._turn is None:
                return first, other
            return _turned(self._turn, first), _turned(self._turn, other)
        one, two = self.placements(data)
        if self._carries:
            other = other.copy()
            other[:3] -= pin.skew(one.translation - two.translation).dot(other[3:])
        if self._turns or self._turn is not None:
            turn = self.axes_of(one, two).T
            first, other = _turned(turn, first), _turned(turn, other)
        return first, other


def rows_at(
    model: pin.Model,
    data: pin.Data,
    joint_ids: tuple[int, int],
    point: np.ndarray,
    axes: np.ndarray,
) -> np.ndarray:
    """(3, nv) Rᵀ (J_first − J_other) at a point of the world; ``data`` with joint Jacobians."""
    difference = np.zeros((3, model.nv))
    for sign, joint_id in zip((1.0, -1.0), joint_ids, strict=True):
        if joint_id > 0:
            at = pin.SE3(np.eye(3), data.oMi[joint_id].actInv(point))
            # With one degree of freedom Pinocchio gives (6,) for (6, 1).
            jacobian = getFrameJacobian(model, data, joint_id, at, _ALIGNED).reshape(6, -1)
            difference += sign * jacobian[:3]
    return axes.T.dot(difference)


def turning_rows(
    model: pin.Model, data: pin.Data, joint_ids: tuple[int, int], axes: np.ndarray
) -> np.ndarray:
    """(3, nv) Rᵀ (ω_first − ω_other) of two bodies; ``data`` with joint Jacobians."""
    difference = np.zeros((3, model.nv))
    for sign, joint_id in zip((1.0, -1.0), joint_ids, strict=True):
        if joint_id > 0:
            jacobian = pin.getJointJacobian(model, data, joint_id, _ALIGNED).reshape(6, -1)
            difference += sign * jacobian[3:]
    return axes.T.dot(difference)


def _turned(turn: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """(6, nv) both triples of rows, turned."""
    return np.matmul(turn, rows.reshape(2, 3, -1)).reshape(6, -1)
