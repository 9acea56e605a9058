"""The motion of a point of one body against another: rows, and their rates of change.

w = v_first − v_other − ω_other × d with d from the point of ``other`` to that of
``first`` (the last term only where the other's point is the one that coincides with the
first's), and ω = ω_first − ω_other. In axes R that turn with Ω the rows are (Rᵀw, Rᵀω),
their rates Rᵀ(ẇ − Ω × w) and Rᵀ(ω̇ − Ω × ω).
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from ..geometry.axes import cross
from ..impact.points import PointOnFrame
from ..impact.reach import ReachedModel
from ..robot import Robot

__all__ = ["Pair"]

_ALIGNED = pin.LOCAL_WORLD_ALIGNED
_ZERO = np.zeros(3)


class Pair:
    """Two points, one on each of two frames, either of which may be fixed in the world.

    Args:
        robot: the robot.
        reached: its whole model, which is given a frame for each point.
        frame, at: the first point.
        other, other_at: the other one; None for the one that coincides with the first.
        axes: "world", or "first" or "other": the axes of that frame, times ``turn``.
        turn: (3, 3) a rotation; its columns are the axes in those of the frame.
    """

    def __init__(
        self,
        robot: Robot,
        reached: ReachedModel,
        frame: str,
        at: object,
        other: str,
        other_at: object,
        axes: str = "world",
        turn: np.ndarray | None = None,
    ) -> None:
        self._model = reached.model
        self._coincident = other_at is None
        self.first = PointOnFrame(robot, reached, frame, at)
        self.other = PointOnFrame(
            robot, reached, other, (0, 0, 0) if other_at is None else other_at
        )
        self._axes = axes
        self._turn = np.eye(3) if turn is None else turn
        self.in_world_axes = axes == "world" and turn is None

    def placements(self, data: pin.Data) -> tuple[pin.SE3, pin.SE3]:
        """Of both points, with the axes of their frames; ``data`` with placements of joints."""
        first = pin.updateFramePlacement(self._model, data, self.first.frame_id)
        other = pin.updateFramePlacement(self._model, data, self.other.frame_id)
        return first, other

    def rotation(self, first: pin.SE3, other: pin.SE3) -> np.ndarray:
        """(3, 3) the axes in the world."""
        if self._axes == "world":
            return self._turn
        return (first if self._axes == "first" else other).rotation.dot(self._turn)

    def rows(self, data: pin.Data) -> np.ndarray:
        """(6, nv) linear before angular; ``data`` with joint Jacobians."""
        model = self._model
        one = pin.getFrameJacobian(model, data, self.first.frame_id, _ALIGNED).reshape(6, -1)
        if self.other.joint_id == 0 and self.in_world_axes:
            return one
        two = pin.getFrameJacobian(model, data, self.other.frame_id, _ALIGNED).reshape(6, -1)
        rows = one - two
        if self._axes != "world" or self._coincident:
            first, other = self.placements(data)
            if self._coincident:
                arm = first.translation - other.translation
                rows[:3] += pin.skew(arm).dot(two[3:])
        if not self.in_world_axes:
            turn = self._turn.T
            if self._axes != "world":
                turn = self.rotation(first, other).T
            rows[:3], rows[3:] = turn.dot(rows[:3]), turn.dot(rows[3:])
        return rows

    def bias(self, data: pin.Data) -> np.ndarray:
        """(6,) the rates of the rows' velocities where no joint accelerates.

        ``data`` with placements, velocities, and accelerations at zero joint acceleration.
        """
        model = self._model
        a1 = pin.getFrameClassicalAcceleration(model, data, self.first.frame_id, _ALIGNED)
        if self.other.joint_id == 0 and self.in_world_axes:
            return a1.vector
        a2 = pin.getFrameClassicalAcceleration(model, data, self.other.frame_id, _ALIGNED)
        v1 = pin.getFrameVelocity(model, data, self.first.frame_id, _ALIGNED)
        v2 = pin.getFrameVelocity(model, data, self.other.frame_id, _ALIGNED)
        first, other = self.placements(data)
        velocity, rate = v1.linear - v2.linear, a1.linear - a2.linear
        if self._coincident:
            arm = first.translation - other.translation
            rate = rate - cross(a2.angular, arm) - cross(v2.angular, velocity)
            velocity = velocity - cross(v2.angular, arm)
        spin, spin_rate = v1.angular - v2.angular, a1.angular - a2.angular
        if self._axes != "world":
            turning = (v1 if self._axes == "first" else v2).angular
            rate = rate - cross(turning, velocity)
            spin_rate = spin_rate - cross(turning, spin)
        turn = self.rotation(first, other).T
        return np.concatenate([turn.dot(rate), turn.dot(spin_rate)])
