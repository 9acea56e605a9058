"""All forces at one time of a motion, from its state and from what rested then.

They come out of the very evaluation of the accelerations that made the motion:
M a = τ − h + Aᵀλ + JᵀP, of which a, λ and P are one answer.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ..._core import ForcesAt, ForcesOfMotion
from ...impact.forces import BodyImpulse, on_both_bodies, on_both_ends
from ...impact.reactions import transmitted
from ...rows.entries import FramePair, frame_pair, rows_of_entry
from ...scene import (
    Actuator,
    AppliedForce,
    Collision,
    Contact,
    GapContact,
    JointFriction,
    JointSpring,
    JointStop,
    Rope,
    Scene,
)
from ..flat import flat_motion

if TYPE_CHECKING:
    from .path import Path

__all__ = ["ForceBetween", "Loads", "LoadsOfMotion", "PushedPoint", "pushed_points"]

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
    """The force of a spring, an actuator or an applied force at one time.

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
        start, end = of.path.span(t)
        # A force that jumps where a step ends counts as it is within the step.
        inside = math.nextafter(start, math.inf), math.nextafter(end, -math.inf)
        self.t = min(max(t, inside[0]), inside[1]) if inside[0] < inside[1] else t
        self.q, self.v = of.path.state(t)
        found = of.core.at(self.t, self.q, self.v, of.path.resting_state(t))
        self.acceleration = found.acceleration
        data = of.data
        pin.forwardKinematics(of.model, data, self.q, self.v)
        self._placements = [pin.SE3(placement) for placement in data.oMi]
        self.points = tuple(pushed_points(of.scene, found))
        self.multipliers, unique = found.multipliers, found.unique
        self.unique = None if unique.all() else unique
        self.forces = tuple(
            _dry(found.dry, one, float(self.v[one.row]))
            if isinstance(one, _DryShare)
            else one.at(self.t, self.q, self.v, data)
            for one in of.fields
        )

    @cached_property
    def row_velocities(self) -> np.ndarray:
        """(m,) the velocities of the constraints' rows [m/s, rad/s]."""
        return self._of.core.row_velocities(self.q, self.v)

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
        """Return the wrenches on all moving bodies: by entry, "weight" and "base".

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
    """The forces of a motion, computed on access.

    Attributes:
        scene, path: of the motion.
        core: what gives them.
        rows: by constraint, where its rows stand among all.
        fields: by the scene's forces, what each gives; of dry friction the joint's row in v.
        anchors: of the constraints between bodies: what they say, where their rows are, names.
    """

    def __init__(self, scene: Scene, path: Path, slow: float) -> None:
        self.scene, self.path = scene, path
        flat, robot = flat_motion(scene), scene.robot
        self.core = ForcesOfMotion(flat.core, slow)
        self.model = pin.Model(robot.model)
        self.model.gravity.linear = np.array(scene.gravity)
        self.data, self.data_of_robot = self.model.createData(), self.model.createData()
        names, dry = scene.entry_names("forces"), list[int]()
        for force in scene.forces:
            if isinstance(force, JointFriction) and _row_of(scene, force) not in dry:
                dry.append(_row_of(scene, force))
        self.fields = [
            _DryShare(scene, force, dry)
            if isinstance(force, JointFriction)
            else _OneForce(self.core, flat.flat.model.bodies, scene, i, name)
            for i, (force, name) in enumerate(zip(scene.forces, names, strict=True))
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


def pushed_points(scene: Scene, found: ForcesAt) -> Iterator[PushedPoint]:
    """Return the points at which resting contacts push, as the core found them."""
    forces, slip = found.forces.reshape(-1, 3), found.slip.reshape(-1, 3)
    axes, places = found.axes.reshape(-1, 3, 3), found.places.reshape(-1, 3)
    moments, turning = found.moments.reshape(-1, 3), found.turning.reshape(-1, 3)
    turns = {i: k for k, i in enumerate(found.turning_of)}
    for i, entry in enumerate(found.entries):
        power = float(forces[i] @ slip[i])
        if isinstance(scene.contacts[entry], JointStop):
            yield PushedPoint(entry, None, np.array([found.signs[i] * forces[i, 2]]), power)
            continue
        moment = None
        if i in turns:
            k = turns[i]
            power += float(moments[k] @ turning[k])
            moment = axes[i] @ moments[k]
        by_functions = isinstance(scene.contacts[entry], GapContact)
        place = None if by_functions else places[i]
        yield PushedPoint(entry, place, axes[i] @ forces[i], power, moment)


def _row_of(scene: Scene, friction: JointFriction) -> int:
    return int(scene.robot.model.joints[scene.robot.joint_id(friction.joint)].idx_v)


class _DryShare:
    """An entry of dry friction: the joint's row in v, and its share of all friction there."""

    def __init__(self, scene: Scene, friction: JointFriction, rows: list[int]) -> None:
        self.row = _row_of(scene, friction)
        self.index = rows.index(self.row)
        total = sum(
            force.torque
            for force in scene.forces
            if isinstance(force, JointFriction) and _row_of(scene, force) == self.row
        )
        self.part = friction.torque / total if total else 0.0


def _dry(torques: np.ndarray, share: _DryShare, speed: float) -> ForceBetween:
    """Return the torque of an entry of dry friction."""
    torque = float(share.part * torques[share.index])
    return ForceBetween(np.array([torque]), torque * speed, ())


class _OneForce:
    """One of the scene's forces by itself."""

    def __init__(
        self, core: ForcesOfMotion, bodies: Sequence[int], scene: Scene, index: int, name: str
    ) -> None:
        robot = scene.robot
        force: Any = scene.forces[index]
        self._core, self._bodies, self._index, self._name = core, bodies, index, name
        self._joint: slice | None = None
        self._frames: dict[int, int] = {}
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

    def at(self, t: float, q: np.ndarray, v: np.ndarray, data: pin.Data) -> ForceBetween:
        """Return its force; ``data`` with placements and velocities."""
        given = self._core.force(self._index, t, q, v)
        if self._joint is not None:
            torques = given.torques
            return ForceBetween(torques[self._joint].copy(), float(torques @ v), ())
        by_body = given.wrenches.reshape(-1, 6)
        bodies = []
        for joint_id, frame_id in self._frames.items():
            own, turn = by_body[self._bodies[joint_id]], data.oMi[joint_id].rotation
            force = pin.Force(turn.T @ own[:3], turn.T @ own[3:])
            bodies.append(BodyImpulse(frame_id, joint_id, force, self._name))
        power = sum(data.v[b.joint_id].dot(b.wrench_in_joint) for b in bodies if b.joint_id > 0)
        first = next(b for b in bodies if b.frame_id == self._first)
        at_point = self._placement * pin.SE3(np.eye(3), self._at)
        own = at_point.actInv(first.wrench_in_joint)
        turn = data.oMi[first.joint_id].rotation @ at_point.rotation
        value = np.concatenate([turn @ own.linear, turn @ own.angular])
        return ForceBetween(value, float(power), tuple(bodies))
