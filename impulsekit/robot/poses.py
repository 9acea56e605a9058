"""Poses of free bodies, and a robot set down on its ground."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ..errors import InputError, RangeError, quoted
from .arrays import array_of
from .base import RobotBase
from .placing import Posture, rotation_from

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


def pose(
    xyz: ArrayLike = (0.0, 0.0, 0.0),
    *,
    rpy: ArrayLike | None = None,
    rotation_vector: ArrayLike | None = None,
    wxyz: ArrayLike | None = None,
    xyzw: ArrayLike | None = None,
    rotation: ArrayLike | None = None,
) -> pin.SE3:
    """Return a pose for ``Robot.configuration`` from a point and a rotation in any one form.

    Args:
        xyz: (3,) the origin [m].
        rpy: (3,) roll, pitch, yaw [rad] as in a URDF: R = Rz(yaw) Ry(pitch) Rx(roll).
        rotation_vector: (3,) axis times angle [rad].
        wxyz, xyzw: (4,) a quaternion of any length above zero, made unit.
        rotation: (3, 3) a rotation matrix.

    Raises:
        InputError: more than one rotation, or a matrix that is none.
        RangeError: a quaternion of length zero.
        ShapeError, NotFiniteError.

    Example:
        >>> from impulsekit import Robot
        >>> robot = Robot.from_example("talos", root="freeflyer")
        >>> robot.configuration(root_joint=pose([0, 0, 1], rpy=[0, 0, np.pi]))[3:7].round(6)
        array([0., 0., 1., 0.])
    """
    given = {
        "rpy": rpy,
        "rotation_vector": rotation_vector,
        "wxyz": wxyz,
        "xyzw": xyzw,
        "rotation": rotation,
    }
    forms = [name for name, value in given.items() if value is not None]
    if len(forms) > 1:
        raise InputError(f"pose takes one rotation, got {' and '.join(forms)}")
    turn = np.eye(3)
    for name in forms:
        turn = _rotation(name, given[name])
    return pin.SE3(turn, array_of(xyz, (3,), "pose: xyz"))


def _rotation(form: str, value: Any) -> np.ndarray:
    what = f"pose: {form}"
    if form == "rotation":
        return rotation_from(value, what)
    numbers = array_of(value, (4,) if form in ("wxyz", "xyzw") else (3,), what)
    if form == "rpy":
        return np.array(pin.rpy.rpyToMatrix(*numbers))
    if form == "rotation_vector":
        return np.array(pin.exp3(numbers))
    x, y, z, w = np.roll(numbers, -1) if form == "wxyz" else numbers
    if not numbers.any():
        raise RangeError.of(f"{what}: length of the quaternion", 0.0, "above zero")
    return np.array(pin.Quaternion(w, x, y, z).normalized().toRotationMatrix())


def stand(robot: RobotBase, q: ArrayLike, root: str | None = None) -> np.ndarray:
    """Return q with a free part moved along the ground's normal until it just touches.

    ``Robot.stand`` says what of.
    """
    import coal

    posture, model = Posture(robot, q), robot.model
    root_id = _free_root(robot, root)
    objects = robot.collision_model.geometryObjects
    grounds = [item for item in objects if isinstance(item.geometry, coal.Halfspace)]
    if not grounds:
        raise InputError("stand: the robot has no ground; robot.with_ground() gives one")
    carried = [item for item in objects if root_id in model.supports[item.parentJoint]]
    if not carried:
        raise InputError(f'stand: nothing on joint "{model.names[root_id]}" has geometry')
    plane = grounds[0].geometry
    normal = grounds[0].placement.rotation @ np.array(plane.n)
    to_ground = grounds[0].placement.inverse()
    gap = min(
        _gap(item.geometry, to_ground * posture.joint(item.parentJoint) * item.placement, plane)
        for item in carried
    )
    q, start = posture.q, model.joints[root_id].idx_q
    q[start : start + 3] -= gap * (model.jointPlacements[root_id].rotation.T @ normal)
    return q


def _free_root(robot: RobotBase, name: str | None) -> int:
    """The free-flyer on the world of this name, or the only one."""
    model = robot.model
    free = [
        i
        for i, joint in enumerate(model.joints)
        if joint.shortname() == "JointModelFreeFlyer" and model.parents[i] == 0
    ]
    names = [model.names[i] for i in free]
    if name is not None and robot.joint_id(name, "stand") in free:
        return robot.joint_id(name)
    if name is not None or len(free) != 1:
        listed = ", ".join(map(quoted, names)) or "none"
        raise InputError(f"stand: root must be one of the robot's free-flyers: {listed}")
    return free[0]


def _gap(shape: Any, place: pin.SE3, plane: Any) -> float:
    """How far a piece of geometry at a place is above a half-space [m], negative below."""
    import coal

    if isinstance(shape, coal.BVHModelBase):
        corners = np.array(shape.vertices()) @ place.rotation.T + place.translation
        return float((corners @ np.array(plane.n)).min()) - float(plane.d)
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    request.enable_signed_distance = True
    at = coal.Transform3s(place.rotation, place.translation)
    return float(coal.distance(shape, at, plane, coal.Transform3s(), request, result))
