"""The forces of a scene, brought to the model: torques in joints, wrenches on bodies."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pinocchio as pin

from ...scene import Actuator, Scene
from ...scene.functions import numbers_from
from ..tree.memory import MOTION, Memory, rows_of
from .laws import BETWEEN, potential_of, push_bodies, torque_in_joint
from .tables import tables_of

__all__ = ["ForceField"]


class ForceField:
    """All forces of a scene on its whole model: those of tables, and users' functions.

    Attributes:
        loads: the tables. driven: what in them is a function of time.
        is_known: whether the tables have all of the scene's forces.
        has_functions: whether some force is a function that a user gave; asks_for_states: whether
            one of them asks for q and v.
        on_bodies: whether some force acts on a body; its wrench needs kinematics.
    """

    def __init__(self, scene: Scene) -> None:
        model = scene.robot.model
        self.loads, self.driven, functions, has_all = tables_of(scene)
        self._functions = [
            (rows, _function(scene, entry, rows.stop - rows.start)) for entry, rows in functions
        ]
        self.is_known = has_all and not functions
        self.asks_for_states = bool(functions)
        self.has_functions = bool(functions or self.driven.given)
        self._row = np.zeros(self.driven.count)
        loads = self.loads
        # Python reads lists faster than arrays; what has no kink stays what it is.
        kinked = set(loads.kinks[loads.kinks[:, 0] != BETWEEN, 1].tolist())
        self._joints: list[tuple[Any, Any]] = [
            (joint, loads.in_joints[i] if i in kinked else loads.in_joints[i].tolist())
            for i, joint in enumerate(loads.joints.tolist())
        ]
        self.on_bodies = bool(len(loads.springs) or len(loads.applied))
        self._is_constant = not (len(loads.joints) or len(loads.rows) or functions)
        self._wrenches = pin.StdVec_Force()
        for _ in range(model.njoints):
            self._wrenches.append(pin.Force.Zero())
        # The memory of the same.
        self._force = rows_of(self._wrenches, lambda force: force.vector, model.njoints, MOTION)

    @property
    def constant_torque(self) -> np.ndarray | None:
        """(nv,) all there is, where that is the same at all times; not to be written to."""
        return self.loads.constant if self._is_constant and not self.on_bodies else None

    def torque(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(nv,) what acts along the generalized speeds themselves; not to be written to."""
        if self._is_constant:
            return self.loads.constant
        total = self.loads.constant.copy()
        for joint, numbers in self._joints:
            total[joint[0]] += torque_in_joint(joint, numbers, q, v)
        if len(self.loads.rows):
            self.driven.write_torques(t, self._row)
            np.add.at(total, self.loads.rows, self._row[-len(self.loads.rows) :])
        for rows, function in self._functions:
            total[rows] += function(t, q, v)
        return total

    def wrenches(self, t: float, memory: Memory) -> pin.StdVec_Force:
        """The spatial force on every joint's body, in the joint's frame.

        Args:
            t: time [s].
            memory: with placements and velocities of the joints.
        """
        force = self._force
        force[:] = 0.0
        self.driven.write_forces(t, self._row)
        push_bodies(self.loads, self._row, memory.places, memory.speeds, force)
        np.negative(force, out=force)
        return self._wrenches

    def potential(self, q: np.ndarray, memory: Memory) -> float:
        """The energy in the springs [J]; ``memory`` with the placements at q."""
        return float(potential_of(self.loads, memory.places, memory.speeds, q))

    def given(self, t: float, q: np.ndarray, v: np.ndarray) -> list[np.ndarray]:
        """What the users' functions give: torques, forces and couples, each by itself."""
        values = [np.atleast_1d(function(t, q, v)) for _, function in self._functions]
        for _, function_of_time in self.driven.given:
            both = function_of_time(t)
            values += [both[:3], both[3:]]
        return values


def _function(
    scene: Scene, entry: int, size: int
) -> Callable[[float, np.ndarray, np.ndarray], np.ndarray]:
    """A user's torque, held to shape and finiteness at every call."""
    force, name = scene.forces[entry], scene.entry_names("forces")[entry]
    torque: Any = force.torque if isinstance(force, Actuator) else None
    return partial(_numbers, torque, name, size)


def _numbers(
    torque: Any, name: str, size: int, t: float, q: np.ndarray, v: np.ndarray
) -> np.ndarray:
    what = f"{name}: torque at t = {t:g}"
    return numbers_from(torque, what, size, t, q, v, infinite=True)
