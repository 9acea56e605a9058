"""A problem in plain numbers, as other programs want it: bodies, blows and touching points.

Nothing here is of Pinocchio's kind any more, so it can be handed to a program that has joints
of other conventions, or to a process with another Pinocchio.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from impulsekit.errors import InputError
from impulsekit.scene import AppliedImpulse, Contact, FrameAnchor, JointImpulse, PointAnchor
from impulsekit.scene.coefficients import restitution_at, static_friction

from ..problems.problem import Problem


@dataclass(frozen=True, eq=False)
class Hold:
    """A point of a body held in three rows, or a frame of it in six.

    Attributes:
        body: its index.
        rotation, at: (3, 3), (3,) of the frame in the body.
        rows: 3 or 6.
    """

    body: int
    rotation: np.ndarray
    at: np.ndarray
    rows: int


def hold_of(problem: Problem, entry: Any) -> Hold:
    """The hold of an anchor, or of a contact whose point sticks."""
    robot = problem.scene.robot
    frame = robot.model.frames[robot.frame_id(entry.frame)]
    return Hold(
        frame.parentJoint - 1,
        np.array(frame.placement.rotation),
        frame.placement.act(np.array(entry.at)),
        6 if isinstance(entry, FrameAnchor) else 3,
    )


def is_held(problem: Problem, constraint: Any) -> bool:
    """Whether a constraint holds all of a point or a frame at rest in the world."""
    if isinstance(constraint, FrameAnchor):
        whole = len(constraint.directions) == 6
    else:
        whole = isinstance(constraint, PointAnchor)
    still = whole and np.all(np.array(constraint.velocity) == 0.0)
    return bool(still) and is_fixed(problem, constraint.other)


def is_fixed(problem: Problem, frame: str) -> bool:
    """Whether a frame does not move."""
    robot = problem.scene.robot
    return bool(robot.model.frames[robot.frame_id(frame)].parentJoint == 0)


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body and the joint that carries it.

    A joint of several degrees of freedom is a row of slides and turns that stand at zero, so
    that their rates are Pinocchio's velocities, in the axes of the body.

    Attributes:
        name: of the joint.
        parent: index of the parent, -1 for the world.
        kind: "turn", "slide", "planar", "ball", "free" or "translation".
        rotation, offset: (3, 3), (3,) of the joint in its parent, before its coordinate.
        slides: for each degree of freedom whether it slides; else it turns.
        axes: (n, 3) their axes.
        coordinate: of a joint with one degree of freedom [rad, m]; else 0.
        first: the index of its first velocity.
        mass, centre, inertia: [kg], [m] and [kg m²] about the centre, in the body's axes.
    """

    name: str
    parent: int
    kind: str
    rotation: np.ndarray
    offset: np.ndarray
    slides: tuple[bool, ...]
    axes: np.ndarray
    coordinate: float
    first: int
    mass: float
    centre: np.ndarray
    inertia: np.ndarray


@dataclass(frozen=True, eq=False)
class Blow:
    """An impulse on a body: where on the body and in the world [m], N s and N m s in the world."""

    body: int
    at: np.ndarray
    place: np.ndarray
    linear: np.ndarray
    angular: np.ndarray


@dataclass(frozen=True, eq=False)
class Touch:
    """A point of a body that touches a plane of another: places, normal in the world."""

    body: int
    at: np.ndarray
    other: int
    place: np.ndarray
    normal: np.ndarray
    restitution: float
    friction: float


@dataclass(frozen=True, eq=False)
class Mechanism:
    """What another program has to know of a problem.

    Attributes:
        bodies: parents before children.
        rotations, places: (n, 3, 3), (n, 3) of the bodies in the world.
        blows, touches: what strikes and what touches.
        joint_impulse: (nv,) impulses inside joints.
        v: (nv,) velocity before, rates of the slides and turns.
    """

    bodies: tuple[Body, ...]
    rotations: np.ndarray
    places: np.ndarray
    blows: tuple[Blow, ...]
    touches: tuple[Touch, ...]
    joint_impulse: np.ndarray
    v: np.ndarray


def third_along(axis: np.ndarray) -> np.ndarray:
    """(3, 3) a rotation whose third column is a unit axis."""
    first = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(axis, first), axis])


def is_blow(problem: Problem) -> bool:
    """Whether known impulses are all there is, on joints that any program knows."""
    scene = problem.scene
    rest = scene.constraints or scene.contacts or problem.duration
    return bool(scene.impulses) and not rest and has_plain_joints(problem)


def is_landing(problem: Problem) -> bool:
    """Whether points on planes are all there is, on joints that any program knows."""
    scene = problem.scene
    rest = scene.impulses or scene.constraints or problem.duration
    points = all(isinstance(c, Contact) and not c.tangential_restitution for c in scene.contacts)
    return bool(scene.contacts) and points and not rest and has_plain_joints(problem)


def is_flight(problem: Problem) -> bool:
    """Whether it is a motion after known impulses, with weight and nothing else."""
    scene = problem.scene
    rest = scene.constraints or scene.contacts or scene.forces
    return problem.duration > 0.0 and not rest and has_plain_joints(problem)


def mechanism_of(problem: Problem) -> Mechanism:
    """The numbers of a problem whose joints are plain.

    Raises:
        InputError: a joint of another kind.
    """
    robot, scene = problem.scene.robot, problem.scene
    model = robot.model
    data = model.createData()
    pin.forwardKinematics(model, data, problem.q, problem.v)
    bodies = tuple(_body(model, i, problem.q) for i in range(1, model.njoints))
    poses = list(data.oMi)[1:]
    joint_impulse = np.zeros(model.nv)
    blows = []
    for entry in scene.impulses:
        if isinstance(entry, JointImpulse):
            joint = model.joints[robot.joint_id(entry.joint)]
            joint_impulse[joint.idx_v : joint.idx_v + joint.nv] += entry.impulse
        else:
            blows.append(_blow(problem, data, entry))
    touches = [_touch(problem, data, c) for c in scene.contacts if isinstance(c, Contact)]
    return Mechanism(
        bodies,
        np.array([pose.rotation for pose in poses]),
        np.array([pose.translation for pose in poses]),
        tuple(blows),
        tuple(touches),
        joint_impulse,
        problem.v,
    )


_SEVERAL = {
    "JointModelFreeFlyer": ("free", (True, True, True, False, False, False), (0, 1, 2, 0, 1, 2)),
    "JointModelPlanar": ("planar", (True, True, False), (0, 1, 2)),
    "JointModelSpherical": ("ball", (False, False, False), (0, 1, 2)),
    "JointModelTranslation": ("translation", (True, True, True), (0, 1, 2)),
}


def has_plain_joints(problem: Problem) -> bool:
    model, q = problem.scene.robot.model, problem.q
    return all(
        joint.shortname() in _SEVERAL or _single(joint, q) is not None
        for joint in list(model.joints)[1:]
    )


def _single(joint: pin.JointModel, q: np.ndarray) -> tuple[bool, np.ndarray] | None:
    """Whether a joint with one degree of freedom slides, and its axis; None for another kind."""
    if joint.nv != 1 or "Mimic" in joint.shortname() or "Composite" in joint.shortname():
        return None
    data = joint.createData()
    joint.calc(data, q)
    axis = np.array(data.S).reshape(6)
    if not axis[3:].any():
        return True, axis[:3]
    return None if axis[:3].any() else (False, axis[3:])


def _body(model: pin.Model, joint_id: int, q: np.ndarray) -> Body:
    joint, placement = model.joints[joint_id], model.jointPlacements[joint_id]
    coordinate = 0.0
    if joint.shortname() in _SEVERAL:
        kind, slides, columns = _SEVERAL[joint.shortname()]
        axes = np.eye(3)[list(columns)]
        data = joint.createData()
        joint.calc(data, q)
        placement = placement * pin.SE3(data.M)
    else:
        single = _single(joint, q)
        if single is None:
            raise InputError(f'joint "{model.names[joint_id]}" is of a kind others do not have')
        slide, axis = single
        kind, slides, axes = ("slide" if slide else "turn"), (slide,), axis[None]
        own = q[joint.idx_q : joint.idx_q + joint.nq]
        coordinate = float(own[0]) if joint.nq == 1 else float(np.arctan2(own[1], own[0]))
    inertia = model.inertias[joint_id]
    return Body(
        model.names[joint_id],
        model.parents[joint_id] - 1,
        kind,
        np.array(placement.rotation),
        np.array(placement.translation),
        slides,
        axes,
        coordinate,
        joint.idx_v,
        inertia.mass,
        np.array(inertia.lever),
        np.array(inertia.inertia),
    )


def _blow(problem: Problem, data: pin.Data, entry: AppliedImpulse) -> Blow:
    robot = problem.scene.robot
    frame = robot.model.frames[robot.frame_id(entry.frame)]
    at = frame.placement.act(np.array(entry.at))
    pose = data.oMi[frame.parentJoint]
    turn = np.eye(3) if entry.axes == "world" else pose.rotation @ frame.placement.rotation
    return Blow(
        frame.parentJoint - 1,
        at,
        pose.act(at),
        turn @ np.array(entry.linear),
        turn @ np.array(entry.angular),
    )


def _touch(problem: Problem, data: pin.Data, entry: Contact) -> Touch:
    model, robot = problem.scene.robot.model, problem.scene.robot
    frame = model.frames[robot.frame_id(entry.frame)]
    against = model.frames[robot.frame_id(entry.against)]
    at = frame.placement.act(np.array(entry.at))
    pose, plane = data.oMi[frame.parentJoint], data.oMi[against.parentJoint]
    place = pose.act(at)
    normal = plane.rotation @ against.placement.rotation @ np.array(entry.normal)
    approach = -normal @ (
        _speed(pose, data.v[frame.parentJoint], place)
        - _speed(plane, data.v[against.parentJoint], place)
    )
    return Touch(
        frame.parentJoint - 1,
        at,
        against.parentJoint - 1,
        place,
        normal,
        restitution_at(entry.restitution, max(0.0, float(approach)), "restitution"),
        static_friction(entry.friction),
    )


def _speed(pose: pin.SE3, velocity: pin.Motion, place: np.ndarray) -> np.ndarray:
    """(3,) of the point of a body that is at ``place``."""
    moving = pose.act(velocity)
    return moving.linear + np.cross(moving.angular, place)
