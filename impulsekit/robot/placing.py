"""Placements and velocities of frames, poses of free bodies, and ``place``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np
import pinocchio as pin

from ..errors import InputError, RangeError
from ..errors.calls import public
from .arrays import array_of, lock
from .base import RobotBase
from .state import OUT_OF_PLANE, checked_configuration, checked_velocity

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

# How far a rotation matrix or a quaternion may be off; it is made exact.
OFF_ROTATION = 1e-6

AnyRobot = TypeVar("AnyRobot", bound=RobotBase)


@dataclass(frozen=True, eq=False)
class Placement:
    """The placement of a frame in the world.

    Attributes:
        matrix: (4, 4) homogeneous: ``matrix @ [x, y, z, 1]`` takes the frame's coordinates to
            the world's, read-only.
    """

    matrix: np.ndarray

    @property
    def position(self) -> np.ndarray:
        """(3,) the frame's origin in the world [m]."""
        return self.matrix[:3, 3]

    @property
    def rotation(self) -> np.ndarray:
        """(3, 3) columns: the frame's axes in the world."""
        return self.matrix[:3, :3]

    @property
    def se3(self) -> pin.SE3:
        """The same as Pinocchio's type."""
        return pin.SE3(self.matrix)

    def point(self, at: Any) -> np.ndarray:
        """Return (3,) the point ``at`` of the frame in the world [m]."""
        return self.rotation @ array_of(at, (3,), "point") + self.position


@dataclass(frozen=True, eq=False)
class FrameVelocity:
    """The velocity of a frame, world axes.

    Attributes:
        linear: (3,) velocity of the point that was asked for [m/s], read-only.
        angular: (3,) angular velocity [rad/s], read-only.
    """

    linear: np.ndarray
    angular: np.ndarray


class Posture(Generic[AnyRobot]):
    """A robot at q with v: placements and velocities of frames.

    Args:
        robot: the robot.
        q: (nq,) configuration.
        v: (nv,) velocity; None for a robot at rest.

    Raises:
        ShapeError, NotFiniteError, StateError: what is wrong with q or v.

    Example:
        >>> from impulsekit import Robot
        >>> panda = Robot.from_example("panda")
        >>> Posture(panda, panda.neutral()).placement("panda_link1").position[2]
        np.float64(0.333)
    """

    def __init__(self, robot: AnyRobot, q: Any, v: Any = None) -> None:
        model = robot.model
        self.robot = robot
        self.q = checked_configuration(model, q)
        self.v = np.zeros(model.nv) if v is None else checked_velocity(model, v)
        # By joint: the placement of its frame, and its velocity in that frame.
        self._found: dict[int, tuple[pin.SE3, pin.Motion]] = {
            0: (pin.SE3.Identity(), pin.Motion.Zero())
        }

    def _at(self, joint_id: int) -> tuple[pin.SE3, pin.Motion]:
        """Only what carries a frame is computed, and no ``pin.Data`` is made."""
        found = self._found.get(joint_id)
        if found is None:
            model = self.robot.model
            place, motion = self._at(model.parents[joint_id])
            own = self._joint_data(joint_id)
            here = model.jointPlacements[joint_id] * own.M
            found = self._found[joint_id] = place * here, here.actInv(motion) + own.v
        return found

    def _joint_data(self, joint_id: int) -> Any:
        joint = self.robot.model.joints[joint_id]
        own = joint.createData()
        joint.calc(own, self.q, self.v)
        return own

    def joint_of(self, frame: str) -> int:
        """Return the index of the joint that carries a frame; 0 where it is fixed in the world."""
        return self.robot.frame(frame).joint_id

    def joint(self, joint_id: int) -> pin.SE3:
        """Return the placement of a joint's frame."""
        return self._at(joint_id)[0]

    def frame(self, name: str) -> pin.SE3:
        """Return the placement of a frame, as Pinocchio's type."""
        own = self.robot.frame(name)
        return self._at(own.joint_id)[0] * own.placement

    def placement(self, frame: str) -> Placement:
        """Return the placement of a frame."""
        matrix = self.frame(frame).homogeneous
        matrix.setflags(write=False)
        return Placement(matrix)

    def motion_subspace(self, joint_id: int) -> np.ndarray:
        """Return (6, nv) the directions of motion of a joint in its own axes, linear first."""
        return np.array(self._joint_data(joint_id).S).reshape(6, -1)

    def angular_velocity(self, joint_id: int) -> np.ndarray:
        """Return (3,) the angular velocity of a joint's child, world axes [rad/s]."""
        place, motion = self._at(joint_id)
        return place.rotation @ motion.angular

    def velocity_at(self, joint_id: int, point: np.ndarray) -> np.ndarray:
        """Return (3,) the velocity of a joint's child at ``point`` (3,) of the world [m/s]."""
        place, motion = self._at(joint_id)
        turning = np.cross(self.angular_velocity(joint_id), point - place.translation)
        return place.rotation @ motion.linear + turning

    def velocity(self, frame: str, point: np.ndarray) -> FrameVelocity:
        """Return the velocity of a frame, and of its point at ``point`` (3,) of the world."""
        joint_id = self.joint_of(frame)
        linear, angular = self.velocity_at(joint_id, point), self.angular_velocity(joint_id)
        lock(linear, angular)
        return FrameVelocity(linear, angular)


@public
def place(
    robot: RobotBase,
    q: ArrayLike,
    frame: str,
    *,
    at_frame: str = "world",
    at: ArrayLike = (0.0, 0.0, 0.0),
    point: ArrayLike = (0.0, 0.0, 0.0),
    rotation: ArrayLike | None = None,
) -> np.ndarray:
    """Place a free part of the world at a point of another frame: the configuration for it.

    Only the root joint of the part that carries ``frame`` is changed.

    Args:
        robot: two or more parts in one world, as ``impulsekit.combine`` makes them, or one that
            is placed in the world.
        q: (nq,) the configuration to start from.
        frame: of the part to be moved, whose root is a free-flyer, planar or a translation.
        at_frame: of another part, or "world".
        at: (3,) where in ``at_frame`` the point is to lie [m].
        point: (3,) in ``frame``, which comes to lie there [m].
        rotation: the axes of ``frame`` in those of ``at_frame``, as (3, 3) or a quaternion
            x, y, z, w; None keeps the orientation of the part in the world as in ``q``.

    Returns:
        (nq,) the configuration.

    Raises:
        InputError: the part has another root joint, or carries ``at_frame`` too.
        RangeError: a planar part would leave its plane.
        UnknownNameError, ShapeError, NotFiniteError, StateError.

    Example:
        >>> import impulsekit as ik
        >>> ball = ik.Robot.from_urdf("<robot name='b'><link name='ball'/></robot>", "freeflyer")
        >>> robot = ik.combine(arm=ik.Robot.from_example("panda"), ball=ball)
        >>> q = robot.configuration({"arm/panda_joint2": 0.3})
        >>> q = place(robot, q, "ball/ball", at_frame="arm/panda_hand", at=[0, 0, 0.1])
        >>> hand = robot.placement(q, "arm/panda_hand")
        >>> np.allclose(robot.placement(q, "ball/ball").position, hand.point([0, 0, 0.1]))
        True
    """
    at, point = array_of(at, (3,), "place: at"), array_of(point, (3,), "place: point")
    q = checked_configuration(robot.model, q)
    root_id, other_id = (_root_of(robot, name) for name in (frame, at_frame))
    if root_id == 0:
        raise InputError(f'place: "{frame}" is fixed in the world and cannot be moved')
    if root_id == other_id:
        raise InputError(
            f'place: "{frame}" and "{at_frame}" belong to one part, which moves as a whole'
        )
    root = robot.model.joints[root_id]
    kind = root.shortname()
    if kind not in _PLACED:
        raise InputError(
            f'place: "{frame}" is moved by joint "{robot.model.names[root_id]}" ({kind}); '
            "place moves free-flyers, planar roots and translations, other joints are set by "
            "robot.configuration"
        )
    axes = robot.model.jointPlacements[root_id].rotation
    posture = Posture(robot, q)
    target = posture.frame(at_frame)
    if rotation is not None:
        form = "xyzw" if np.shape(rotation) == (4,) else "rotation"
        turn = (
            target.rotation
            @ rotation_matrix(form, rotation, "place: rotation", unit=True)
            @ posture.frame(frame).rotation.T
        )
        _turn_root(q, root, axes.T @ turn @ posture.joint(root_id).rotation, frame)
        posture = Posture(robot, q)
    shift = axes.T @ (target.act(at) - posture.frame(frame).act(point))
    if kind == "JointModelPlanar" and abs(shift[2]) > OUT_OF_PLANE:
        raise RangeError.of(
            f'place: the way of "{frame}" out of the plane that its root moves in',
            f"{shift[2]:.6g} m",
            f"within {OUT_OF_PLANE:g} m",
        )
    count = 2 if kind == "JointModelPlanar" else 3
    q[root.idx_q : root.idx_q + count] += shift[:count]
    return q


_PLACED = ("JointModelFreeFlyer", "JointModelPlanar", "JointModelTranslation")


def _root_of(robot: RobotBase, frame: str) -> int:
    """The joint on the world that a frame hangs on; 0 where it is fixed in the world."""
    joint_id = robot.frame(frame, "place").joint_id
    while joint_id > 0 and robot.model.parents[joint_id] > 0:
        joint_id = robot.model.parents[joint_id]
    return joint_id


def _turn_root(q: np.ndarray, root: pin.JointModel, turn: np.ndarray, frame: str) -> None:
    """Write a rotation (3, 3) of a root, in the axes of its joint, into q."""
    kind, start = root.shortname(), root.idx_q
    if kind == "JointModelFreeFlyer":
        q[start + 3 : start + 7] = pin.Quaternion(turn).normalized().coeffs()
        return
    tilt = float(np.linalg.norm(turn[:, 2] - [0.0, 0.0, 1.0]))
    if kind == "JointModelTranslation":
        tilt = float(np.linalg.norm(turn - np.eye(3)))
    if tilt > OUT_OF_PLANE:
        raise RangeError.of(
            f'place: the turn of "{frame}" that its root cannot make',
            f"{tilt:.6g} rad",
            f"within {OUT_OF_PLANE:g} rad",
        )
    if kind == "JointModelPlanar":
        angle = np.arctan2(turn[1, 0], turn[0, 0])
        q[start + 2 : start + 4] = np.cos(angle), np.sin(angle)


@public
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
        turn = rotation_matrix(name, given[name], f"pose: {name}")
    return pin.SE3(turn, array_of(xyz, (3,), "pose: xyz"))


def rotation_matrix(
    form: str, value: Any, what: str, *, unit: bool = False, most: float = OFF_ROTATION
) -> np.ndarray:
    """Return (3, 3) of a rotation in one of the forms of ``pose``.

    ``unit`` quaternions are proved to be so; ``most`` is how far a matrix may be off.
    """
    if form == "rotation":
        turn = array_of(value, (3, 3), what)
        off = float(np.abs(turn @ turn.T - np.eye(3)).max())
        if off > most or np.linalg.det(turn) < 0.0:
            raise InputError(
                f"{what} is no rotation matrix (R Rᵀ is off 1 by {off:.3g}, or it mirrors)"
            )
        return turn
    numbers = array_of(value, (4,) if form in ("wxyz", "xyzw") else (3,), what)
    if form == "rpy":
        return np.array(pin.rpy.rpyToMatrix(*numbers))
    if form == "rotation_vector":
        return np.array(pin.exp3(numbers))
    x, y, z, w = np.roll(numbers, -1) if form == "wxyz" else numbers
    length = float(np.linalg.norm(numbers))
    if length == 0.0 or (unit and abs(length - 1.0) > OFF_ROTATION):
        allowed = "1" if unit else "above zero"
        raise RangeError.of(f"{what}: length of the quaternion", length, allowed)
    return np.array(pin.Quaternion(w, x, y, z).normalized().toRotationMatrix())
