"""The forces of a scene, brought to the model: torques in joints, wrenches on bodies."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin

from ..robot import Robot
from ..scene import Actuator, AppliedForce, JointSpring, Scene, Spring
from ..scene.forces import PD, TorqueTable
from ..scene.functions import numbers_from

__all__ = ["ForceField"]

# Ends of a spring nearer than this [m] have no direction between them.
NO_LENGTH = 1e-12


class ForceField:
    """All forces of a scene on its whole model.

    Attributes:
        on_bodies: whether some force acts on a body; its wrench needs kinematics.
        corners: times at which a table has a corner [s].
    """

    def __init__(self, scene: Scene) -> None:
        robot = scene.robot
        self._model = robot.model
        self._constant = np.zeros(self._model.nv)
        self._springs = [_SpringInJoint(robot, f) for f in scene.forces if type(f) is JointSpring]
        self._controlled: list[Callable[[float, np.ndarray, np.ndarray], tuple[slice, Any]]] = []
        self._functions: list[Callable[[float, np.ndarray, np.ndarray], tuple[slice, Any]]] = []
        for i, force in enumerate(scene.forces):
            if isinstance(force, Actuator):
                self._add_actuator(robot, force, scene.entry_names("forces")[i])
        self._points = [_SpringBetweenPoints(robot, f) for f in scene.forces if type(f) is Spring]
        names = scene.entry_names("forces")
        self.corners = sorted(
            {
                time
                for force in scene.forces
                if isinstance(force, Actuator) and isinstance(force.torque, TorqueTable)
                for time in force.torque.times
            }
        )
        self._applied = [
            _OnPoint(robot, force, name)
            for force, name in zip(scene.forces, names, strict=True)
            if type(force) is AppliedForce
        ]
        self.on_bodies = bool(self._points or self._applied)
        self._is_constant = not (self._springs or self._controlled)
        self._wrenches = pin.StdVec_Force()
        for _ in range(self._model.njoints):
            self._wrenches.append(pin.Force.Zero())
        self._on_bodies: list[_SpringBetweenPoints | _OnPoint] = [*self._points, *self._applied]
        self._loaded = sorted({j for force in self._on_bodies for j in force.joint_ids})

    @property
    def constant_torque(self) -> np.ndarray | None:
        """(nv,) all there is, where that is the same at all times; not to be written to."""
        return self._constant if self._is_constant and not self.on_bodies else None

    def torque(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(nv,) what acts along the generalized speeds themselves; not to be written to."""
        if self._is_constant:
            return self._constant
        total = self._constant.copy()
        for spring in self._springs:
            total[spring.row] += spring.torque(q, v)
        for controlled in self._controlled:
            rows, torque = controlled(t, q, v)
            total[rows] += torque
        return total

    def wrenches(self, t: float, data: pin.Data) -> pin.StdVec_Force:
        """The spatial force on every joint's body, in the joint's frame.

        Args:
            t: time [s].
            data: with placements and velocities of the joints.
        """
        wrenches = self._wrenches
        for joint_id in self._loaded:
            wrenches[joint_id].setZero()
        for force in self._on_bodies:
            force.add(wrenches, t, data)
        return wrenches

    def potential(self, q: np.ndarray, data: pin.Data) -> float:
        """The energy in the springs [J]; ``data`` with the placements at q."""
        energies = [spring.energy(q) for spring in self._springs]
        return sum(energies) + sum(spring.energy(data) for spring in self._points)

    @property
    def has_functions(self) -> bool:
        """Whether some force is a function that a user gave."""
        return bool(self._functions) or any(not force.is_constant for force in self._applied)

    @property
    def asks_for_states(self) -> bool:
        """Whether some function that a user gave asks for q and v."""
        return bool(self._functions)

    def given(self, t: float, q: np.ndarray, v: np.ndarray) -> list[np.ndarray]:
        """What the users' functions give: torques, forces and couples, each by itself."""
        values = [np.atleast_1d(function(t, q, v)[1]) for function in self._functions]
        for force in self._applied:
            if not force.is_constant:
                both = force.force_at(t)
                values += [both[:3], both[3:]]
        return values

    @property
    def has_springs(self) -> bool:
        """Whether some force stores energy."""
        return bool(self._springs or self._points)

    def _add_actuator(self, robot: Robot, force: Actuator, name: str) -> None:
        joint = self._model.joints[robot.joint_id(force.joint)]
        rows = slice(joint.idx_v, joint.idx_v + joint.nv)
        torque = force.torque
        if isinstance(torque, tuple):
            self._constant[rows] += torque
        elif isinstance(torque, PD):
            spring = _SpringInJoint(
                robot, JointSpring(force.joint, torque.stiffness, torque.damping, torque.target)
            )
            self._controlled.append(_pd(spring, rows, torque))
        elif isinstance(torque, TorqueTable):
            self._controlled.append(lambda t, q, v: (rows, torque(t, q, v)))
        elif callable(torque):
            self._functions.append(_function(torque, rows, joint.nv, name))
            self._controlled.append(self._functions[-1])


def _pd(spring: _SpringInJoint, rows: slice, law: PD) -> Callable:
    def controlled(t: float, q: np.ndarray, v: np.ndarray) -> tuple[slice, float]:
        torque = spring.torque(q, v) + law.damping * law.velocity
        if law.limit is not None:
            torque = min(max(torque, -law.limit), law.limit)
        return rows, torque

    return controlled


def _function(torque: Callable, rows: slice, size: int, name: str) -> Callable:
    """A user's function, held to shape and finiteness at every call."""

    def controlled(t: float, q: np.ndarray, v: np.ndarray) -> tuple[slice, np.ndarray]:
        what = f"{name}: torque at t = {t:g}"
        return rows, numbers_from(torque, what, size, t, q, v, infinite=True)

    return controlled


class _SpringInJoint:
    """τ = −k (q − rest) − c v."""

    def __init__(self, robot: Robot, force: JointSpring) -> None:
        joint = robot.model.joints[robot.joint_id(force.joint)]
        self.row, self._entry = joint.idx_v, joint.idx_q
        self._continuous = joint.nq == 2
        self._stiffness, self._damping, self._rest = force.stiffness, force.damping, force.rest
        # Which side of the rest it acts on; 0 for both.
        self._side = {"both": 0.0, "above": 1.0, "below": -1.0}[force.acts]

    def _strain(self, q: np.ndarray) -> float:
        if not self._continuous:
            return q[self._entry] - self._rest
        angle = np.arctan2(q[self._entry + 1], q[self._entry]) - self._rest
        return (angle + np.pi) % (2.0 * np.pi) - np.pi

    def torque(self, q: np.ndarray, v: np.ndarray) -> float:
        strain, side = self._strain(q), self._side
        torque = -self._stiffness * strain - self._damping * v[self.row]
        if side and not (side * strain > 0.0 and side * torque < 0.0):
            return 0.0
        return torque

    def energy(self, q: np.ndarray) -> float:
        strain = float(self._strain(q))
        return 0.5 * self._stiffness * strain**2 if self._side * strain >= 0.0 else 0.0


class _Point:
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
        """Add a force through the point, in world axes; what the world bears is told as well."""
        local = force_world.dot(data.oMi[self.joint_id].rotation)
        wrenches[self.joint_id] += pin.Force(local, np.cross(self._at, local))


class _SpringBetweenPoints:
    """A spring and damper along the line between two points."""

    def __init__(self, robot: Robot, force: Spring) -> None:
        self._force = force
        # 1 for what only pulls, −1 for what only pushes; 0 for both.
        self._way = {"both": 0.0, "pull": 1.0, "push": -1.0}[force.acts]
        self._ends = (
            _Point(robot, force.frame, force.at),
            _Point(robot, force.other, force.other_at),
        )
        self.joint_ids = tuple(end.joint_id for end in self._ends)

    def add(self, wrenches: pin.StdVec_Force, t: float, data: pin.Data) -> None:
        first, other = self._ends
        between = first.position(data) - other.position(data)
        length = np.sqrt(between.dot(between))
        if length < NO_LENGTH:
            return
        direction = between / length
        strain = length - self._force.rest_length
        if self._way * strain < 0.0:
            return
        tension = self._force.stiffness * strain
        if self._force.damping:
            rate = direction.dot(first.velocity(data) - other.velocity(data))
            tension += self._force.damping * rate
        if self._way * tension < 0.0:
            return
        first.add(wrenches, data, -tension * direction)
        other.add(wrenches, data, tension * direction)

    def energy(self, data: pin.Data) -> float:
        first, other = self._ends
        length = np.linalg.norm(first.position(data) - other.position(data))
        strain = float(length - self._force.rest_length)
        return 0.5 * self._force.stiffness * strain**2 if self._way * strain >= 0.0 else 0.0


class _OnPoint:
    """An applied force and couple."""

    def __init__(self, robot: Robot, force: AppliedForce, name: str) -> None:
        self._force, self._name = force, name
        self._point = _Point(robot, force.frame, force.at)
        self.joint_ids = (self._point.joint_id,)
        self.is_constant = force.is_constant
        self._constant = force.force_at(0.0) if force.is_constant else None

    def force_at(self, t: float) -> np.ndarray:
        """(6,) force before couple at a time [s], in the axes of the entry."""
        if self._constant is not None:
            return self._constant
        return self._force.force_at(t, self._name)

    def add(self, wrenches: pin.StdVec_Force, t: float, data: pin.Data) -> None:
        given = self.force_at(t)
        point = self._point
        if self._force.axes == "world":
            rotation = data.oMi[point.joint_id].rotation.dot(point.placement.rotation)
            given = np.concatenate([given[:3].dot(rotation), given[3:].dot(rotation)])
        wrenches[point.joint_id] += point.placement.act(pin.Force(given))
