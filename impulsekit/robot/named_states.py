"""States of a robot by joint name, placements and velocities of its frames."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ..errors import InputError, a_thing, quoted, warn_of_setup
from . import state
from .arrays import array_of, read_only
from .base import RobotBase
from .placing import FrameVelocity, Placement, Posture
from .state import likely_degrees, likely_wxyz, outside_limits

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

# A velocity is reached to this share of it: rounding of a pseudoinverse near a singular pose.
REACHED = 1e-9
# Stands for "root_joint" where its velocity is given in world axes.
ROOT_WORLD = "root_world"


class RobotStates(RobotBase):
    """Geometry, configurations, velocities and placements."""

    @cached_property
    def collision_model(self) -> pin.GeometryModel:
        """The collision geometry, read on first access."""
        from .geometry import geometry_of

        return geometry_of(self, pin.GeometryType.COLLISION)

    @cached_property
    def visual_model(self) -> pin.GeometryModel:
        """The visual geometry, read on first access."""
        from .geometry import geometry_of

        return geometry_of(self, pin.GeometryType.VISUAL)

    def neutral(self) -> np.ndarray:
        """Return (nq,) Pinocchio's neutral configuration."""
        return pin.neutral(self.model)

    @cached_property
    def poses(self) -> Mapping[str, np.ndarray]:
        """The named poses of the robot's SRDF: (nq,) each, read-only, neutral elsewhere.

        Of a combined robot they are called "arm/home", with the other parts neutral.

        Example:
            >>> from impulsekit import Robot
            >>> talos = Robot.from_example("talos", root="freeflyer")
            >>> talos.poses["half_sitting"][2]
            np.float64(1.01927)
        """
        found = {}
        for prefix, srdf in self._srdfs:
            for name, values in srdf.poses.items():
                joints = {
                    prefix + joint: value
                    for joint, value in values.items()
                    if self._takes(prefix + joint, len(value))
                }
                found[prefix + name] = read_only(state.configuration(self, joints))
        return found

    def _takes(self, joint: str, count: int) -> bool:
        """Return whether the robot has such a joint: a pose may set one of another root."""
        joint_id = self._joint_ids.get(joint)
        return joint_id is not None and count in (1, self.model.nqs[joint_id])

    def configuration(
        self, by_name: Mapping[str, ArrayLike] | None = None, /, **joints: ArrayLike
    ) -> np.ndarray:
        """Return (nq,) a configuration by joint name, neutral elsewhere.

        Angles [rad] and lengths [m]. A continuous joint takes its angle, a planar root
        (x, y, angle), a free-flyer x, y, z and the quaternion x, y, z, w; both take a
        ``pin.SE3``, such as ``impulsekit.pose([0, 0, 1], rpy=[0, 0, 1.57])`` or
        ``robot.placement(q, frame).se3``. Names that are no Python identifiers go in a mapping:
        ``configuration({"arm/elbow": 0.3})``.

        Raises:
            UnknownNameError, ShapeError, NotFiniteError, StateError.

        Warns:
            SetupWarning: a named joint is outside its limits, or reads like degrees or like a
                quaternion w, x, y, z.
        """
        values = _values("configuration", by_name, joints)
        q = state.configuration(self, values)
        sentences = [*outside_limits(self, q, values), *likely_degrees(self, values)]
        warn_of_setup([*sentences, *likely_wxyz(self, q)])
        return q

    def velocity(
        self,
        by_name: Mapping[str, ArrayLike] | None = None,
        /,
        *,
        q: ArrayLike | None = None,
        **joints: ArrayLike,
    ) -> np.ndarray:
        """Return (nv,) a velocity by joint name, zero elsewhere [rad/s, m/s].

        ``root_world`` in place of ``root_joint`` ("arm/root_world" in a combined robot) takes the
        velocity of a free-flyer's origin and its angular velocity, both in world axes, at ``q``.

        Raises:
            UnknownNameError, ShapeError, NotFiniteError, StateError.
            InputError: ``root_world`` without q, or of a root that is no free-flyer.

        Example:
            >>> from impulsekit import Robot, pose
            >>> robot = Robot.from_example("talos", root="freeflyer")
            >>> q = robot.configuration(root_joint=pose(rpy=[0, 0, np.pi / 2]))
            >>> robot.velocity(root_world=[1, 0, 0, 0, 0, 0], q=q)[:3].round(6)
            array([ 0., -1.,  0.])
        """
        values = _values("velocity", by_name, joints)
        for name in [name for name in values if name.rpartition("/")[2] == ROOT_WORLD]:
            if name not in self._joint_ids:
                root = name.removesuffix(ROOT_WORLD) + "root_joint"
                values[root] = self._in_root(root, values.pop(name), q)
        return state.velocity(self, values)

    def _in_root(self, root: str, velocity: ArrayLike, q: ArrayLike | None) -> np.ndarray:
        """(6,) of a velocity in world axes what a free-flyer takes."""
        joint_id = self.joint_id(root, "velocity")
        if q is None or self.model.joints[joint_id].shortname() != "JointModelFreeFlyer":
            raise InputError(f'velocity: {ROOT_WORLD} needs q= and a free-flyer called "{root}"')
        numbers = array_of(velocity, (6,), f"velocity: {ROOT_WORLD}").reshape(2, 3)
        return (numbers @ Posture(self, q).joint(joint_id).rotation).ravel()

    def stand(self, q: ArrayLike, root: str | None = None) -> np.ndarray:
        """Return q (nq,) with a free part moved along the ground's normal until it just touches.

        The lowest point of all collision geometry on the free-flyer comes to lie on the ground
        (``with_ground``), from above or below; joints keep their angles.

        Args:
            q: (nq,) configuration.
            root: the free-flyer to move, such as "arm/root_joint"; None for the only one.

        Raises:
            InputError: no ground, no such free-flyer, or no geometry on it.
            ShapeError, NotFiniteError, StateError.

        Example:
            >>> from impulsekit import Robot
            >>> box = Robot.from_urdf("models/box.urdf", root="freeflyer").with_ground()
            >>> box.stand(box.neutral())[2].round(6)
            np.float64(0.05)
        """
        import coal

        posture, model = Posture(self, q), self.model
        root_id = self._free_root(root)
        objects = self.collision_model.geometryObjects
        grounds = [item for item in objects if isinstance(item.geometry, coal.Halfspace)]
        if not grounds:
            raise InputError("stand: the robot has no ground; robot.with_ground() gives one")
        carried = [item for item in objects if root_id in model.supports[item.parentJoint]]
        if not carried:
            raise InputError(f'stand: nothing on joint "{model.names[root_id]}" has geometry')
        plane, to_ground = grounds[0].geometry, grounds[0].placement.inverse()
        gap = min(
            _gap(item.geometry, to_ground * posture.joint(item.parentJoint) * item.placement, plane)
            for item in carried
        )
        q, start = posture.q, model.joints[root_id].idx_q
        normal = grounds[0].placement.rotation @ np.array(plane.n)
        q[start : start + 3] -= gap * (model.jointPlacements[root_id].rotation.T @ normal)
        return q

    def _free_root(self, name: str | None) -> int:
        """The free-flyer on the world of this name, or the only one."""
        model = self.model
        free = [
            i
            for i, joint in enumerate(model.joints)
            if joint.shortname() == "JointModelFreeFlyer" and model.parents[i] == 0
        ]
        if name is not None and self.joint_id(name, "stand") in free:
            return self.joint_id(name)
        if name is not None or len(free) != 1:
            known = ", ".join(quoted(model.names[i]) for i in free) or "none"
            raise InputError(f"stand: root must be one of the robot's free-flyers: {known}")
        return free[0]

    def placement(self, q: ArrayLike, frame: str) -> Placement:
        """Return the placement of a frame in the world at q.

        It has ``matrix`` (4, 4), ``position`` (3,) and ``rotation`` (3, 3); ``point(at)`` of it is
        where a point of the frame is.

        Raises:
            UnknownNameError, ShapeError, NotFiniteError, StateError.

        Example:
            >>> from impulsekit import Robot
            >>> panda = Robot.from_example("panda")
            >>> panda.placement(panda.neutral(), "panda_hand").position.round(3)[2]
            np.float64(0.926)
        """
        return Posture(self, q).placement(frame)

    def jacobian(self, q: ArrayLike, frame: str, at: ArrayLike = (0.0, 0.0, 0.0)) -> np.ndarray:
        """Return (6, nv) the Jacobian of a point of a frame at q, world axes.

        ``robot.jacobian(q, frame) @ v`` is the velocity of the point [m/s], then the angular
        velocity of the frame [rad/s].

        Args:
            q: (nq,) configuration.
            frame: the frame.
            at: (3,) the point in it [m].

        Raises:
            UnknownNameError, ShapeError, NotFiniteError, StateError.

        Example:
            >>> from impulsekit import Robot
            >>> panda = Robot.from_example("panda")
            >>> panda.jacobian(panda.neutral(), "panda_hand")[5].round(3)
            array([ 1.,  0.,  1.,  0.,  1.,  0., -1.,  0.,  0.])
        """
        frame_id = self.frame_id(frame, "jacobian")
        place = state.checked_configuration(self.model, q)
        own, axes = array_of(at, (3,), "jacobian: at"), pin.LOCAL_WORLD_ALIGNED
        data = self.model.createData()
        found = pin.computeFrameJacobian(self.model, data, place, frame_id, axes)
        arm = data.oMf[frame_id].rotation @ own
        found[:3] += np.cross(found[3:].T, arm).T
        return found

    def velocity_for(
        self,
        frame: str,
        *,
        q: ArrayLike,
        linear: ArrayLike | None = None,
        angular: ArrayLike | None = None,
        at: ArrayLike = (0.0, 0.0, 0.0),
        joints: Iterable[str] | None = None,
    ) -> np.ndarray:
        """Return (nv,) the least velocity that moves a point of a frame as asked.

        The least-norm solution of J v = (linear, angular), of what is given of the two, by the
        pseudoinverse of the Jacobian.

        Args:
            frame: the frame.
            q: (nq,) configuration.
            linear: (3,) velocity of the point, world axes [m/s]; None leaves it free.
            angular: (3,) angular velocity of the frame, world axes [rad/s]; None leaves it free.
            at: (3,) the point in the frame [m].
            joints: which joints move; None for all.

        Raises:
            InputError: neither velocity is given, or the joints cannot move the point so at q.
            UnknownNameError, ShapeError, NotFiniteError, StateError.

        Example:
            >>> from impulsekit import Robot
            >>> ur5 = Robot.from_example("ur5")
            >>> q = ur5.configuration(shoulder_lift_joint=-1.0, elbow_joint=1.2)
            >>> v = ur5.velocity_for("tool0", linear=[0.5, 0, 0], q=q)
            >>> ur5.velocity_of(q, v, "tool0").linear.round(9) + 0.0
            array([0.5, 0. , 0. ])
        """
        rows, asked = [], []
        matrix = self.jacobian(q, frame, at)
        for which, given, name in ((slice(3), linear, "linear"), (slice(3, 6), angular, "angular")):
            if given is not None:
                rows.append(matrix[which])
                asked.append(array_of(given, (3,), f"velocity_for: {name}"))
        if not rows:
            raise InputError("velocity_for: give linear=, angular=, or both")
        allowed = np.zeros(self.nv, dtype=bool)
        for name in self.joint_names if joints is None else joints:
            joint = self.model.joints[self.joint_id(name, "velocity_for")]
            allowed[joint.idx_v : joint.idx_v + joint.nv] = True
        whole, target = np.concatenate(rows)[:, allowed], np.concatenate(asked)
        v = np.zeros(self.nv)
        v[allowed] = np.linalg.lstsq(whole, target, rcond=None)[0]
        missed = float(np.linalg.norm(whole @ v[allowed] - target))
        if missed > REACHED * float(np.linalg.norm(target)):
            raise InputError(
                f'velocity_for: the joints cannot move "{frame}" so at this q: the nearest '
                f"velocity is off by {missed:.3g}; give fewer components, or another q"
            )
        return v

    def velocity_of(
        self, q: ArrayLike, v: ArrayLike, frame: str, at: ArrayLike = (0.0, 0.0, 0.0)
    ) -> FrameVelocity:
        """Return the velocity of a frame at q with v, world axes.

        Args:
            q: (nq,) configuration. v: (nv,) velocity.
            frame: the frame.
            at: (3,) the point in it [m] whose velocity ``linear`` is.

        Returns:
            ``linear`` (3,) of the point [m/s] and ``angular`` (3,) of the frame [rad/s].

        Raises:
            UnknownNameError, ShapeError, NotFiniteError, StateError.

        Example:
            >>> from impulsekit import Robot
            >>> panda = Robot.from_example("panda")
            >>> v = panda.velocity(panda_joint1=2.0)
            >>> hand = panda.velocity_of(panda.neutral(), v, "panda_hand")
            >>> hand.linear.round(3).tolist(), hand.angular.round(3).tolist()
            ([0.0, 0.176, 0.0], [0.0, 0.0, 2.0])
        """
        posture = Posture(self, q, v)
        return posture.velocity(frame, posture.placement(frame).point(at))


def _values(what: str, by_name: Any, joints: Mapping[str, Any]) -> dict[str, Any]:
    """Return what was given by joint name."""
    if not isinstance(by_name, Mapping | None):
        raise InputError(
            f"{what}: values are given by joint name, as in {what}(elbow=0.3) or "
            f"{what}({{...}}), got {a_thing(by_name)}; a full array needs no {what}()"
        )
    return {**(by_name or {}), **joints}


def _gap(shape: Any, place: pin.SE3, plane: Any) -> float:
    """Return how far a piece of geometry is above a half-space [m], negative below."""
    import coal

    if isinstance(shape, coal.BVHModelBase):
        corners = np.array(shape.vertices()) @ place.rotation.T + place.translation
        return float((corners @ np.array(plane.n)).min()) - float(plane.d)
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    request.enable_signed_distance = True
    at = coal.Transform3s(place.rotation, place.translation)
    return float(coal.distance(shape, at, plane, coal.Transform3s(), request, result))
