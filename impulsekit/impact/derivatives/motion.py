"""Twists of bodies and how they change with the configuration, on its tangent space.

The work is Pinocchio's: Jacobians of points, and the derivatives of their velocities at
given speeds (Carpentier & Mansard 2018). Points are fixed in their bodies, axes are the
world's.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from .expanded import ExpandedModel

__all__ = ["Motion"]

_WORLD, _ALIGNED = pin.WORLD, pin.LOCAL_WORLD_ALIGNED
# Bound once: these are called for every body of every impact.
_set_places = pin.computeJointJacobians
_set_speed = pin.computeForwardKinematicsDerivatives
_frame_jacobian = pin.getFrameJacobian
_point_velocity_derivatives = pin.getPointVelocityDerivatives
_joint_velocity_derivatives = pin.getJointVelocityDerivatives


class Motion:
    """A robot at one configuration and at speeds that may be set anew.

    Attributes:
        placements: of the joints.
        speeds: (nv,) v; None where they were not given, or have been overwritten.
        zero: (6, nv) zeros.
    """

    def __init__(
        self,
        expanded: ExpandedModel,
        data: pin.Data,
        q: np.ndarray,
        v: np.ndarray | None = None,
    ) -> None:
        self._expanded, self._model, self._data = expanded, expanded.model, data
        self._q = q
        self.speeds: np.ndarray | None = None
        if v is None:
            # Places alone are quicker.
            _set_places(self._model, data, q)
        else:
            self.set_speed(v)
        self.placements = data.oMi
        self.zero = expanded.nothing

    def set_speed(self, v: np.ndarray) -> None:
        """Let it move with v (nv,), an array that stays as it is, from now on."""
        if v is self.speeds:
            return
        self.speeds = v
        expanded = self._expanded
        _set_speed(self._model, self._data, self._q, expanded.speeds(v), expanded.still)

    def forget_speed(self) -> None:
        """Take it that other work has overwritten the speeds in Pinocchio's data."""
        self.speeds = None

    def jacobians(self, joint_id: int, point: pin.SE3) -> tuple[np.ndarray, np.ndarray]:
        """How a point of a body moves and turns with the configuration.

        (6, ·) with that of the expanded model and (6, nv) with that of the robot.
        """
        found = _frame_jacobian(self._model, self._data, joint_id, point, _ALIGNED)
        # With one degree of freedom Pinocchio gives (6,) for (6, 1).
        found = found.reshape(6, -1)
        return found, self._expanded.columns(found)

    def change_of_velocity(self, joint_id: int, point: pin.SE3) -> np.ndarray:
        """(3, nv) ∂(velocity of a point of a body)/∂q."""
        by_q, _ = _point_velocity_derivatives(self._model, self._data, joint_id, point, _ALIGNED)
        return self._expanded.columns(by_q.reshape(3, -1))

    def change_of_turning(self, joint_id: int) -> np.ndarray:
        """(3, nv) ∂ω/∂q of a body."""
        by_q, _ = _joint_velocity_derivatives(self._model, self._data, joint_id, _WORLD)
        return self._expanded.columns(by_q.reshape(6, -1)[3:])

    def turning(self, joint_id: int) -> np.ndarray:
        """(3,) ω of a body."""
        return self.placements[joint_id].rotation @ self._data.v[joint_id].angular
