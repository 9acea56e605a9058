"""Springs of a scene on the model: in joints, and between two points.

A one-sided spring has kinks: where its strain is zero, and where its damper would pull what the
spring pushes. Steps of a motion end there (``kinks``), and ``acts`` is set from one to the next.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from ..robot import Robot
from ..scene import JointSpring, Spring
from .compiled_loads import BEYOND, NO_LENGTH, push_between, push_in_joint, turned_from

__all__ = ["PointOfFrame", "Push", "SpringBetweenPoints", "SpringInJoint"]


class Push(NamedTuple):
    """State of a one-sided spring: it acts while zone and force are positive.

    Attributes:
        zone: strain towards its side [m, rad]; of a continuous joint the sine of it, and of a
            spring between points (l² − l₀²) / 2 l₀, which is smooth where they meet.
        rate: d zone/dt [m/s, rad/s].
        force: of spring and damper towards its side [N, N m].
    """

    zone: float
    rate: float
    force: float


class SpringInJoint:
    """τ = −k (q − rest) − c v.

    Attributes:
        row: of its joint in v.
        acts: whether a one-sided spring acts; None: decided by the state at each evaluation.
        is_one_sided: whether it acts on one side only. is_damped: whether it has a damper.
        beyond: force below which it counts as zero [N, N m].
    """

    def __init__(self, robot: Robot, force: JointSpring) -> None:
        joint = robot.model.joints[robot.joint_id(force.joint)]
        self.row, self._entry = joint.idx_v, joint.idx_q
        self._continuous = joint.nq == 2
        self._stiffness, self._damping, self._rest = force.stiffness, force.damping, force.rest
        # Which side of the rest it acts on; 0 for both.
        self._side = {"both": 0.0, "above": 1.0, "below": -1.0}[force.acts]
        self.is_one_sided, self.is_damped = self._side != 0.0, force.damping > 0.0
        self.beyond = BEYOND * (force.stiffness + force.damping)
        self.acts: bool | None = None

    def _strain(self, q: np.ndarray, side: float = 0.0) -> float:
        """q − rest [rad, m]; of a continuous joint within half a turn of the middle of a side."""
        if not self._continuous:
            return q[self._entry] - self._rest
        return turned_from(q[self._entry], q[self._entry + 1], self._rest, side)

    def torque(self, q: np.ndarray, v: np.ndarray) -> float:
        """Generalized force of the spring at a state [N m, N]."""
        side, acts = self._side, self.acts
        if acts is False:
            return 0.0
        strain = self._strain(q, 0.0 if acts is None else side)
        torque = -self._stiffness * strain - self._damping * v[self.row]
        if acts is None and side and not (side * strain > 0.0 and side * torque < 0.0):
            return 0.0
        return torque

    def push(self, q: np.ndarray, v: np.ndarray, data: pin.Data) -> Push:
        """State of a one-sided spring."""
        strain, speed = float(self._strain(q, self._side)), float(v[self.row])
        numbers = self._side, self._stiffness, self._damping, self._continuous
        return Push(*push_in_joint(strain, speed, *numbers))

    def energy(self, q: np.ndarray) -> float:
        """Energy stored in the spring [J]."""
        strain = float(self._strain(q))
        return 0.5 * self._stiffness * strain**2 if self._side * strain >= 0.0 else 0.0


class PointOfFrame:
    """A point of a frame, carried by a joint."""

    def __init__(self, robot: Robot, frame: str, at: Any) -> None:
        item = robot.model.frames[robot.frame_id(frame)]
        self.joint_id = item.parentJoint
        self.placement = item.placement * pin.SE3(np.eye(3), np.array(at, dtype=float))
        self._at = self.placement.translation.copy()

    def position(self, data: pin.Data) -> np.ndarray:
        """(3,) in the world."""
        return data.oMi[self.joint_id].act(self._at)

    def velocity(self, data: pin.Data) -> np.ndarray:
        """(3,) in the world."""
        motion = data.v[self.joint_id]
        local = motion.linear + np.cross(motion.angular, self._at)
        return data.oMi[self.joint_id].rotation.dot(local)

    def add(self, wrenches: pin.StdVec_Force, data: pin.Data, force_world: np.ndarray) -> None:
        """Add a force through the point, in world axes; joint 0 carries that on the world."""
        local = force_world.dot(data.oMi[self.joint_id].rotation)
        wrenches[self.joint_id] += pin.Force(local, np.cross(self._at, local))


class SpringBetweenPoints:
    """A spring and damper along the line between two points.

    Attributes:
        joint_ids: of its ends.
        acts, is_one_sided, is_damped, beyond: as of ``SpringInJoint``.
    """

    def __init__(self, robot: Robot, force: Spring) -> None:
        self._force = force
        # 1 for what only pulls, −1 for what only pushes; 0 for both.
        self._way = {"both": 0.0, "pull": 1.0, "push": -1.0}[force.acts]
        self._ends = (
            PointOfFrame(robot, force.frame, force.at),
            PointOfFrame(robot, force.other, force.other_at),
        )
        self.joint_ids = tuple(end.joint_id for end in self._ends)
        self.is_one_sided, self.is_damped = self._way != 0.0, force.damping > 0.0
        self.beyond = BEYOND * (force.stiffness + force.damping)
        self.acts: bool | None = None

    def _line(self, data: pin.Data) -> tuple[float, np.ndarray]:
        """Its length, and the direction from the other end to the first."""
        first, other = self._ends
        between = first.position(data) - other.position(data)
        length = float(np.sqrt(between.dot(between)))
        return length, between / length if length >= NO_LENGTH else np.zeros(3)

    def _rate(self, data: pin.Data, direction: np.ndarray) -> float:
        """d length/dt [m/s]."""
        first, other = self._ends
        return float(direction.dot(first.velocity(data) - other.velocity(data)))

    def add(self, wrenches: pin.StdVec_Force, t: float, data: pin.Data) -> None:
        """Add its force to both bodies; ``data`` with placements and velocities."""
        if self.acts is False:
            return
        length, direction = self._line(data)
        if length < NO_LENGTH:
            return
        strain = length - self._force.rest_length
        by_state = self.acts is None
        if by_state and self._way * strain < 0.0:
            return
        tension = self._force.stiffness * strain
        if self._force.damping:
            tension += self._force.damping * self._rate(data, direction)
        if by_state and self._way * tension < 0.0:
            return
        first, other = self._ends
        first.add(wrenches, data, -tension * direction)
        other.add(wrenches, data, tension * direction)

    def push(self, q: np.ndarray, v: np.ndarray, data: pin.Data) -> Push:
        """State of a one-sided spring; ``data`` with placements and velocities."""
        length, direction = self._line(data)
        force, rate = self._force, self._rate(data, direction)
        numbers = force.rest_length, self._way, force.stiffness, force.damping
        return Push(*push_between(length, rate, *numbers))

    def energy(self, data: pin.Data) -> float:
        """Energy stored in the spring [J]."""
        strain = self._line(data)[0] - self._force.rest_length
        return 0.5 * self._force.stiffness * strain**2 if self._way * strain >= 0.0 else 0.0
