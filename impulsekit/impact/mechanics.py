"""Mass matrix, placements and Jacobians of the whole robot at one configuration."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ..scene import AppliedImpulse
from .algorithms import symmetric
from .origin import at_origin, bring_roots_to_origin, root_translations

if TYPE_CHECKING:
    from ..scene import Scene

__all__ = ["Mechanics"]

_REFERENCE = {"world": pin.LOCAL_WORLD_ALIGNED, "local": pin.LOCAL}


class Mechanics:
    """The robot of a scene at q, for what is asked of an impact after it was solved.

    It has a workspace of its own, so it stays true whatever is solved next.
    """

    def __init__(self, scene: Scene, q: np.ndarray) -> None:
        self.scene = scene
        self.model = scene.robot.model
        self._q = q

    @cached_property
    def _model_at_origin(self) -> pin.Model:
        model = pin.Model(self.model)
        bring_roots_to_origin(model)
        return model

    @cached_property
    def _q_at_origin(self) -> np.ndarray:
        return at_origin(self._q, root_translations(self.model))

    @cached_property
    def _data(self) -> pin.Data:
        """Pinocchio's data with the joint Jacobians at q, all roots at the origin."""
        data = self.model.createData()
        pin.computeJointJacobians(self._model_at_origin, data, self._q_at_origin)
        return data

    @cached_property
    def _placements(self) -> list[pin.SE3]:
        data = self.model.createData()
        pin.forwardKinematics(self.model, data, self._q)
        return list(data.oMi)

    @cached_property
    def mass_matrix(self) -> np.ndarray:
        """(nv, nv) the generalized masses a_lp (Chang & Huston 1995, eq. (30)), symmetric."""
        data = self.model.createData()
        return symmetric(pin.crba(self.model, data, self._q).reshape(self.model.nv, -1))

    def frame_placement(self, frame: str) -> pin.SE3:
        """The placement of a frame in the world."""
        item = self.model.frames[self.scene.robot.frame_id(frame)]
        return self._placements[item.parentJoint] * item.placement

    def point_jacobian(self, frame: str, at: np.ndarray, axes: str = "world") -> np.ndarray:
        """(6, nv) Jacobian of a point of a frame, linear before angular, in ``axes``."""
        item = self.model.frames[self.scene.robot.frame_id(frame)]
        placement = item.placement * pin.SE3(np.eye(3), np.asarray(at, dtype=float))
        jacobian = pin.getFrameJacobian(
            self._model_at_origin, self._data, item.parentJoint, placement, _REFERENCE[axes]
        )
        # With one degree of freedom Pinocchio gives (6,) for (6, 1).
        return jacobian.reshape(6, -1)

    def impulse_jacobian(self, entry: AppliedImpulse) -> np.ndarray:
        """(6, nv) Jacobian of the struck point in the axes of the impulse."""
        return self.point_jacobian(entry.frame, np.array(entry.at), entry.axes)

    def generalized_impulse(self) -> np.ndarray:
        """(nv,) I = Jᵀp summed over the scene's impulses (Chang & Huston 1995, eq. (18))."""
        total = np.zeros(self.model.nv)
        for entry in self.scene.impulses:
            if isinstance(entry, AppliedImpulse):
                total += np.array([*entry.linear, *entry.angular]) @ self.impulse_jacobian(entry)
            else:
                total[self.joint_rows(entry.joint)] += entry.impulse
        return total

    def joint_rows(self, joint: str) -> slice:
        """Where a joint's degrees of freedom stand in v."""
        item = self.model.joints[self.scene.robot.joint_id(joint)]
        return slice(item.idx_v, item.idx_v + item.nv)

    def impulse_scale(self) -> np.ndarray:
        """(nv,) the sum of the absolute terms that make up each row of I."""
        total = np.zeros(self.model.nv)
        for entry in self.scene.impulses:
            if isinstance(entry, AppliedImpulse):
                wrench = np.abs([*entry.linear, *entry.angular])
                total += wrench @ np.abs(self.impulse_jacobian(entry))
            else:
                total[self.joint_rows(entry.joint)] += np.abs(entry.impulse)
        return total
