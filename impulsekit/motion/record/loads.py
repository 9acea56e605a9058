"""All forces at one time of a motion, from its state and from what rested then.

They come out of the very evaluation of the accelerations that made the motion:
M a = τ − h + Aᵀλ + JᵀP, of which a, λ and P are one answer.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ...impact.forces import BodyImpulse, on_both_bodies, on_both_ends
from ...impact.reactions import transmitted
from ...rows.entries import FramePair, frame_pair, rows_of_entry
from ...scene import (
    Actuator,
    AppliedForce,
    Collision,
    Contact,
    JointFriction,
    JointSpring,
    Rope,
    Scene,
)
from ..dynamics.accelerations import Dynamics
from ..forces.field import ForceField
from ..gaps.rated import StopGap
from ..tree.memory import Memory

if TYPE_CHECKING:
    from ..rest.joints import DryJoints
    from .path import Path

__all__ = ["ForceBetween", "Loads", "LoadsOfMotion", "PushedPoint"]

# So many times are kept with their forces: those of one look at a motion.
MOST_KEPT = 4096
# Of a polynomial of degree 15, which a step's forces are to rounding.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)


@dataclass(frozen=True, eq=False)
class PushedPoint:
    """One point of a contact that rests.

    Attributes:
        entry: which contact of the scene it belongs to.
        position: (3,) world [m]; None for a joint stop.
        force: (3,) on the first body, world axes [N]; (1,) in the joint of a stop [N m, N].
        power: of that force and the one on the other body, and of the moments [W].
        moment: (3,) on the first body against rolling and spin, world axes [N m]; None where
            nothing resists them.
    """

    entry: int
    position: np.ndarray | None
    force: np.ndarray
    power: float
    moment: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class ForceBetween:
    """What a spring, an actuator or an applied force does at one time.

    Attributes:
        value: (k,) in a joint, by degree of freedom [N m, N]; of a body (6,), force [N] before
            couple [N m] about the point that it acts on, world axes.
        power: [W].
        bodies: its wrenches on bodies.
    """

    value: np.ndarray
    power: float
    bodies: tuple[BodyImpulse, ...]


class Loads:
    """All forces at one time.

    Attributes:
        t: [s]. q: (nq,). v: (nv,). acceleration: (nv,) v̇.
        points: where contacts that rest push.
        multipliers: (m,) by row of the constraints [N, N m].
        unique: (m,) which of them are determined; None where all are.
        forces: by the scene's forces, in their order.
    """

    def __init__(self, of: LoadsOfMotion, t: float) -> None:
        self._of = of
        piece = of.path.piece(t)
        # A force that jumps where a step ends counts as it is within the step.
        inside = math.nextafter(piece.start, math.inf), math.nextafter(piece.end, -math.inf)
        self.t = min(max(t, inside[0]), inside[1]) if inside[0] < inside[1] else t
        self.q, self.v = of.path.state(t)
        dynamics = of.dynamics
        dynamics.resting = piece.footing.restored(of.scene, dynamics.gaps)
        self.acceleration = np.array(dynamics.acceleration(self.t, self.q, self.v))
        data = of.memory.data
        pin.forwardKinematics(dynamics.model, data, self.q, self.v)
        self._placements = [pin.SE3(placement) for placement in data.oMi]
        self.points = tuple(self._pushed(dynamics, data))
        self.multipliers, self.unique = np.empty(0), None
        if dynamics.held is not None and dynamics.borne is not None:
            self.multipliers, self.unique = dynamics.borne
        joints = dynamics.resting.joints
        self.forces = tuple(
            _dry(joints, i, float(self.v[field]))
            if isinstance(field, int)
            else field.at(self.t, self.q, self.v, of.memory)
            for i, field in enumerate(of.fields)
        )

    def _pushed(self, dynamics: Dynamics, data: pin.Data) -> Iterator[PushedPoint]:
        gaps, resting = dynamics.gaps, dynamics.resting
        if gaps is None or not resting.contacts:
            return
        pushed = resting.forces
        if resting.slide():
            # Of what slides the law gives the normal force, which friction goes with.
            pushed = resting.ways(resting.slip, resting.friction())[0].dot(pushed)
        forces, slip = pushed.reshape(-1, 3).copy(), resting.slip.reshape(-1, 3)
        if (pulls := resting.pulls()) is not None:
            forces[:, 2] -= pulls
        turning = {} if resting.rolling is None else resting.rolling.by_point(resting.contacts)
        i = 0
        for contact in resting.contacts:
            item = gaps.items[contact.gap]
            if isinstance(item, StopGap):
                force = np.array([item.sign * forces[i, 2]])
                yield PushedPoint(contact.entry, None, force, float(forces[i] @ slip[i]))
                i += 1
                continue
            for position, axes in item.spots(data):
                power, moment = float(forces[i] @ slip[i]), None
                if i in turning:
                    own, speed = turning[i]
                    power, moment = power + float(own @ speed), axes @ own
                yield PushedPoint(contact.entry, position, axes @ forces[i], power, moment)
                i += 1

    @cached_property
    def row_velocities(self) -> np.ndarray:
        """(m,) the velocities of the constraints' rows [m/s, rad/s]."""
        held = self._of.dynamics.held
        return np.empty(0) if held is None else held.rows.matrix(held.data, self.q) @ self.v

    @cached_property
    def on_bodies(self) -> tuple[BodyImpulse, ...]:
        """All wrenches on bodies from outside them [N, N m], weight apart; entry by entry."""
        of, found = self._of, list[BodyImpulse]()
        names = of.scene.entry_names("contacts")
        for point in self.points:
            if point.position is not None:
                found += on_both_bodies(
                    self._placements.__getitem__,
                    *of.bodies_of_contact(point.entry),
                    point.position,
                    point.force,
                    point.moment,
                    names[point.entry],
                )
        for said, where, name in of.anchors:
            multipliers = self.multipliers[where]
            found += on_both_ends(self._placements.__getitem__, said, multipliers, name)
        for force in self.forces:
            found += force.bodies
        return tuple(found)

    @cached_property
    def reactions(self) -> dict[str, np.ndarray]:
        """By joint name, (6,) the wrench that the parent gives the child [N, N m].

        At the joint's origin, world axes; fixed joints and "root_joint" as for an ``Impact``.
        """
        of = self._of
        motion = self.q, self.v, self.acceleration
        return transmitted(
            of.scene.robot, of.model, of.data_of_robot, motion, self._placements, self.on_bodies
        )

    @cached_property
    def wrenches(self) -> dict[str, np.ndarray]:
        """What changes the momentum of all that moves: by entry, "weight" and "base".

        (6,) each, world axes, force [N] before couple about the world's origin [N m]. "base" is
        what joints to the world transmit; forces between bodies that move are zero.
        """
        of = self._of
        model = of.model
        total: dict[str, np.ndarray] = {}

        def add(name: str, wrench: pin.Force) -> None:
            total[name] = total.get(name, np.zeros(6)) + wrench.vector

        for item in self.on_bodies:
            if item.joint_id > 0:
                add(item.entry, self._placements[item.joint_id].act(item.wrench_in_joint))
        _ = self.reactions
        for joint_id in range(1, model.njoints):
            inertia, placement = model.inertias[joint_id], self._placements[joint_id]
            weight = placement.rotation.T @ (inertia.mass * model.gravity.linear)
            add("weight", placement.act(pin.Force(weight, np.cross(inertia.lever, weight))))
            if model.parents[joint_id] == 0:
                through = self.reactions[model.names[joint_id]]
                arm = np.cross(placement.translation, through[:3])
                add("base", pin.Force(through[:3], through[3:] + arm))
        return total


class LoadsOfMotion:
    """The forces of a motion, worked out where they are asked for.

    Attributes:
        scene, path: of the motion.
        dynamics: its accelerations.
        rows: by constraint, where its rows stand among all.
        fields: by the scene's forces, what each gives; of dry friction the joint's row in v.
        anchors: of the constraints between bodies: what they say, where their rows are, names.
    """

    def __init__(self, scene: Scene, path: Path) -> None:
        self.scene, self.path = scene, path
        self.dynamics = Dynamics(replace(scene, impulses=()))
        robot = scene.robot
        self.model = pin.Model(robot.model)
        self.model.gravity.linear = np.array(scene.gravity)
        self.memory, self.data_of_robot = Memory(self.dynamics.model), self.model.createData()
        names = scene.entry_names("forces")
        self.fields = [
            _row_of(scene, force)
            if isinstance(force, JointFriction)
            else _OneForce(scene, force, name)
            for force, name in zip(scene.forces, names, strict=True)
        ]
        said = [rows_of_entry(robot, entry) for entry in scene.constraints]
        ends = np.cumsum([0, *(len(own.labels) for own in said)]).tolist()
        self.rows = [slice(a, b) for a, b in pairwise(ends)]
        self.anchors = [
            (own, where, name)
            for own, where, name in zip(
                said, self.rows, scene.entry_names("constraints"), strict=True
            )
            if isinstance(own, FramePair)
        ]
        self._kept: dict[float, Loads] = {}

    def at(self, t: float) -> Loads:
        """All forces at a time [s] of the motion: of two steps that meet, those after."""
        found = self._kept.get(t)
        if found is None:
            if len(self._kept) >= MOST_KEPT:
                self._kept.clear()
            with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
                found = self._kept[t] = Loads(self, t)
        return found

    def integral(self, start: float, end: float, value: Callable[[Loads], Any], size: int) -> Any:
        """(size,) of the forces over a span of time, by Gauss's rule on every step."""
        total = np.zeros(size)
        for a, b in self.path.between(start, end):
            middle, half = 0.5 * (a + b), 0.5 * (b - a)
            for node, weight in zip(_NODES.tolist(), _WEIGHTS.tolist(), strict=True):
                total += half * weight * value(self.at(middle + half * node))
        return total

    def bodies_of_contact(self, entry: int) -> tuple[tuple[int, int], tuple[int, int]]:
        """The joints and the frames of both bodies of a contact that is no stop."""
        robot, contact = self.scene.robot, self.scene.contacts[entry]
        if isinstance(contact, Contact | Rope):
            said = frame_pair(robot, contact)
            ends = said.first, said.other
            return (
                (ends[0].joint_id, ends[1].joint_id),
                (ends[0].frame_id, ends[1].frame_id),
            )
        if not isinstance(contact, Collision):
            raise TypeError(type(contact).__name__)
        from ...robot.geometry import geometry_ids

        objects, frames = robot.collision_model.geometryObjects, robot.model.frames
        ids = [
            objects[geometry_ids(robot, name)[0][0]].parentFrame
            for name in (contact.first, contact.other)
        ]
        return (frames[ids[0]].parentJoint, frames[ids[1]].parentJoint), (ids[0], ids[1])


def _row_of(scene: Scene, friction: JointFriction) -> int:
    return int(scene.robot.model.joints[scene.robot.joint_id(friction.joint)].idx_v)


def _dry(joints: DryJoints | None, entry: int, speed: float) -> ForceBetween:
    """What an entry of dry friction gave at the last evaluation."""
    torque = 0.0 if joints is None else joints.torque_of(entry)
    return ForceBetween(np.array([torque]), torque * speed, ())


class _OneForce:
    """One of the scene's forces by itself."""

    def __init__(self, scene: Scene, force: Any, name: str) -> None:
        robot = scene.robot
        self._field = ForceField(replace(scene, forces=[replace(force, name=name)]))
        self._name = name
        self._joint, self._frames = None, {}
        if isinstance(force, Actuator | JointSpring):
            joint = robot.model.joints[robot.joint_id(force.joint)]
            self._joint = slice(joint.idx_v, joint.idx_v + joint.nv)
            return
        names = [force.frame] if isinstance(force, AppliedForce) else [force.frame, force.other]
        self._at = np.array(force.at)
        self._first = robot.frame_id(names[0])
        self._placement = robot.model.frames[self._first].placement
        for frame_id in map(robot.frame_id, names):
            self._frames[robot.model.frames[frame_id].parentJoint] = frame_id

    def at(self, t: float, q: np.ndarray, v: np.ndarray, memory: Memory) -> ForceBetween:
        """What it gives; ``memory`` with placements and velocities."""
        if self._joint is not None:
            torque = self._field.torque(t, q, v)
            return ForceBetween(torque[self._joint].copy(), float(torque @ v), ())
        wrenches, data = self._field.wrenches(t, memory), memory.data
        bodies = tuple(
            BodyImpulse(frame_id, joint_id, pin.Force(wrenches[joint_id]), self._name)
            for joint_id, frame_id in self._frames.items()
        )
        power = sum(data.v[b.joint_id].dot(b.wrench_in_joint) for b in bodies if b.joint_id > 0)
        first = next(b for b in bodies if b.frame_id == self._first)
        at_point = self._placement * pin.SE3(np.eye(3), self._at)
        own = at_point.actInv(first.wrench_in_joint)
        turn = data.oMi[first.joint_id].rotation @ at_point.rotation
        value = np.concatenate([turn @ own.linear, turn @ own.angular])
        return ForceBetween(value, float(power), bodies)
