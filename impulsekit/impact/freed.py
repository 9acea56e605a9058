"""The impulse in a joint by the paper's way: the joint is freed.

Chang & Huston 1995: for a moment the joint's constrained directions become
generalized speeds (six more at most), the unknown constraint impulses act there as if
they came from outside, and Δ of the freed speeds is prescribed to be zero. With relative
speeds as coordinates each unknown stands alone in its own added equation,

    P_f = a_fp Δy_p − I_f.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ..errors import InputError
from ..formatting import OneLine
from ..robot.arrays import lock
from ..robot.masses import symmetric
from ..scene.numbers import vector
from .forces import body_impulses

if TYPE_CHECKING:
    from .result import Impact

__all__ = ["FreedJoint", "freed_joint"]


@dataclass(frozen=True, eq=False, repr=False)
class FreedJoint(OneLine):
    """The impulse of a joint, found by freeing it.

    Attributes:
        joint: its name.
        impulse: (6,) wrench the parent gives the child at the joint's origin, world axes,
            linear [N s] before angular [N m s], read-only.
        motion: (6, k) the directions in which the joint is free, world axes, read-only;
            along them it carries only its own impulse (a kick, a lock).
    """

    joint: str
    impulse: np.ndarray
    motion: np.ndarray

    def along(self, linear: Any = (0.0, 0.0, 0.0), angular: Any = (0.0, 0.0, 0.0)) -> float:
        """The impulse along one direction, in world axes: a unit vector, linear or angular.

        Raises:
            InputError: no direction, or a linear and an angular one at once.
        """
        direction = np.array([*vector(linear, "linear"), *vector(angular, "angular")])
        lengths = np.linalg.norm(direction[:3]), np.linalg.norm(direction[3:])
        if (lengths[0] > 0.0) == (lengths[1] > 0.0):
            raise InputError("along takes one direction, linear or angular")
        return float(direction @ self.impulse / max(lengths))


def freed_joint(impact: Impact, joint: str) -> FreedJoint:
    """Free a joint and solve for what it carried (Chang & Huston 1995, constraint impulses).

    Args:
        impact: a solved impact.
        joint: a moving joint of the robot.

    Raises:
        UnknownNameError: the robot has no such joint.
        InputError: the robot has joints that mimic others.

    Example:
        >>> from impulsekit import AppliedImpulse, Robot, Scene, solve
        >>> from impulsekit.models import pendulum_urdf
        >>> rod = Robot.from_urdf(pendulum_urdf(1))
        >>> blow = AppliedImpulse("link_1", linear=[3, 0, 0], at=[0, 0, -1])
        >>> impact = solve(Scene(rod, [blow]), rod.neutral(), rod.velocity())
        >>> round(freed_joint(impact, "joint_1").along(linear=[1, 0, 0]), 12)
        1.5
    """
    robot = impact.scene.robot
    joint_id = robot.joint_id(joint)
    if any(item.shortname() == "JointModelMimic" for item in robot.model.joints):
        raise InputError("freed_joint does not take mimic joints; use impact.reactions")
    free_model, free_q, spread = _with_free_joint(impact, joint_id)
    data = free_model.createData()
    pin.computeJointJacobians(free_model, data, free_q)
    impulse = np.zeros(free_model.nv)
    for item in body_impulses(impact):
        if item.joint_id > 0:
            jacobian = pin.getJointJacobian(free_model, data, item.joint_id, pin.LOCAL)
            impulse += item.wrench_in_joint.vector @ jacobian
    masses = symmetric(pin.crba(free_model, free_model.createData(), free_q))
    first = free_model.idx_vs[joint_id]
    added = slice(first, first + 6)
    wrench = (masses @ (spread @ impact.dv) - impulse)[added]
    rotation = np.kron(np.eye(2), impact.mechanics.joint_rotations[joint_id])
    own = slice(
        robot.model.idx_vs[joint_id], robot.model.idx_vs[joint_id] + robot.model.nvs[joint_id]
    )
    result, motion = rotation @ wrench, rotation @ spread[added, own]
    lock(result, motion)
    return FreedJoint(joint, result, motion)


def _with_free_joint(impact: Impact, freed: int) -> tuple[pin.Model, np.ndarray, np.ndarray]:
    """The model with one joint replaced by a free one, its q, and E with y_free = E y."""
    model = impact.mechanics.model_without_gravity
    data = model.createData()
    pin.forwardKinematics(model, data, impact.q)
    free_model = pin.Model()
    free_model.gravity.setZero()
    entries = []
    for joint_id in range(1, model.njoints):
        joint = model.joints[joint_id]
        placement = model.jointPlacements[joint_id]
        own = impact.q[joint.idx_q : joint.idx_q + joint.nq]
        kind: Any = joint
        if joint_id == freed:
            kind = pin.JointModelFreeFlyer()
            own = pin.SE3ToXYZQUAT(placement.inverse() * data.liMi[joint_id])
        free_model.addJoint(model.parents[joint_id], kind, placement, model.names[joint_id])
        free_model.appendBodyToJoint(joint_id, model.inertias[joint_id], pin.SE3.Identity())
        entries.append(own)
    spread = np.zeros((free_model.nv, model.nv))
    for joint_id in range(1, model.njoints):
        joint = model.joints[joint_id]
        rows = slice(
            free_model.idx_vs[joint_id], free_model.idx_vs[joint_id] + free_model.nvs[joint_id]
        )
        columns = slice(joint.idx_v, joint.idx_v + joint.nv)
        if joint_id == freed:
            # The joint's own motion subspace, in the child's frame.
            spread[rows, columns] = np.asarray(data.joints[joint_id].S).reshape(6, joint.nv)
        else:
            spread[rows, columns] = np.eye(joint.nv)
            free_model.armature[rows] = model.armature[columns]
    return free_model, np.concatenate(entries), spread
