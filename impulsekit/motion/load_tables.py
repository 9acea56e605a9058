"""The forces of a scene as tables for compiled code, and what of them is driven in time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..robot import Robot
from ..scene import Actuator, AppliedForce, JointSpring, Scene, Spring
from ..scene.forces import PD, TorqueTable
from .compiled_loads import ON, Loads

__all__ = ["Driven", "loads_of"]

_SIDES = {"both": 0.0, "above": 1.0, "below": -1.0}
# Columns after the six numbers of a spring in a joint: four unused, and its state (ON), ACTS.
_ACTS = (0.0, 0.0, 0.0, 0.0, 1.0)
_WAYS = {"both": 0.0, "pull": 1.0, "push": -1.0}


class Driven:
    """What of a scene's forces is a function of time alone: of applied forces, then of torques.

    Attributes:
        count: how many numbers that is.
        is_constant: whether they stay what they are.
    """

    def __init__(self, forces: Sequence[tuple[AppliedForce, str]], tables: Sequence[TorqueTable]):
        self._tables = tables
        self.count = 6 * len(forces) + len(tables)
        self._start = np.zeros(self.count)
        self._given: list[tuple[int, Callable[[float], np.ndarray]]] = []
        for i, (force, name) in enumerate(forces):
            if force.is_constant:
                self._start[6 * i : 6 * i + 6] = force.force_at(0.0)
            else:
                self._given.append((6 * i, _named(force, name)))
        self.is_constant = not self._given and not tables

    def write(self, t: float, row: np.ndarray) -> None:
        """Write what is driven at a time [s]."""
        row[:] = self._start
        for at, given in self._given:
            row[at : at + 6] = given(t)
        first = self.count - len(self._tables)
        for i, table in enumerate(self._tables):
            row[first + i] = table(t, None, None)


def _named(force: AppliedForce, name: str) -> Callable[[float], np.ndarray]:
    return lambda t: force.force_at(t, name)


def loads_of(scene: Scene) -> tuple[Loads, Driven] | None:
    """The forces of a scene; None where a torque is a user's function."""
    robot, names = scene.robot, scene.entry_names("forces")
    constant = np.zeros(robot.model.nv)
    joints: list[tuple[int, int, int]] = []
    in_joints: list[tuple[float, ...]] = []
    springs: list[tuple[int, int]] = []
    between: list[np.ndarray] = []
    kinks: list[tuple[int, int]] = []
    rows: list[int] = []
    tables: list[TorqueTable] = []
    applied: list[tuple[AppliedForce, str]] = []
    for force, name in zip(scene.forces, names, strict=True):
        if getattr(force, "acts", "both") != "both":
            between_points = type(force) is Spring
            kinks.append((int(between_points), len(springs if between_points else joints)))
        if type(force) is JointSpring:
            joints.append(_entries(robot, force.joint))
            side = _SIDES[force.acts]
            own = force.stiffness, force.damping, force.rest, side, 0.0, np.inf
            in_joints.append((*own, *_ACTS))
        elif type(force) is Spring:
            ends = (robot, force.frame, force.at), (robot, force.other, force.other_at)
            (one, here), (two, there) = (_point(*end) for end in ends)
            springs.append((one, two))
            more = force.stiffness, force.damping, force.rest_length, _WAYS[force.acts]
            between.append(np.array([*here, *there, *more, 1.0]))
        elif type(force) is AppliedForce:
            applied.append((force, name))
        elif type(force) is Actuator and isinstance(force.torque, tuple):
            joint = robot.model.joints[robot.joint_id(force.joint)]
            constant[joint.idx_v : joint.idx_v + joint.nv] += force.torque
        elif type(force) is Actuator and isinstance(force.torque, PD):
            law = force.torque
            joints.append(_entries(robot, force.joint))
            limit = np.inf if law.limit is None else law.limit
            if law.limit is not None:
                kinks.append((2, len(joints) - 1))
            more = law.target, 0.0, law.damping * law.velocity, limit
            in_joints.append((law.stiffness, law.damping, *more, *_ACTS))
        elif type(force) is Actuator and isinstance(force.torque, TorqueTable):
            rows.append(_entries(robot, force.joint)[0])
            tables.append(force.torque)
        else:
            return None
    places = [_placement(robot, force) for force, _ in applied]
    loads = Loads(
        constant,
        np.array(joints, dtype=np.int64).reshape(-1, 3),
        np.array(in_joints, dtype=float).reshape(-1, ON + 1),
        np.array(rows, dtype=np.int64),
        np.array(springs, dtype=np.int64).reshape(-1, 2),
        np.array(between, dtype=float).reshape(-1, ON + 1),
        np.array(kinks, dtype=np.int64).reshape(-1, 2),
        np.array([place[0] for place in places], dtype=np.int64).reshape(-1, 2),
        np.array([place[1] for place in places], dtype=float).reshape(-1, 12),
    )
    return loads, Driven(applied, tables)


def _entries(robot: Robot, name: str) -> tuple[int, int, int]:
    """Of a joint with one degree of freedom: row in v, entry in q, whether it has two of these."""
    joint = robot.model.joints[robot.joint_id(name)]
    return joint.idx_v, joint.idx_q, int(joint.nq == 2)


def _point(robot: Robot, frame: str, at: Any) -> tuple[int, np.ndarray]:
    """The joint that carries a point of a frame, and the point in its axes."""
    item = robot.model.frames[robot.frame_id(frame)]
    return item.parentJoint, item.placement.act(np.array(at, dtype=float))


def _placement(robot: Robot, force: AppliedForce) -> tuple[tuple[int, int], np.ndarray]:
    joint_id, at = _point(robot, force.frame, force.at)
    rotation = robot.model.frames[robot.frame_id(force.frame)].placement.rotation
    numbers = np.concatenate([rotation.T.ravel(), at])
    return (joint_id, int(force.axes == "world")), numbers
