"""The forces of a scene as tables, and what of them is driven in time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...robot import Robot
from ...rows.entries import Site
from ...scene import Actuator, AppliedForce, JointSpring, Scene, Spring
from ...scene.forces import PD, TorqueTable
from .laws import ACTS, BY_STATE, LIMITED, ON, Loads

__all__ = ["Driven", "Tables", "tables_of"]

_SIDES = {"both": 0.0, "above": 1.0, "below": -1.0}
_WAYS = {"both": 0.0, "pull": 1.0, "push": -1.0}


class Driven:
    """What of a scene's forces is a function of time alone: of applied forces, then of torques.

    Attributes:
        count: how many numbers that is.
        is_constant: whether they stay what they are.
        given: users' functions, and where what they give stands.
        corners: times at which a table has a corner [s].
    """

    def __init__(self, forces: Sequence[tuple[AppliedForce, str]], tables: Sequence[TorqueTable]):
        self._tables, self._first = tables, 6 * len(forces)
        self.count = self._first + len(tables)
        self._start = np.zeros(self._first)
        self.given: list[tuple[int, Callable[[float], np.ndarray]]] = []
        for i, (force, name) in enumerate(forces):
            if force.is_constant:
                self._start[6 * i : 6 * i + 6] = force.force_at(0.0)
            else:
                self.given.append((6 * i, _named(force, name)))
        self.is_constant = not self.given and not tables
        self.corners = sorted({time for table in tables for time in table.times})

    def write(self, t: float, row: np.ndarray) -> None:
        """Write what is driven at a time [s]."""
        self.write_forces(t, row)
        self.write_torques(t, row)

    def write_forces(self, t: float, row: np.ndarray) -> None:
        """The same of applied forces alone."""
        row[: self._first] = self._start
        for at, given in self.given:
            row[at : at + 6] = given(t)

    def write_torques(self, t: float, row: np.ndarray) -> None:
        """The same of torques alone."""
        for i, table in enumerate(self._tables):
            row[self._first + i] = table(t, None, None)


def _named(force: AppliedForce, name: str) -> Callable[[float], np.ndarray]:
    return lambda t: force.force_at(t, name)


class Tables(NamedTuple):
    """The forces of a scene: ``loads`` and what is driven in time.

    Besides, (entry, rows in v) of torques that are functions of the state, and whether tables
    have all the others.
    """

    loads: Loads
    driven: Driven
    functions: list[tuple[int, slice]]
    has_all: bool


def tables_of(scene: Scene) -> Tables:
    """The forces of a scene."""
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
    functions: list[tuple[int, slice]] = []
    has_all = True
    for entry, (force, name) in enumerate(zip(scene.forces, names, strict=True)):
        state = ACTS if getattr(force, "acts", "both") == "both" else BY_STATE
        if state == BY_STATE:
            between_points = type(force) is Spring
            kinks.append((int(between_points), len(springs if between_points else joints)))
        if type(force) is JointSpring:
            joints.append(_entries(robot, force.joint))
            own = force.stiffness, force.damping, force.rest, _SIDES[force.acts], 0.0, np.inf
            in_joints.append((*own, 0.0, 1.0, 0.0, 0.0, state))
        elif type(force) is Spring:
            ends = (robot, force.frame, force.at), (robot, force.other, force.other_at)
            (one, here), (two, there) = (_point(*end) for end in ends)
            springs.append((one, two))
            more = force.stiffness, force.damping, force.rest_length, _WAYS[force.acts]
            between.append(np.array([*here, *there, *more, state]))
        elif type(force) is AppliedForce:
            applied.append((force, name))
        elif type(force) is not Actuator:
            has_all = False
        elif isinstance(force.torque, PD):
            law = force.torque
            joints.append(_entries(robot, force.joint))
            limit = np.inf if law.limit is None else law.limit
            if law.limit is not None:
                kinks.append((LIMITED, len(joints) - 1))
            more = law.target, 0.0, law.damping * law.velocity, limit
            in_joints.append((law.stiffness, law.damping, *more, 0.0, 0.0, 0.0, 0.0, ACTS))
        elif isinstance(force.torque, TorqueTable):
            rows.append(_entries(robot, force.joint)[0])
            tables.append(force.torque)
        else:
            joint = robot.model.joints[robot.joint_id(force.joint)]
            own_rows = slice(joint.idx_v, joint.idx_v + joint.nv)
            if isinstance(force.torque, tuple):
                constant[own_rows] += force.torque
            else:
                functions.append((entry, own_rows))
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
    return Tables(loads, Driven(applied, tables), functions, has_all)


def _entries(robot: Robot, name: str) -> tuple[int, int, int]:
    """Of a joint with one degree of freedom: row in v, entry in q, whether it has two of these."""
    joint = robot.model.joints[robot.joint_id(name)]
    return joint.idx_v, joint.idx_q, int(joint.nq == 2)


def _point(robot: Robot, frame: str, at: Any) -> tuple[int, np.ndarray]:
    """The joint that carries a point of a frame, and the point in its axes."""
    site = Site.of(robot, frame, at)
    return site.joint_id, site.placement.translation


def _placement(robot: Robot, force: AppliedForce) -> tuple[tuple[int, int], np.ndarray]:
    site = Site.of(robot, force.frame, force.at)
    numbers = np.concatenate([site.placement.rotation.T.ravel(), site.placement.translation])
    return (site.joint_id, int(force.axes == "world")), numbers
