"""The forces of a scene, brought to the model: torques in joints, wrenches on bodies."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from ..robot import Robot
from ..scene import Actuator, AppliedForce, JointSpring, Scene, Spring
from ..scene.forces import PD, TorqueTable
from ..scene.functions import numbers_from
from .springs import PointOfFrame, SpringBetweenPoints, SpringInJoint

__all__ = ["ForceField", "LimitedPD"]


class ForceField:
    """All forces of a scene on its whole model.

    Attributes:
        on_bodies: whether some force acts on a body; its wrench needs kinematics.
        one_sided: the springs that act on one side only, in the scene's order.
        limited: the PD laws that have a limit, in the scene's order.
        corners: times at which a table has a corner [s].
    """

    def __init__(self, scene: Scene) -> None:
        robot = scene.robot
        self._model = robot.model
        self._constant = np.zeros(self._model.nv)
        self._springs = [SpringInJoint(robot, f) for f in scene.forces if type(f) is JointSpring]
        self._controlled: list[Callable[[float, np.ndarray, np.ndarray], tuple[slice, Any]]] = []
        self._functions: list[Callable[[float, np.ndarray, np.ndarray], tuple[slice, Any]]] = []
        self.limited: list[LimitedPD] = []
        for i, force in enumerate(scene.forces):
            if isinstance(force, Actuator):
                self._add_actuator(robot, force, scene.entry_names("forces")[i])
        self._points = [SpringBetweenPoints(robot, f) for f in scene.forces if type(f) is Spring]
        in_joints, between = iter(self._springs), iter(self._points)
        springs: list[SpringInJoint | SpringBetweenPoints] = []
        for force in scene.forces:
            if type(force) is JointSpring:
                springs.append(next(in_joints))
            elif type(force) is Spring:
                springs.append(next(between))
        self.one_sided = [spring for spring in springs if spring.is_one_sided]
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
        self._on_bodies: list[SpringBetweenPoints | _OnPoint] = [*self._points, *self._applied]
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

    def _add_actuator(self, robot: Robot, force: Actuator, name: str) -> None:
        joint = self._model.joints[robot.joint_id(force.joint)]
        rows = slice(joint.idx_v, joint.idx_v + joint.nv)
        torque = force.torque
        if isinstance(torque, tuple):
            self._constant[rows] += torque
        elif isinstance(torque, PD):
            spring = SpringInJoint(
                robot, JointSpring(force.joint, torque.stiffness, torque.damping, torque.target)
            )
            if torque.limit is not None:
                self.limited.append(LimitedPD(spring, torque, torque.limit))
            self._controlled.append(_pd(spring, rows, torque))
        elif isinstance(torque, TorqueTable):
            self._controlled.append(lambda t, q, v: (rows, torque(t, q, v)))
        elif callable(torque):
            self._functions.append(_function(torque, rows, joint.nv, name))
            self._controlled.append(self._functions[-1])


class LimitedPD(NamedTuple):
    """A PD law with its limit [N m, N]."""

    spring: SpringInJoint
    law: PD
    limit: float

    def unlimited(self, q: np.ndarray, v: np.ndarray) -> float:
        """Its torque without the limit."""
        return float(self.spring.torque(q, v) + self.law.damping * self.law.velocity)


def _pd(spring: SpringInJoint, rows: slice, law: PD) -> Callable:
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


class _OnPoint:
    """An applied force and couple."""

    def __init__(self, robot: Robot, force: AppliedForce, name: str) -> None:
        self._force, self._name = force, name
        self._point = PointOfFrame(robot, force.frame, force.at)
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
